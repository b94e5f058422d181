// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/pool.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "nacelle/base/buffer.hpp"
#include "nacelle/base/expect.hpp"

namespace nacelle::runtime {

struct MessagePool::Envelope : Block {
  Envelope* next = nullptr;
  bool pooled = false;  // the message is stored behind the envelope; otherwise it is adopted, or gone
};

namespace {

std::size_t round_up(std::size_t n, std::size_t alignment) { return (n + alignment - 1) / alignment * alignment; }

}  // namespace

MessagePool::~MessagePool() {
  NACELLE_EXPECT(outstanding() == 0, "a pool outlives its messages");
  if (spare_ != nullptr) {
    auto* const spare = static_cast<Envelope*>(spare_);
    spare->next = std::exchange(free_pooled_, spare);
  }
  for (Envelope* list : {free_pooled_, free_bare_}) {
    while (list != nullptr) {
      Envelope* const next = list->next;
      dispose(list);
      list = next;
    }
  }
}

void MessagePool::dispose(Envelope* envelope) {
  if (envelope->pooled) type_.destroy(envelope->message);
  const std::align_val_t alignment{std::max(alignof(Envelope), type_.alignment)};
  envelope->~Envelope();
  ::operator delete(static_cast<void*>(envelope), alignment);
}

void MessagePool::collect() {
  Envelope* list = returned_.exchange(nullptr, std::memory_order_acquire);
  while (list != nullptr) {
    Envelope* const next = list->next;
    ++free_count_;
    if (list == spare_) [[unlikely]] {
      spare_is_out_ = false;
    } else {
      Envelope*& home = list->pooled ? free_pooled_ : free_bare_;
      list->next = home;
      home = list;
    }
    list = next;
  }
}

MessagePool::Envelope* MessagePool::take_free(bool with_message) {
  Envelope*& list = with_message ? free_pooled_ : free_bare_;
  if (list == nullptr) collect();
  if (list == nullptr) return nullptr;
  --free_count_;
  return std::exchange(list, list->next);
}

MessagePool::Envelope* MessagePool::make_pooled() {
  const std::size_t alignment = std::max(alignof(Envelope), type_.alignment);
  const std::size_t offset = round_up(sizeof(Envelope), type_.alignment);
  void* const memory = ::operator new (offset + type_.size, std::align_val_t{alignment});
  auto* const envelope = new (memory) Envelope;
  envelope->home = this;
  envelope->message = static_cast<std::byte*>(memory) + offset;
  envelope->pooled = true;
  try {
    type_.construct(envelope->message);
  } catch (...) {
    envelope->~Envelope();
    ::operator delete (memory, std::align_val_t{alignment});
    throw;
  }
  made_.fetch_add(1, std::memory_order_relaxed);
  return envelope;
}

Block* MessagePool::borrow_regular() {
  Envelope* envelope = take_free(true);
  if (envelope == nullptr) {
    if (pooled_ >= limit_) return nullptr;
    envelope = make_pooled();
    ++pooled_;
  }
#ifndef NDEBUG
  type_.poison(envelope->message);
#endif
  return envelope;
}

Block* MessagePool::borrow() {
  Block* const block = borrow_regular();
  if (block != nullptr || spare_is_out_) return block;
  spare_is_out_ = true;
  --free_count_;
  return spare_;
}

void MessagePool::set_limit(std::size_t messages) {
  limit_ = messages;
  if (spare_ != nullptr) return;
  spare_ = make_pooled();
  ++free_count_;
}

void MessagePool::reserve(std::size_t envelopes, const void* like) {
  const ReservingCopies only_memory;
  while (pooled_ < envelopes) {
    Envelope* const envelope = make_pooled();
    ++pooled_;
    type_.copy_assign(envelope->message, like);
    envelope->next = free_pooled_;
    free_pooled_ = envelope;
    ++free_count_;
  }
}

void MessagePool::warm(const void* like, std::size_t most) {
  const ReservingCopies only_memory;
  collect();
  Envelope** at = &free_pooled_;
  for (; *at != nullptr && most != 0; at = &(*at)->next, --most) type_.copy_assign((*at)->message, like);
  while (*at != nullptr) {
    Envelope* const spent = std::exchange(*at, (*at)->next);
    dispose(spent);
    --free_count_;
    --pooled_;
    ++disposed_;
  }
}

Block* MessagePool::adopt(void* message) {
  Envelope* envelope = take_free(false);
  if (envelope == nullptr) {
    const std::align_val_t alignment{std::max(alignof(Envelope), type_.alignment)};
    envelope = new (::operator new(sizeof(Envelope), alignment)) Envelope;
    envelope->home = this;
    made_.fetch_add(1, std::memory_order_relaxed);
  }
  envelope->message = message;
  return envelope;
}

// Releases what must not stay until the message's next use.
[[gnu::noinline]] void MessagePool::let_go(Envelope& envelope) noexcept {
  if (envelope.pooled) return type_.recycle(envelope.message);
  type_.destroy(envelope.message);
  if (type_.alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__) {
    ::operator delete (envelope.message, std::align_val_t{type_.alignment});
  } else {
    ::operator delete(envelope.message);
  }
  envelope.message = nullptr;
}

void MessagePool::reclaim(Block& block) noexcept {
  auto& envelope = static_cast<Envelope&>(block);
  if (!envelope.pooled || type_.holds_buffers) [[unlikely]]
    let_go(envelope);
  Envelope* head = returned_.load(std::memory_order_relaxed);
  do {
    envelope.next = head;
  } while (!returned_.compare_exchange_weak(head, &envelope, std::memory_order_release, std::memory_order_relaxed));
}

std::size_t MessagePool::outstanding() {
  collect();
  return made_.load(std::memory_order_relaxed) - disposed_ - free_count_;
}

}  // namespace nacelle::runtime
