// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/graph_watch.hpp"

#include "nacelle/base/mutex.hpp"

namespace nacelle::runtime {

void GraphWatch::add(std::uint32_t link, GraphListener& listener) {
  const LockGuard lock(mutex_);
  listeners_.emplace_back(link, &listener);
}

void GraphWatch::remove(std::uint32_t link) {
  const LockGuard lock(mutex_);
  std::erase_if(listeners_, [&](const auto& entry) { return entry.first == link; });
}

void GraphWatch::made(const EndpointInfo& endpoint) const {
  const LockGuard lock(mutex_);
  for (const auto& [link, listener] : listeners_) listener->on_made(endpoint);
}

void GraphWatch::made(const EndpointInfo& endpoint, std::uint32_t link) const {
  const LockGuard lock(mutex_);
  for (const auto& [number, listener] : listeners_) {
    if (number == link) listener->on_made(endpoint);
  }
}

void GraphWatch::gone(std::uint64_t id) const {
  const LockGuard lock(mutex_);
  for (const auto& [link, listener] : listeners_) listener->on_gone(id);
}

void GraphWatch::gate(std::uint64_t reader, bool open) const {
  const LockGuard lock(mutex_);
  for (const auto& [link, listener] : listeners_) listener->on_gate(reader, open);
}

void GraphWatch::life(std::uint64_t writer) const {
  const LockGuard lock(mutex_);
  for (const auto& [link, listener] : listeners_) listener->on_life(writer);
}

void GraphWatch::left(std::uint64_t reader, std::uint32_t via) const {
  const LockGuard lock(mutex_);
  for (const auto& [link, listener] : listeners_) {
    if (link == via) listener->on_left(reader);
  }
}

}  // namespace nacelle::runtime
