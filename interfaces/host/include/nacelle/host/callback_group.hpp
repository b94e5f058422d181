// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

namespace nacelle {

/// May callbacks of one group run at the same time? As rclcpp::CallbackGroupType.
enum class CallbackGroupType : std::uint8_t {
  MutuallyExclusive,  ///< One at a time.
  Reentrant,          ///< At the same time, also a callback with itself.
};

/// Which callbacks of a node may overlap; see Node::create_callback_group().
///
/// Every node has one mutually exclusive group for the callbacks that name none. Callbacks of different groups, and of one
/// reentrant group, overlap only where the executor has more than one thread (`thread: {mode: own, threads: N}` in the launch
/// file); else a group changes nothing. Lifecycle transitions run alone: no callback of any group of the node beside them.
/// Ownership: shared by the node's author and the callbacks in the group. Threads: any.
class CallbackGroup {
 public:
  using SharedPtr = std::shared_ptr<CallbackGroup>;
  CallbackGroup(const CallbackGroup&) = delete;
  CallbackGroup& operator=(const CallbackGroup&) = delete;
  virtual ~CallbackGroup() = default;
  [[nodiscard]] CallbackGroupType type() const { return type_; }

 protected:
  explicit CallbackGroup(CallbackGroupType type) : type_(type) {}

 private:
  const CallbackGroupType type_;
};

}  // namespace nacelle
