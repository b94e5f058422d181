// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/node/parameter.hpp"

namespace nacelle::runtime {

/// Tells /parameter_events what becomes of a node's parameters. While nobody reads it costs a look at their number.
/// Threads: any; the store may keep it for longer than the node's topic is there.
class ParameterEvents final : public ParameterListener {
 public:
  ParameterEvents(Transport& transport, const Clock& clock, std::string node);
  void on_change(const ParameterChange& change) noexcept override;
  /// The topic's end goes; nothing is told any more.
  void end() { writer_.lock()->reset(); }

 private:
  const Clock& clock_;
  const std::string node_;
  Guarded<std::unique_ptr<Writer>> writer_;
};

}  // namespace nacelle::runtime
