// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "cli/program.hpp"
#include "robot_commands/commands.hpp"
#include "robot_commands/truth_publisher.hpp"
#include "simulation/component/run_can_device.hpp"
#include "simulation/component/run_device.hpp"
#include "simulation/component/run_world.hpp"
#include "simulation/port/truth_file.hpp"

namespace nacelle::cli {
namespace {

std::optional<double> relative_error(const std::string& text) {
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  return read.ec == std::errc{} && read.ptr == end ? std::optional{number} : std::nullopt;
}

struct WorldWish {
  simulation::WorldOptions options;
  std::string left_radius, right_radius, track;  ///< Relative errors; empty: drawn.
  double imu_yaw_deg = 0.0;
  bool verbose = false;
};

/// For Option::checked(): a relative error of a length.
std::string wrong_error(const std::string& text) {
  const auto number = relative_error(text);
  return number && std::abs(*number) <= 0.5 ? "" : "give a number from -0.5 to 0.5, such as 0.01 for 1 % more";
}

int run_world_command(const WorldWish& wish) {
  const SystemClock clock;
  auto report = simulation::run_world(wish.options, clock);
  if (!report) return complain(report.error());
  if (wish.verbose) {
    std::fprintf(stderr, "world: %.1f s, %llu late steps, %llu skipped\n", report.value().seconds,
                 static_cast<unsigned long long>(report.value().late_steps),
                 static_cast<unsigned long long>(report.value().skipped_steps));
  }
  return kDone;
}

/// Returns whether a folder, or the symbolic link to it, belongs to this user or root.
bool is_own(const std::string& folder) {
  struct stat status {};
  return ::lstat(folder.c_str(), &status) == 0 && (status.st_uid == ::geteuid() || status.st_uid == 0);
}

/// The world that is meant when no folder is named: the only one that runs, of a launch file or of `drive`.
Result<std::string, Problem> running_world() {
  const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
  const std::string base = runtime != nullptr && *runtime != '\0' ? runtime : "/dev/shm";
  std::vector<std::string> found;
  std::error_code unreadable;
  for (const auto& entry : std::filesystem::directory_iterator(base, unreadable)) {
    const std::string name = entry.path().filename().string();
    const bool fits = name == "nacelle-sim" || name.rfind("nacelle-drive-", 0) == 0;
    if (fits && is_own(entry.path()) && simulation::read_truth((entry.path() / "truth").string()))
      found.push_back(entry.path().string());
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    return err(Problem{base, "no simulated world runs there",
                       "start one (`nacelle drive --stay`), or name its folder with --dir: the launch file's sim_dir"});
  }
  std::ranges::sort(found);
  return err(Problem{base, "more than one simulated world is there",
                     fmt::format("choose with --dir: {}", fmt::join(found, ", "))});
}

int plug(const std::string& asked, const std::string& device, bool in) {
  auto directory = asked.empty() ? running_world() : asked;
  if (!directory) return complain(directory.error());
  auto done = simulation::plug_device(directory.value(), device, in);
  return done ? kDone : complain(done.error());
}

struct DeviceWish {
  simulation::DeviceRun run;
  std::string can;
};

int run_device_command(const DeviceWish& wish) {
  const SystemClock clock;
  const simulation::DeviceRun& run = wish.run;
  const bool is_on_can = std::ranges::count(simulation::can_device_names(), run.name) > 0;
  if (is_on_can == wish.can.empty()) {
    return complain(is_on_can
                        ? Problem{"device '" + run.name + "'", "it is on a CAN bus", "name its interface: --can vcan0"}
                        : Problem{"device '" + run.name + "'", "it is on a serial line, not on a CAN bus",
                                  fmt::format("leave --can out; on a CAN bus are {}",
                                              fmt::join(simulation::can_device_names(), ", "))});
  }
  if (is_on_can) {
    auto done = simulation::run_can_device({run.name, wish.can}, clock, [&wish] {
      std::printf("%s\n", wish.can.c_str());
      std::fflush(stdout);
    });
    return done ? kDone : complain(done.error());
  }
  auto done = simulation::run_device(run, clock, [](const std::string& path) {
    std::printf("%s\n", path.c_str());
    std::fflush(stdout);
  });
  return done ? kDone : complain(done.error());
}

int show_truth(const std::string& asked) {
  auto directory = asked.empty() ? running_world() : asked;
  if (!directory) return complain(directory.error());
  const auto truth = simulation::read_truth(directory.value() + "/truth");
  if (!truth) return complain({directory.value(), "no world runs there", "name its folder with --dir"});
  const simulation::Truth& t = truth.value();
  const nlohmann::ordered_json shown{{"time_s", t.time_s},
                                     {"x_m", t.x_m},
                                     {"y_m", t.y_m},
                                     {"yaw_rad", t.yaw_rad},
                                     {"speed_mps", t.speed_mps},
                                     {"yaw_rate_rps", t.yaw_rate_rps},
                                     {"left_command_mps", t.left_command_mps},
                                     {"right_command_mps", t.right_command_mps},
                                     {"motion_commands", t.motion_commands},
                                     {"last_motion_command_ns", t.last_motion_command_ns},
                                     {"starts", t.starts},
                                     {"last_start_ns", t.last_start_ns},
                                     {"stops", t.stops},
                                     {"last_stop_ns", t.last_stop_ns},
                                     {"watchdog_stops", t.watchdog_stops},
                                     {"contacts", t.contacts}};
  std::printf("%s\n", shown.dump().c_str());
  return kDone;
}

}  // namespace

void add_sim_commands(Command& root) {
  auto wish = std::make_shared<WorldWish>();
  Command& group = root.add("sim", "the simulated robot");
  Command& world = group.add(
      "world", "run the simulated world until Ctrl-C; its devices appear in a folder as lidar, imu, base and gps");
  world.option("--dir", wish->options.directory, "folder for the device links; created if missing")
      .required()
      .names_a(Names::File);
  world.option("--seed", wish->options.settings.seed, "seed of the world's random numbers").with_default();
  world
      .option("--gps-error", wish->options.settings.gps.error_m,
              "standard deviation of the GPS's positions at HDOP 1, in m; 0.1 and less: RTK")
      .with_default();
  auto& chosen = wish->options.settings;
  world
      .option("--left-radius-error", wish->left_radius,
              "of the left wheel, relative: 0.01 is 1 % more (default: drawn)")
      .value("PART")
      .checked(wrong_error);
  world.option("--right-radius-error", wish->right_radius, "of the right wheel").value("PART").checked(wrong_error);
  world.option("--separation-error", wish->track, "of the wheels' separation").value("PART").checked(wrong_error);
  world.option("--slip", chosen.errors.slip, "standard deviation of each wheel's slip, drawn each second")
      .value("PART")
      .with_default()
      .within(0.0, 0.5);
  world.option("--imu-yaw", wish->imu_yaw_deg, "degrees by which the IMU's axes are turned in the base")
      .value("DEGREES")
      .with_default()
      .within(-180.0, 180.0);
  world.option("--imu-x", chosen.known.imu_x_m, "m that the IMU is ahead of the middle of the axle")
      .value("METRES")
      .with_default()
      .within(-2.0, 2.0);
  world.option("--imu-y", chosen.known.imu_y_m, "m that it is to the left of it")
      .value("METRES")
      .with_default()
      .within(-2.0, 2.0);
  world.option("--parent", wish->options.parent_pid, "end when this process ends").hidden();
  world.flag("-v,--verbose", wish->verbose, "print a summary at the end");
  world.runs([wish] {
    wish->options.end_with_parent = wish->options.parent_pid != 0;
    auto& known = wish->options.settings.known;
    known.left_radius = relative_error(wish->left_radius);
    known.right_radius = relative_error(wish->right_radius);
    known.track = relative_error(wish->track);
    known.imu_yaw_rad = wish->imu_yaw_deg * std::numbers::pi / 180.0;
    return run_world_command(*wish);
  });

  auto names = simulation::device_names();
  for (auto& name : simulation::can_device_names()) names.push_back(std::move(name));
  auto one = std::make_shared<DeviceWish>();
  Command& alone = group.add(
      "device", "run one simulated device behind a pty, or on a CAN interface, until Ctrl-C, and print where it is");
  alone
      .option("device", one->run.name,
              "ld06, rplidar_a1, ydlidar_x4, odrive_can, ..., as the driver's parameter model or hardware names it")
      .required()
      .one_of(std::move(names));
  alone.option("--pty", one->run.link, "a symbolic link to make for the pty").names_a(Names::File);
  alone.option("--can", one->can, "the CAN interface of odrive_can or vesc_can, such as vcan0");
  alone.option("--seed", one->run.seed, "seed of the device's random numbers").with_default();
  alone.runs([one] { return run_device_command(*one); });

  auto folder = std::make_shared<std::string>();
  auto device = std::make_shared<std::string>();
  const auto with_folder = [&](const char* name, const char* what) -> Command& {
    Command& command = group.add(name, what);
    command
        .option("--dir", *folder, "the world's folder, the launch file's sim_dir (default: that of the running world)")
        .names_a(Names::File);
    return command;
  };
  for (const bool in : {false, true}) {
    Command& command =
        with_folder(in ? "plug" : "unplug", in ? "reconnect a device" : "disconnect a device of the running world");
    command.option("device", *device, "lidar, imu, base or gps").required().one_of({"lidar", "imu", "base", "gps"});
    command.runs([folder, device, in] { return plug(*folder, *device, in); });
  }
  Command& truth =
      with_folder("truth", "print the simulated robot's true pose and its motor board's last command as JSON");
  auto published = std::make_shared<TruthTopic>();
  truth
      .option("--publish", published->topic,
              "publish pose and velocity on this topic instead (nav_msgs/Odometry), until Ctrl-C")
      .names_a(Names::Topic);
  truth.option("--rate", published->rate_hz, "messages/s on it").with_default().within(1.0, 500.0);
  add_container_option(truth, published->container);
  truth.runs([folder, published] {
    if (published->topic.empty()) return show_truth(*folder);
    const auto directory = folder->empty() ? running_world() : *folder;
    return directory ? publish_truth(directory.value(), *published) : complain(directory.error());
  });
}

}  // namespace nacelle::cli
