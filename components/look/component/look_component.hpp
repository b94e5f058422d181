// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "look/component/link_file.hpp"
#include "look/component/look_server.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::look {

/// Shows its container in a browser, in Foxglove and in Lichtblick, as long as it is active.
///
/// The links, with their access tokens, are in the file of the parameter `link_file`: `nacelle look` prints them.
/// Threads: the component's executor for what viewers ask of the robot; the server has a thread of its own.
class LookComponent final : public LifecycleNode {
 public:
  explicit LookComponent(const NodeOptions& options);
  ~LookComponent() override;

 protected:
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_error(const State&) override;

 private:
  [[nodiscard]] std::string links(std::uint16_t port, const Access::Options& access) const;

  LookServer::Options options_;
  OnSetParametersCallbackHandle::SharedPtr guard_;
  bool names_file_ = false;  // this component itself sets link_file
  std::optional<LinkFile> link_file_;
  std::unique_ptr<LookServer> server_;
};

}  // namespace nacelle::look
