// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/base_calibration.hpp"

#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "ask/frames.hpp"
#include "calibration_commands/base_driver.hpp"
#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/gyro_reference.hpp"
#include "calibration_commands/parameter_lines.hpp"
#include "calibration_commands/umbmark_calibration.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {
namespace {

using calibration::BaseFault;
using calibration::BaseGeometry;

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

Problem problem_of(BaseFault fault, const std::string& node, double believed, double measured, const char* unit) {
  switch (fault) {
    case BaseFault::NoMotion: return {node, "the wheels have hardly turned", "let it go farther"};
    case BaseFault::NotStraight:
      return {node, "the wheels turned the robot by more than 10 degrees on the way",
              "hold nothing, and begin anew on an even floor"};
    case BaseFault::NotOnTheSpot:
      return {node, "the wheels moved the robot instead of turning it on the spot",
              "hold nothing, and begin anew on an even floor"};
    case BaseFault::Absurd: break;
  }
  return {node,
          fmt::format("{:.3f} {} measured, {:.3f} {} by the wheels: more than a factor of two is no calibration",
                      measured, unit, believed, unit),
          "check the unit of the answer and the base's parameters"};
}

/// One run of the command. Each step returns its exit code when it fails, and has printed why.
class BaseCalibration {
 public:
  BaseCalibration(const BaseWish& wish, Dialogue& dialogue, std::string node, BaseTopics topics,
                  const BaseParameters& base)
      : wish_(wish),
        dialogue_(dialogue),
        node_(std::move(node)),
        geometry_(base.geometry),
        driver_(dialogue, std::move(topics), base) {}

  int run() {
    dialogue_.say(fmt::format("{}: wheel radius {:.5f} m left, {:.5f} m right, separation {:.5f} m", node_,
                              geometry_.left_radius_m(), geometry_.right_radius_m(), geometry_.separation_m()));
    if (wish_.distance_m > 0.0) {
      if (const int code = straight(); code != kDone) return code;
    }
    if (wish_.turns > 0.0) {
      if (const int code = turn(); code != kDone) return code;
    }
    dialogue_.say(fmt::format("now:  wheel radius {:.5f} m left, {:.5f} m right, separation {:.5f} m",
                              geometry_.left_radius_m(), geometry_.right_radius_m(), geometry_.separation_m()));
    return kDone;
  }

  [[nodiscard]] std::string text() const {
    return parameter_file(
        node_,
        {"Written by `nacelle base calibrate`. An odometry with wheel parameters of its own needs these, too;",
         "one without takes them from the base."},
        {parameter_line("left_wheel_radius_multiplier", geometry_.left_radius_multiplier),
         parameter_line("right_wheel_radius_multiplier", geometry_.right_radius_multiplier),
         parameter_line("wheel_separation_multiplier", geometry_.separation_multiplier)});
  }

 private:
  int agree(const std::string& what) {
    if (!wish_.yes) return dialogue_.ask_for_enter(what);
    dialogue_.say(what);
    return kDone;
  }
  Result<double, int> measured(double by_option, const std::string& question) {
    if (by_option > 0.0) return by_option;
    return dialogue_.ask_for_number(question);
  }

  int straight() {
    const int code = agree(fmt::format(
        "straight line: the robot will drive {:.2f} m ahead. Clear the way, and mark on the floor where it stands",
        wish_.distance_m));
    if (code != kDone) return code;
    const auto turned = driver_.drive(kStraight, wish_.distance_m, wish_.speed_mps);
    if (!turned) return turned.error();
    const double believed = distance_m(geometry_, *turned);
    dialogue_.say(fmt::format("  it stands; by its wheels it drove {:.3f} m", believed));
    const auto real = measured(wish_.measured_distance_m, "  how many metres did it really drive?");
    if (!real) return real.error();
    auto mended = with_measured_distance(geometry_, *turned, *real);
    if (!mended) return complain(problem_of(mended.error(), node_, believed, *real, "m"));
    geometry_ = *mended;
    return kDone;
  }

  int turn() {
    const int code = agree(fmt::format(
        "turn: the robot will turn {:.2f} times to the left on the spot. Clear the place, and mark which way it looks",
        wish_.turns));
    if (code != kDone) return code;
    std::optional<GyroReference> gyro;
    if (!wish_.gyro.empty()) {
      auto begun =
          GyroReference::begin(dialogue_, wish_.container, beside(node_, wish_.gyro), from_seconds(wish_.wait_s));
      if (!begun) return begun.error();
      gyro.emplace(std::move(begun).value());
    }
    std::function<Result<void, Problem>()> meanwhile;
    if (gyro) meanwhile = [&gyro] { return gyro->take(); };
    const auto turned = driver_.drive(kTurnLeft, wish_.turns * kTurn_rad, wish_.yaw_rate_rps, meanwhile);
    if (!turned) return turned.error();
    // With the radius that the straight line gave.
    const double believed = yaw_rad(geometry_, *turned) / kTurn_rad;
    dialogue_.say(fmt::format("  it stands; by its wheels it turned {:.4f} times", believed));
    double by_gyro = 0.0;
    if (gyro) {
      const auto yaw = gyro->yaw_rad();
      if (!yaw) return complain(yaw.error());
      by_gyro = *yaw / kTurn_rad;
      dialogue_.say(fmt::format("  by the gyro it turned {:.4f} times", by_gyro));
      if (by_gyro <= 0.0)
        return complain({"topic " + beside(node_, wish_.gyro), "the gyro turned the other way", "is its z axis up?"});
    }
    const auto real =
        measured(gyro ? by_gyro : wish_.measured_turns, "  how many turns did it really make? (10 degrees are 0.0278)");
    if (!real) return real.error();
    auto mended = with_measured_yaw(geometry_, *turned, *real * kTurn_rad);
    if (!mended) return complain(problem_of(mended.error(), node_, believed, *real, "turns"));
    geometry_ = *mended;
    return kDone;
  }

  const BaseWish& wish_;
  Dialogue& dialogue_;
  const std::string node_;
  BaseGeometry geometry_;
  BaseDriver driver_;
};

}  // namespace

int calibrate_base(const BaseWish& wish) {
  if (!wish.umbmark && wish.distance_m <= 0.0 && wish.turns <= 0.0)
    return complain_of_usage({"base calibrate", "neither a distance nor turns to drive", "leave out one of the zeros"});
  Dialogue dialogue;
  if (auto fine = check_output(wish.output); !fine) return complain(fine.error());
  auto client = connect(wish.container);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  auto node = nodes.find(wish.node);
  if (!node) return complain(node.error());
  auto parameters = parameters_of(nodes, *node);
  if (!parameters) return complain(parameters.error());
  const auto names = ask::list_frames(nodes, "");
  if (!names) return complain(names.error());
  BaseTopics topics;
  topics.container = wish.container;
  topics.commands = beside(*node, wish.command);
  topics.joints = beside(*node, wish.joints);
  topics.frame = names.value()["frame_prefix"].get<std::string>() + "base_link";
  topics.stamped = !wish.twist;
  topics.silence = from_seconds(wish.wait_s);
  const auto base = base_parameters(*parameters, *node, topics.commands);
  if (!base) return complain(base.error());
  if (wish.umbmark) return calibrate_by_squares(wish, dialogue, nodes, *node, std::move(topics), *base);
  BaseCalibration calibration{wish, dialogue, *node, std::move(topics), *base};
  if (const int code = calibration.run(); code != kDone) return code;
  return write_output(wish.output, calibration.text());
}

}  // namespace nacelle::cli
