// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"

namespace nacelle::session {

/// Publishes on /diagnostics that the wall clock was set: one message per step, named clock_jump.
/// Threads: one. The transport must outlive this object.
class ClockJumpReport {
 public:
  /// `node`: the container's own, with its namespace.
  ClockJumpReport(Transport& transport, std::string container, std::string node)
      : transport_(transport), container_(std::move(container)), node_(std::move(node)) {}

  /// Publishes a step. Returns the line for the log.
  std::string tell(Duration step, WallTime now);

 private:
  Transport& transport_;
  const std::string container_, node_;
  std::unique_ptr<Writer> writer_;  // created at the first step, which most robots never have
};

}  // namespace nacelle::session
