// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "nacelle/host/graph.hpp"
#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

/// The links of a broker. Its lock comes last in the lock order, except for a listener's own.
/// Threads: any.
class GraphWatch final {
 public:
  void add(std::uint32_t link, GraphListener& listener);
  /// Removes a link. After this has returned, its listener is not called any more.
  void remove(std::uint32_t link);
  void made(const EndpointInfo& endpoint) const;
  /// Notifies one link only.
  void made(const EndpointInfo& endpoint, std::uint32_t link) const;
  void gone(std::uint64_t id) const;
  void gate(std::uint64_t reader, bool open) const;
  void life(std::uint64_t writer) const;
  void left(std::uint64_t reader, std::uint32_t via) const;

 private:
  mutable FutexMutex mutex_;
  std::vector<std::pair<std::uint32_t, GraphListener*>> listeners_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::runtime
