// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "ask/frames.hpp"
#include "cli/program.hpp"
#include "nacelle/base/names.hpp"
#include "process/stop_signal.hpp"
#include "robot_commands/commands.hpp"
#include "teleop/teleop.hpp"

namespace nacelle::cli {
namespace {

struct TeleopWish {
  std::string container, topic = "cmd_vel";
  bool twist = false, stamped = false;
  teleop::TeleopSettings settings;
};

int run_teleop_command(TeleopWish& wish) {
  const process::StopSignal stop;
  auto client = connect(wish.container);
  if (!client) return client.error();
  if (::isatty(STDIN_FILENO) == 0) {
    complain({"teleop", "needs a terminal to read keys from", "publish with `nacelle topic pub` from a script"});
    return kUsage;
  }
  auto asking = connect(wish.container);  // a connection that asks does not publish
  if (!asking) return asking.error();
  ask::Nodes nodes{asking.value()};
  const auto container = nodes.container("");
  if (!container) return complain(container.error());
  const auto names = ask::list_frames(nodes, "");
  if (!names) return complain(names.error());
  wish.settings.container = container.value().node;
  wish.settings.topic = join_namespaces(names.value()["name_space"].get<std::string>(), wish.topic);
  wish.settings.frame.insert(0, names.value()["frame_prefix"].get<std::string>());
  wish.settings.stamped = !wish.twist;
  const SystemClock clock;
  return teleop::run_teleop(client.value(), asking.value(), wish.settings, stop, clock);
}

}  // namespace

void add_teleop_command(Command& root) {
  auto wish = std::make_shared<TeleopWish>();
  Command& command = root.add("teleop", "drive from the keyboard, like teleop_twist_keyboard");
  command.option("--topic", wish->topic, "topic for the commands; a relative name is in the robot's namespace")
      .with_default()
      .names_a(Names::Topic);
  command.flag("--stamped", wish->stamped, "send TwistStamped (the default)");
  command.flag("--twist", wish->twist, "send Twist").not_with("--stamped");
  command.option("--speed", wish->settings.keys.speed_mps, "initial forward speed in m/s")
      .within(0.01, 1.0)
      .with_default();
  command.option("--turn", wish->settings.keys.yaw_rate_rps, "initial turning speed in rad/s")
      .within(0.01, 3.0)
      .with_default();
  add_container_option(command, wish->container);
  command.runs([wish] { return run_teleop_command(*wish); });
}

}  // namespace nacelle::cli
