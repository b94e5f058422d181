// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/base_driver.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <utility>

#include "calibration_commands/model/leg.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {
namespace {

using calibration::Leg;
using calibration::LegState;
using calibration::WheelTurn;

constexpr Duration kPeriod = 20ms;
constexpr Duration kArrivalLimit = 2s;
/// Speed is reached after so long.
constexpr double kRampUp_s = 1.0;

/// Commands zero at the end in any case, and waits until the container has it.
class StopAtEnd {
 public:
  StopAtEnd(control::Client& client, drive::VelocitySender& sender) : client_(client), sender_(sender) {}
  StopAtEnd(const StopAtEnd&) = delete;
  StopAtEnd& operator=(const StopAtEnd&) = delete;
  ~StopAtEnd() {
    const SystemClock clock;
    for (int i = 0; i < 3; ++i) {
      if (!sender_.send(0.0, 0.0, clock.wall_now())) return;
    }
    // The answer to a request sent after them shows that they have arrived.
    static_cast<void>(client_.lookup("odom", "base_link", kArrivalLimit));
  }

 private:
  control::Client& client_;
  drive::VelocitySender& sender_;
};

Problem problem_of(LegState state, const BaseTopics& topics) {
  if (state == LegState::Lost) {
    return {"topic " + topics.joints, "no position of the wheels came any more; the robot was stopped",
            "see `nacelle faults`, then begin anew"};
  }
  if (state == LegState::Astray) {
    return {"topic " + topics.joints, "the wheels went backward or far beyond the target; the robot was stopped",
            "was the motor board restarted, or does another program command the base? Then begin anew"};
  }
  return {"topic " + topics.commands, "the wheels do not follow the commands",
          "is an emergency stop set, or a lock? See `nacelle estop` and the base's entry on /diagnostics"};
}

calibration::LegSettings settings_of(double target, double speed, const BaseTopics& topics, Duration command_timeout) {
  calibration::LegSettings settings;
  settings.target = target;
  settings.speed = speed;
  settings.acceleration = speed / kRampUp_s;
  settings.still_for = topics.still_for;
  settings.lost_after = std::max(topics.silence, settings.silent_after);
  if (command_timeout > Duration::zero()) {
    settings.late_after = command_timeout * 4 / 5;
    settings.pause = std::max(settings.pause, 2 * command_timeout);
  }
  return settings;
}

}  // namespace

/// What one leg works with.
struct BaseDriver::Way {
  const Motion motion;
  TopicReader& joints;
  control::Client& client;
  drive::VelocitySender& sender;
  const std::function<Result<void, Problem>()>& meanwhile;
  Leg leg;
  const WheelTurn begin;
  WheelTurn turn{};

  [[nodiscard]] double progress(const calibration::BaseGeometry& geometry) const {
    return motion.yaw_rate_rps == 0.0 ? distance_m(geometry, turn) / motion.forward_mps
                                      : yaw_rad(geometry, turn) / motion.yaw_rate_rps;
  }
};

Result<WheelSample, int> BaseDriver::first_reading(TopicReader& joints) const {
  const SystemClock clock;
  const MonotonicTime until = clock.now() + topics_.silence;
  while (true) {
    auto message = next_message(dialogue_, joints, topics_.silence);
    if (!message) return err(message.error());
    if (const auto wheels = sample_in(*message, base_)) return *wheels;
    if (clock.now() < until) continue;  // another publisher's: of an arm, say
    return err(complain({"topic " + topics_.joints,
                         "has no positions of " + base_.left_joints.front() + " and the other wheels",
                         "name the base's topic with --joint-states"}));
  }
}

Result<void, Problem> BaseDriver::run(Way& way) {
  const SystemClock clock;
  MonotonicTime next = clock.now();
  while (!way.leg.is_over()) {
    std::array<pollfd, 3> waits{pollfd{dialogue_.stop().descriptor(), POLLIN, 0},
                                pollfd{way.joints.descriptor(), POLLIN, 0}, pollfd{way.client.descriptor(), POLLIN, 0}};
    const Duration left = std::max(Duration::zero(), next - clock.now());
    ::poll(waits.data(), waits.size(), static_cast<int>((left + 999us) / 1ms));
    if (dialogue_.stop().is_raised()) return {};
    while (true) {
      auto message = way.joints.take();
      if (!message) return err(message.error());
      if (!*message) break;
      const auto wheels = sample_in(**message, base_);
      if (!wheels) continue;
      way.turn = wheels->turn - way.begin;
      path_.push_back({wheels->stamp_s, way.turn});
      way.leg.take(way.progress(base_.geometry), clock.now());
    }
    if (way.meanwhile) {
      if (auto taken = way.meanwhile(); !taken) return taken;
    }
    if (waits[2].revents != 0) {
      // Only refusals come unasked.
      auto frame = way.client.receive(0ns);
      if (!frame) return err(frame.error());
      if (frame.value() && frame.value()->kind == control::FrameKind::Fault)
        return err(Problem{topics_.commands, std::string{as_text(frame.value()->payload)}, "is the robot running?"});
    }
    if (clock.now() < next) continue;
    next = std::max(next + kPeriod, clock.now());  // after a delay no burst follows
    const double speed = way.leg.command(clock.now());
    if (auto sent = way.sender.send(way.motion.forward_mps * speed, way.motion.yaw_rate_rps * speed, clock.wall_now());
        !sent)
      return sent;
  }
  if (way.leg.state() != LegState::Done) return err(problem_of(way.leg.state(), topics_));
  return {};
}

Result<WheelTurn, int> BaseDriver::drive(const Motion& motion, double target, double speed,
                                         const std::function<Result<void, Problem>()>& meanwhile) {
  auto joints = TopicReader::open(topics_.container, topics_.joints);
  if (!joints) return err(joints.error());
  auto client = connect(topics_.container);
  if (!client) return err(client.error());
  auto sender = drive::VelocitySender::open(client.value(), topics_.commands, topics_.stamped, topics_.frame);
  if (!sender) return err(complain(sender.error()));
  const auto begin = first_reading(joints.value());
  if (!begin) return err(begin.error());
  path_ = {{begin->stamp_s, {}}};
  const SystemClock clock;
  Way way{motion,         joints.value(), client.value(),
          sender.value(), meanwhile,      Leg{settings_of(target, speed, topics_, base_.command_timeout), clock.now()},
          begin->turn};
  Result<void, Problem> done;
  {
    const StopAtEnd stop{client.value(), sender.value()};
    done = run(way);
  }
  if (dialogue_.stop().is_raised()) return err(dialogue_.interrupted());
  if (!done) return err(complain(done.error()));
  return way.turn;
}

}  // namespace nacelle::cli
