// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "nacelle/node/service.hpp"
#include "node_runtime.hpp"

namespace nacelle::runtime {

/// Offers a service of the container on behalf of a node, like Node::create_service() without a Node. `name` is
/// appended to the node's name.
template <typename S, typename F>
[[nodiscard]] std::shared_ptr<Service<S>> offer(NodeRuntime& node, const std::string& name, F callback) {
  using Made = detail::CallbackService<S, F>;
  const std::string full = node.identity().fully_qualified() + "/" + name;
  auto made = std::make_shared<Made>(full, std::move(callback));
  made->attach(node.create_service(full, S::Request::message_type(), S::Response::message_type(),
                                   {&Made::run, made.get()}, nullptr));
  return made;
}

}  // namespace nacelle::runtime
