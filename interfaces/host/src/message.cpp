// SPDX-License-Identifier: Apache-2.0
#include "nacelle/host/message.hpp"

#include <thread>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle {
namespace {

constexpr std::uint8_t kNone = 0, kMaking = 1, kMade = 2;  // Block::shared_state

struct LeaveAlone {
  void operator()(const void*) const noexcept {}
};

void send_home(Block& block) noexcept { block.home->reclaim(block); }

// Places the shared_ptr's control block into the envelope. The envelope goes home in deallocate(), not in the deleter: the
// control block is still touched after the deleter ran.
template <typename T>
struct EnvelopeAllocator {
  using value_type = T;
  Block* block;

  explicit EnvelopeAllocator(Block* b) : block(b) {}
  template <typename U>
  EnvelopeAllocator(const EnvelopeAllocator<U>& other) : block(other.block) {}  // NOLINT(google-explicit-constructor)

  T* allocate(std::size_t) {
    static_assert(sizeof(T) <= sizeof(Block::shared_control), "the envelope's place for a control block is too small");
    return reinterpret_cast<T*>(block->shared_control);
  }
  void deallocate(T*, std::size_t) noexcept { send_home(*block); }
  template <typename U>
  bool operator==(const EnvelopeAllocator<U>& other) const {
    return block == other.block;
  }
};

}  // namespace

std::shared_ptr<const void> share_block(Block& block) {
  std::uint8_t expected = kNone;
  if (block.shared_state.load(std::memory_order_acquire) != kMade) {
    if (block.shared_state.compare_exchange_strong(expected, kMaking, std::memory_order_acq_rel)) {
      block.shared = std::shared_ptr<const void>(block.message, LeaveAlone{}, EnvelopeAllocator<std::byte>{&block});
      block.shared_state.store(kMade, std::memory_order_release);
    } else {
      // Another reader's thread makes it right now; that takes nanoseconds.
      while (block.shared_state.load(std::memory_order_acquire) != kMade) std::this_thread::yield();
    }
  }
  return block.shared;
}

void detail::last_reference_dropped(Block& block) noexcept {
  if (block.shared_state.load(std::memory_order_relaxed) != kMade) {
    send_home(block);
    return;
  }
  // From here on only shared_ptrs hold the message; the last of them sends the envelope home.
  std::shared_ptr<const void> last = std::move(block.shared);
  block.shared_state.store(kNone, std::memory_order_relaxed);
}

}  // namespace nacelle
