// SPDX-License-Identifier: Apache-2.0
#include "reader_port.hpp"

#include "ordering.hpp"

namespace nacelle::transport_iceoryx {

void ReaderPort::Hold::drop(std::size_t uses) noexcept {
  if (uses != 0 && uses_.fetch_sub(uses, std::memory_order_acq_rel) == uses) port_->back(*this);
}

ReaderPort::ReaderPort(iox::popo::SubscriberPortData& data, std::size_t most_held)
    : port_(iox::cxx::not_null<iox::popo::SubscriberPortData* const>(&data)),
      holds_(std::make_unique<Hold[]>(most_held)) {
  free_.reserve(most_held);
  for (std::size_t i = 0; i < most_held; ++i) {
    holds_[i].port_ = this;
    free_.push_back(&holds_[i]);
  }
}

ReaderPort::~ReaderPort() { port_.destroy(); }

void ReaderPort::close() {
  {
    const LockGuard lock(mutex_);
    port_.unsetConditionVariable();
    port_.unsubscribe();
    port_.releaseQueuedChunks();
    closed_ = true;
    if (held_ != 0) return;
  }
  delete this;
}

ReaderPort::Chunk* ReaderPort::take() {
  const LockGuard lock(mutex_);
  const auto taken = port_.tryGetChunk();
  if (taken.has_error()) return nullptr;
  take_over(taken.value());
  return taken.value();
}

void ReaderPort::give_back(Chunk& chunk) {
  const LockGuard lock(mutex_);
  hand_over(&chunk);
  port_.releaseChunk(&chunk);
}

ReaderPort::Hold* ReaderPort::hold(Chunk& chunk, std::size_t uses) {
  const LockGuard lock(mutex_);
  if (free_.empty()) return nullptr;
  Hold* const hold = free_.back();
  free_.pop_back();
  ++held_;
  hold->chunk_ = &chunk;
  hold->uses_.store(uses, std::memory_order_relaxed);
  return hold;
}

void ReaderPort::back(Hold& hold) noexcept {
  {
    const LockGuard lock(mutex_);
    hand_over(hold.chunk_);
    port_.releaseChunk(hold.chunk_);
    free_.push_back(&hold);  // the room is reserved
    if (--held_ != 0 || !closed_) return;
  }
  delete this;
}

bool ReaderPort::was_overrun() {
  const LockGuard lock(mutex_);
  return port_.hasLostChunksSinceLastCall();
}

void ReaderPort::notify(iox::popo::ConditionVariableData& condition, std::size_t index) {
  const LockGuard lock(mutex_);
  port_.setConditionVariable(condition, index);
}

ByteView payload_of(const iox::mepoo::ChunkHeader& chunk) {
  const auto* const begin = reinterpret_cast<const std::uint8_t*>(&chunk);
  const auto* const payload = static_cast<const std::uint8_t*>(chunk.userPayload());
  const std::size_t whole = chunk.chunkSize(), bytes = chunk.userPayloadSize();
  if (payload < begin + sizeof(iox::mepoo::ChunkHeader) || payload > begin + whole) return {};
  if (bytes > whole - static_cast<std::size_t>(payload - begin)) return {};
  return {payload, bytes};
}

}  // namespace nacelle::transport_iceoryx
