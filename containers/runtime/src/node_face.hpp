// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_description_interfaces/srv/get_type_description.hpp>
#include <utility>
#include <vector>

#include "lifecycle_services.hpp"
#include "node_runtime.hpp"
#include "parameter_services.hpp"

namespace nacelle::runtime {

/// The standard services of one node, on the executor of all of them. Threads: any.
class NodeFace {
 public:
  enum class Parts : std::uint8_t {
    Parameters,  ///< And type descriptions.
    Lifecycle,
    All,
  };
  [[nodiscard]] static std::shared_ptr<NodeFace> make(NodeServices& desk, Commons& commons, Executor& executor,
                                                      std::uint64_t id, const std::string& node, Parts parts);
  /// Withdraws the services, and notifies waiting callers that there will be no answer. Waits until running callbacks
  /// have returned, at most 10 s. Pending answers are discarded.
  void withdraw();
  void report_services(std::vector<ServiceReport>& out) const;

 private:
  using GetTypeDescription = type_description_interfaces::srv::GetTypeDescription;
  NodeFace(NodeServices& desk, Commons& commons, Executor& executor, std::uint64_t id, NodeIdentity identity);

  NodeRuntime node_;
  ParameterServices parameters_;
  LifecycleServices lifecycle_;
  Service<GetTypeDescription>::SharedPtr type_description_;
};

}  // namespace nacelle::runtime
