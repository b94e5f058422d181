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

/// Publishes changes of a node's parameters on /parameter_events. Without readers it costs one check of their number.
/// Threads: any. The store may keep this object longer than the node's topic exists.
class ParameterEvents final : public ParameterListener {
 public:
  ParameterEvents(Transport& transport, const Clock& clock, std::string node);
  void on_change(const ParameterChange& change) noexcept override;
  /// Destroys the publisher; nothing is published any more.
  void end() { writer_.lock()->reset(); }

 private:
  const Clock& clock_;
  const std::string node_;
  Guarded<std::unique_ptr<Writer>> writer_;
};

}  // namespace nacelle::runtime
