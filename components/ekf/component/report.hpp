// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include "ekf/component/input.hpp"
#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/log.hpp"

namespace nacelle::ekf {

/// Logs why a part of an input is not fused, once per cause, and when it is fused again. Logs once which input's stamps stand still,
/// lag behind the clock or are ahead of it. Logs how many of its messages were lost, at most every ten seconds.
/// Threads: one. Allocates: only to log.
class Watch {
 public:
  /// `skews`: machines whose clocks differ, for warnings about stamps; null: unknown.
  Watch(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter,
        std::shared_ptr<const ClockSkews> skews = nullptr);
  /// Looks at what happened since the last look; call about once a second.
  void look(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter, const Logger& logger);

 private:
  enum class Trouble : std::uint8_t { None, Silent, Rejected };
  struct Seen {
    PartStats stats;
    std::uint64_t messages{};
    Trouble trouble{Trouble::None};
    Rejection cause{};
    int idle_looks{0};
    int behind_looks{0};
    bool stands{false}, behind{false}, ahead{false};
  };
  struct Losses {
    std::uint64_t told{};
    int looks{0};  // since it was reported
  };
  void look_at_stamps(const Input& input, const Input::Part& part, const Filter& filter, Seen& seen,
                      const Logger& logger) const;
  static void look_at_losses(const Input& input, const Filter& filter, Losses& losses, const Logger& logger);
  std::shared_ptr<const ClockSkews> skews_;
  std::vector<Seen> seen_;
  std::vector<Losses> losses_;  // of each input
};

/// The counters of every part as diagnostics. Allocates: yes.
void write_diagnostics(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter, const std::string& node,
                       diagnostic_msgs::msg::DiagnosticArray& out);

}  // namespace nacelle::ekf
