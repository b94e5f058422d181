// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

// The words of ROS 2's managed nodes, as nodes, hosts and tools use them.
namespace nacelle {

/// lifecycle_msgs' ids of states.
enum class StateId : std::uint8_t {
  Unknown = 0,
  Unconfigured = 1,
  Inactive = 2,
  Active = 3,
  Finalized = 4,
  Configuring = 10,
  CleaningUp = 11,
  ShuttingDown = 12,
  Activating = 13,
  Deactivating = 14,
  ErrorProcessing = 15,
};
/// lifecycle_msgs' labels: "unconfigured", "inactive", ...
[[nodiscard]] const char* to_text(StateId state);

/// The state a callback comes from.
class State {
 public:
  explicit State(StateId id) : id_(id) {}
  [[nodiscard]] std::uint8_t id() const { return static_cast<std::uint8_t>(id_); }
  [[nodiscard]] StateId state() const { return id_; }
  [[nodiscard]] std::string label() const { return to_text(id_); }

 private:
  StateId id_;
};

/// Return codes of lifecycle_msgs/msg/Transition.
enum class CallbackReturn : std::uint8_t { SUCCESS = 97, FAILURE = 98, ERROR = 99 };

/// What one can ask a managed node to do (lifecycle_msgs ids 1 to 5; shutdown stands for 5, 6 and 7).
enum class Transition : std::uint8_t { Configure = 1, Cleanup = 2, Activate = 3, Deactivate = 4, Shutdown = 5 };
[[nodiscard]] const char* to_text(Transition transition);
/// "configure", "cleanup", "activate", "deactivate", "shutdown". Returns false on another word.
[[nodiscard]] bool parse_transition(std::string_view text, Transition& transition);

/// Why a transition did not do what was asked.
struct TransitionOutcome {
  bool success = false;
  StateId state = StateId::Unknown;  ///< Where the node is now.
  std::string reason;  ///< Empty on success: the component's own words, an exception's text, or what was not allowed.
};

/// Why a node is faulted.
struct FaultReason {
  std::string code, text;
};

}  // namespace nacelle
