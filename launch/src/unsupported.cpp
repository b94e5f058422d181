// SPDX-License-Identifier: Apache-2.0
#include "unsupported.hpp"

#include <array>
#include <string>

namespace nacelle::launch {
namespace {

struct Refusal {
  std::string_view name;
  const char* reason;
};

const char* reason_for(const Refusal* first, const Refusal* last, std::string_view name) {
  for (; first != last; ++first) {
    if (first->name == name) return first->reason;
  }
  return nullptr;
}

}  // namespace

const char* refused_action(std::string_view name) {
  static constexpr std::array kRefused{
      Refusal{"shutdown",
              "a launch file describes what runs, it does not stop it; use `nacelle component unload` or Ctrl-C"},
      Refusal{"timer",
              "a start by the clock is not available: it fails on a slower machine; name the condition with `after:`"},
      Refusal{"ros_timer",
              "a start by the clock is not available: it fails on a slower machine; name the condition with `after:`"},
      Refusal{"set_ros_log_dir", "there is no log folder to set: the container logs to its standard error"},
      Refusal{"lifecycle_node",
              "a lifecycle node in a process of its own is not available; load it as a composable_node"},
      Refusal{"reset", "resetting the launch configuration is not available; put the actions into a group"},
  };
  return reason_for(kRefused.begin(), kRefused.end(), name);
}

const char* refused_attribute(std::string_view name) {
  static constexpr std::array kRefused{
      Refusal{"shell",
              "a shell between the container and the program hides the program from it; start a script instead"},
      Refusal{"launch-prefix", "a prefix such as a debugger is not available; start it with `executable`"},
      Refusal{"emulate_tty", "a terminal for a program is not available; leave it out"},
      Refusal{"respawn_max_retries", "respawning a program is not available yet; leave it out"},
  };
  return reason_for(kRefused.begin(), kRefused.end(), name);
}

const char* refused_substitution(std::string_view name) {
  static constexpr std::array kRefused{
      Refusal{"eval",
              "it runs Python, which Nacelle does not have; use $(not), $(and), $(or), $(equals) or an argument"},
      Refusal{"command",
              "it runs a program while the file is read, so that a check could change the robot; give the value as an "
              "argument"},
      Refusal{"param", "parameters are not launch configurations here; use $(var)"},
      Refusal{"find-pkg-prefix", "packages have no prefix of their own here; use $(find-pkg-share)"},
      Refusal{"exec-in-pkg", "programs are found by the keys pkg and exec; use a `node` action"},
  };
  return reason_for(kRefused.begin(), kRefused.end(), name);
}

std::vector<Problem> refuse_unavailable(const Plan& plan) {
  std::vector<Problem> problems;
  for (const auto& program : plan.programs) {
    if (!program.respawn) continue;
    problems.push_back(
        {program.where, "respawn: true is not available yet: a program that ends stays ended", "leave it out"});
  }
  return problems;
}

}  // namespace nacelle::launch
