// SPDX-License-Identifier: Apache-2.0
#include "writer_port.hpp"

#include <limits>

#include "ordering.hpp"
#include "transport_iceoryx/wire/chunk.hpp"

namespace nacelle::transport_iceoryx {

WriterPort::WriterPort(iox::popo::PublisherPortData& data)
    : port_(iox::cxx::not_null<iox::popo::PublisherPortData* const>(&data)) {
  for (Prepared& one : prepared_) one.port = this;
}

WriterPort::~WriterPort() { port_.destroy(); }

void WriterPort::close() {
  {
    const LockGuard lock(mutex_);
    port_.stopOffer();
    closed_ = true;
    if (in_use_ != 0) return;
  }
  delete this;
}

WriterPort::Loan WriterPort::allocate(std::size_t bytes, Chunk*& chunk) {
  if (bytes > std::numeric_limits<std::uint32_t>::max() - 2 * kPartAlignment) return Loan::TooLarge;
  auto made = port_.tryAllocateChunk(static_cast<std::uint32_t>(bytes), kPartAlignment);
  if (made.has_error()) {
    return made.get_error() == iox::popo::AllocationError::NO_MEMPOOLS_AVAILABLE ? Loan::TooLarge : Loan::NoneLeft;
  }
  chunk = made.value();
  take_over(chunk);
  return Loan::Ok;
}

WriterPort::Loan WriterPort::loan(std::size_t bytes, Chunk*& chunk) {
  const LockGuard lock(mutex_);
  return allocate(bytes, chunk);
}

void WriterPort::send(Chunk& chunk) {
  const LockGuard lock(mutex_);
  hand_over(&chunk);
  port_.sendChunk(&chunk);
}

WriterPort::Prepared* WriterPort::prepare(std::size_t bytes, std::size_t uses) {
  const LockGuard lock(mutex_);
  for (Prepared& one : prepared_) {
    if (one.chunk != nullptr) continue;
    if (allocate(bytes, one.chunk) != Loan::Ok) return nullptr;
    one.begin = static_cast<std::uint8_t*>(one.chunk->userPayload());
    one.bytes = bytes;
    one.uses = uses;
    one.sent = false;
    ++in_use_;
    return &one;
  }
  return nullptr;
}

WriterPort::Prepared* WriterPort::find(const void* address) {
  const LockGuard lock(mutex_);
  for (Prepared& one : prepared_) {
    if (one.chunk != nullptr && !one.sent && address >= one.begin && address < one.begin + one.bytes) return &one;
  }
  return nullptr;
}

void WriterPort::send(Prepared& prepared) {
  const LockGuard lock(mutex_);
  prepared.sent = true;
  hand_over(prepared.chunk);
  port_.sendChunk(prepared.chunk);
}

void WriterPort::back(Prepared& prepared) noexcept {
  {
    const LockGuard lock(mutex_);
    if (--prepared.uses != 0) return;
    hand_over(prepared.chunk);
    if (!prepared.sent) port_.releaseChunk(prepared.chunk);
    prepared.chunk = nullptr;
    if (--in_use_ != 0 || !closed_) return;
  }
  delete this;
}

}  // namespace nacelle::transport_iceoryx
