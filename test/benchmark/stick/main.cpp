// SPDX-License-Identifier: Apache-2.0
// teleop [moves=600] [camera=1] [hz=50]
// From the move of a gamepad's stick to the command on the motor board's line: joy_node, teleop_twist_joy_node and diff_drive in one
// container, with the camera's pattern at 30 Hz beside them, and a board at the other end of a pty.
#include <poll.h>
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "nacelle/io/pty_pair.hpp"
#include "nacelle/runtime/container.hpp"
#include "simulation/protocol/ugv_device.hpp"
#include "stick/schedule.hpp"
#include "support/arguments.hpp"

namespace nacelle::bench {
namespace {

[[noreturn]] void give_up(const std::string& what) {
  std::fprintf(stderr, "teleop: %s\n", what.c_str());
  std::exit(1);
}

void start(runtime::Container& container, const std::string& plugin, std::map<std::string, ParameterValue> parameters) {
  runtime::LoadRequest request;
  request.plugin = plugin;
  request.parameters = std::move(parameters);
  const auto loaded = container.load(request);
  if (!loaded) give_up(loaded.error().text());
  for (const auto step : {Transition::Configure, Transition::Activate}) {
    const auto outcome = container.trigger(loaded.value().id, step);
    if (!outcome.success) give_up(plugin + ": " + outcome.reason);
  }
}

/// The board's end of the line: sends feedback at 50 Hz, and notes when the first command of each move came.
class Board {
 public:
  Board(io::PtyPair& line, const Schedule& schedule, const Clock& clock)
      : line_(line), schedule_(schedule), clock_(clock), seen_(schedule.moves) {}

  void run_until(MonotonicTime end) {
    while (clock_.now() < end) {
      pollfd watched{line_.device_end(), POLLIN, 0};
      ::poll(&watched, 1, 2);
      const auto bytes = line_.read();
      if (!bytes) give_up("the line broke");
      const MonotonicTime now = clock_.now();
      reader_.feed(*bytes, [&](const simulation::UgvCommand& command, std::string_view) { note(command, now); });
      if (now < next_feedback_) continue;
      static_cast<void>(line_.write_some(as_bytes(simulation::print_feedback({}))));
      next_feedback_ = now + 20ms;
    }
  }
  /// Milliseconds from the move to its command, in their order; of the moves that came.
  [[nodiscard]] std::vector<double> latencies_ms() const {
    std::vector<double> all;
    for (std::uint64_t move = 0; move < schedule_.moves; ++move) {
      if (seen_[move] != MonotonicTime{}) all.push_back(to_milliseconds(seen_[move] - schedule_.at(move)));
    }
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  void note(const simulation::UgvCommand& command, MonotonicTime now) {
    if (command.type != 1 || !command.left || *command.left == 0.0) return;
    // The newest move that has this speed.
    const auto passed = static_cast<std::uint64_t>((now - schedule_.first) / schedule_.period);
    for (std::uint64_t back = 0; back <= std::min(passed, Schedule::kSpeeds - 1); ++back) {
      const std::uint64_t move = passed - back;
      if (move >= schedule_.moves) continue;
      if (std::abs(*command.left - Schedule::share(move) * Schedule::kFullSpeed_mps) > 1e-3) continue;
      if (seen_[move] == MonotonicTime{}) seen_[move] = now;
      return;
    }
  }

  io::PtyPair& line_;
  const Schedule schedule_;
  const Clock& clock_;
  simulation::UgvLineReader reader_;
  std::vector<MonotonicTime> seen_;
  MonotonicTime next_feedback_{};
};

}  // namespace
}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle;
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  // As with `thread: {mode: own, priority: 10}` in a launch file: what else runs on the machine is not measured.
  const sched_param priority{10};
  const bool real_time = ::sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  const SystemClock clock;
  auto line = io::PtyPair::create();
  if (!line) give_up(line.error().text());

  Schedule schedule;
  schedule.moves = arguments.number("moves", 600);
  schedule.first = clock.now() + 4s;  // the components come up, and the board speaks
  ::setenv(Schedule::kVariable, schedule.text().c_str(), 1);
  Board board{*line.value(), schedule, clock};

  runtime::Container container{{.name = "bench", .component_path = {NACELLE_BENCH_COMPONENTS, NACELLE_BENCH_PLUGINS}},
                               clock};
  if (arguments.number("camera", 1) != 0)
    start(container, "nacelle::camera::CameraComponent", {{"video_device", std::string{"pattern"}}});
  start(container, "nacelle::diff_drive::DiffDriveComponent",
        {{"serial_port", line.value()->path()},
         {"left_wheel_names", std::vector<std::string>{"left"}},
         {"right_wheel_names", std::vector<std::string>{"right"}},
         {"wheel_separation", 0.3},
         {"wheel_radius", 0.033},
         {"update_rate", static_cast<double>(arguments.number("hz", 50))}});
  start(container, "nacelle::joy::TeleopTwistJoyComponent",
        {{"enable_button", std::int64_t{0}},
         {"axis_linear.x", std::int64_t{1}},
         {"scale_linear.x", Schedule::kFullSpeed_mps},
         {"axis_angular.yaw", std::int64_t{-1}}});
  start(container, "nacelle::bench::ScheduledJoy", {{"deadzone", 0.0}});

  board.run_until(schedule.at(schedule.moves) + 200ms);
  const auto latencies = board.latencies_ms();
  if (latencies.empty()) give_up("no command came to the wheels");
  const auto at = [&](double share) {
    return latencies[std::min(latencies.size() - 1,
                              static_cast<std::size_t>(share * static_cast<double>(latencies.size())))];
  };
  print_figures({{"real_time", real_time ? 1.0 : 0.0},
                 {"moves", static_cast<double>(schedule.moves)},
                 {"lost", static_cast<double>(schedule.moves - latencies.size())},
                 {"p50_ms", at(0.5)},
                 {"p99_ms", at(0.99)},
                 {"max_ms", latencies.back()}});
  return 0;
}
