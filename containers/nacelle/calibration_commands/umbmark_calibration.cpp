// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/umbmark_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "calibration_commands/model/base_estimate.hpp"
#include "calibration_commands/model/umbmark.hpp"
#include "calibration_commands/model/wheel_path.hpp"
#include "calibration_commands/parameter_lines.hpp"
#include "calibration_commands/truth_topic.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {
namespace {

using calibration::BaseEstimate;
using calibration::BaseGeometry;
using calibration::DrivenWay;
using calibration::EstimateFault;
using calibration::Measured;
using calibration::SquareError;
using calibration::WheelPath;

constexpr double kCorner_rad = std::numbers::pi / 2.0;
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr int kSides = 4;
/// Of a tape measure and the eye; of another localisation.
constexpr calibration::MeasurementNoise kByHand{0.003, 0.01}, kByTopic{0.001, 0.001};
/// The corners need no second for a robot that rolls out; there are many of them.
constexpr Duration kStillFor = 300ms;

std::optional<FloorPose> end_in(const std::string& text) {
  const auto comma = text.find(',');
  if (comma == std::string::npos) return std::nullopt;
  const auto x = number_in_answer(text.substr(0, comma)), y = number_in_answer(text.substr(comma + 1));
  if (!x || !y) return std::nullopt;
  return FloorPose{*x, *y, 0.0};
}

Problem problem_of(EstimateFault fault, const std::string& node) {
  switch (fault) {
    case EstimateFault::TooFew:
      return {node, "too little was measured for three unknowns",
              "add the straight line (--distance), or more --squares"};
    case EstimateFault::NotSeen:
      return {node, "what was measured does not show radii and separation apart",
              "add the straight line (--distance), and let the squares be larger (--side)"};
    case EstimateFault::Contradictory:
      return {node, "no wheels fit what was measured: the ends are off by more than 5 % of the ways",
              "did a wheel slip, or were ahead and left, or their signs, mixed up? Begin anew"};
    case EstimateFault::Absurd: break;
  }
  return {node, "a multiplier would change by more than a factor of two: that is no calibration",
          "check the unit of the answers and the base's parameters"};
}

/// One run of the command. Each step returns its exit code when it fails, and has printed why.
class SquareCalibration {
 public:
  SquareCalibration(const BaseWish& wish, Dialogue& dialogue, std::string node, std::string odometry, BaseTopics topics,
                    const BaseParameters& base)
      : wish_(wish),
        dialogue_(dialogue),
        node_(std::move(node)),
        odometry_(std::move(odometry)),
        silence_(topics.silence),
        believed_(base.geometry),
        driver_(dialogue, std::move(topics), base) {}

  int run() {
    if (const int code = agree(plan()); code != kDone) return code;
    if (wish_.distance_m > 0.0 && wish_.truth.empty()) {
      if (const int code = line(); code != kDone) return code;
    }
    for (const bool is_left : {false, true}) {
      for (std::size_t i = 0; i < wish_.squares; ++i) {
        const std::size_t number = i + 1 + (is_left ? wish_.squares : 0);
        if (const int code = square(is_left, number); code != kDone) return code;
      }
    }
    return estimate();
  }

  [[nodiscard]] std::string text() const {
    const BaseGeometry& base = found_->base;
    std::string text = parameter_file(node_,
                                      {"Written by `nacelle base calibrate --umbmark`. An odometry with wheel "
                                       "parameters of its own needs these, too;",
                                       "one without takes them from the base."},
                                      {parameter_line("left_wheel_radius_multiplier", base.left_radius_multiplier),
                                       parameter_line("right_wheel_radius_multiplier", base.right_radius_multiplier),
                                       parameter_line("wheel_separation_multiplier", base.separation_multiplier)});
    if (found_->slip && !odometry_.empty()) {
      text += parameter_file(
          odometry_,
          {"How much the wheels slipped meanwhile. Give this file to the odometry as well; its parameters k_left,",
           "k_right and k_turn would replace these."},
          {parameter_line("slip.distance_stddev_per_sqrt_m", std::sqrt(found_->slip->distance_m)),
           parameter_line("slip.heading_stddev_per_sqrt_m", std::sqrt(found_->slip->heading_per_m)),
           parameter_line("slip.heading_stddev_per_sqrt_rad", std::sqrt(found_->slip->heading_per_rad))});
    }
    return text;
  }

 private:
  [[nodiscard]] std::string plan() const {
    const std::string before = wish_.distance_m > 0.0 && wish_.truth.empty()
                                   ? fmt::format("a straight line of {:.2f} m, then ", wish_.distance_m)
                                   : "";
    return fmt::format(
        "UMBmark: the robot will drive {}squares of {:.2f} m, {} to the right and {} to the left. It needs {:.2f} m "
        "ahead "
        "of it, {:.2f} m to both of its sides, and half a metre around that. Clear the place",
        before, wish_.side_m, wish_.squares, wish_.squares,
        std::max(wish_.side_m, before.empty() ? 0.0 : wish_.distance_m), wish_.side_m);
  }

  int agree(const std::string& what) {
    if (!wish_.yes) return dialogue_.ask_for_enter(what);
    dialogue_.say(what);
    return kDone;
  }

  [[nodiscard]] static WheelPath path_of(const std::vector<WheelSample>& samples) {
    WheelPath path;
    path.reserve(samples.size());
    for (const auto& sample : samples) path.push_back(sample.turn);
    return path;
  }
  /// A path that goes on where another one has ended.
  static void append(WheelPath& path, const WheelPath& next) {
    if (path.empty()) path.emplace_back();
    const auto end = path.back();
    for (std::size_t i = 1; i < next.size(); ++i)
      path.push_back({end.left_rad + next[i].left_rad, end.right_rad + next[i].right_rad});
  }

  int line() {
    if (const int code = agree("straight line: mark on the floor where the robot stands"); code != kDone) return code;
    if (const auto done = driver_.drive(kStraight, wish_.distance_m, wish_.speed_mps); !done) return done.error();
    DrivenWay way{path_of(driver_.path()), Measured::Distance};
    dialogue_.say(fmt::format("  it stands; by its wheels it drove {:.3f} m", end_of(believed_, way.path).pose.x()));
    if (wish_.measured_distance_m > 0.0) {
      way.x_m = wish_.measured_distance_m;
    } else {
      const auto real = dialogue_.ask_for_number("  how many metres did it really drive?");
      if (!real) return real.error();
      way.x_m = *real;
    }
    ways_.push_back(std::move(way));
    return kDone;
  }

  Result<FloorPose, int> measure() { return measure_pose(dialogue_, wish_.container, wish_.truth, silence_); }

  /// Drives a leg; with a topic of truth, measures its end as well.
  int leg(const Motion& motion, double target, double speed, WheelPath& whole, FloorPose& here) {
    if (const auto done = driver_.drive(motion, target, speed); !done) return done.error();
    WheelPath path = path_of(driver_.path());
    append(whole, path);
    if (wish_.truth.empty()) return kDone;
    const auto there = measure();
    if (!there) return there.error();
    const FloorPose moved = seen_from(here, *there);
    ways_.push_back({std::move(path), Measured::Pose, moved.x_m, moved.y_m, moved.yaw_rad});
    here = *there;
    return kDone;
  }

  int square(bool is_left, std::size_t number) {
    const std::string name = fmt::format("square {} of {}, {}", number, 2 * wish_.squares,
                                         is_left ? "to the left (counter-clockwise)" : "to the right (clockwise)");
    const bool asks = wish_.truth.empty();
    FloorPose begin;
    if (asks) {
      if (const int code = agree(name + ": put the robot on its mark, looking along its line"); code != kDone)
        return code;
    } else {
      dialogue_.say(name);
      const auto here = measure();
      if (!here) return here.error();
      begin = *here;
    }
    FloorPose here = begin;
    WheelPath whole;
    for (int side = 0; side < kSides; ++side) {
      if (const int code = leg(kStraight, wish_.side_m, wish_.speed_mps, whole, here); code != kDone) return code;
      const int code = leg(is_left ? kTurnLeft : kTurnRight, kCorner_rad, wish_.yaw_rate_rps, whole, here);
      if (code != kDone) return code;
    }
    const auto end = end_of(believed_, whole).pose;
    dialogue_.say(
        fmt::format("  it stands; by its wheels {:.3f} m ahead and {:.3f} m left of its mark", end.x(), end.y()));
    const auto real = asks ? asked_end(number) : Result<FloorPose, int>{seen_from(begin, here)};
    if (!real) return real.error();
    if (!asks) {
      dialogue_.say(fmt::format("  by {} {:.3f} m ahead and {:.3f} m left", wish_.truth, real->x_m, real->y_m));
    } else {
      ways_.push_back({std::move(whole), Measured::Position, real->x_m, real->y_m, 0.0});
    }
    (is_left ? left_ : right_).push_back({real->x_m - end.x(), real->y_m - end.y()});
    return kDone;
  }

  Result<FloorPose, int> asked_end(std::size_t number) {
    if (number <= wish_.measured_ends.size()) return *end_in(wish_.measured_ends[number - 1]);
    const auto x =
        dialogue_.ask_for_any_number("  how many metres ahead of its mark does it stand? (behind it: negative)");
    if (!x) return err(x.error());
    const auto y = dialogue_.ask_for_any_number("  how many metres left of its mark's line? (right: negative)");
    if (!y) return err(y.error());
    return FloorPose{*x, *y, 0.0};
  }

  int estimate() {
    const auto umbmark = calibration::umbmark_of(right_, left_, wish_.side_m, believed_.separation_m());
    dialogue_.say(
        fmt::format("UMBmark: clockwise ({:.3f}, {:.3f}) m, counter-clockwise ({:.3f}, {:.3f}) m, E_max,syst {:.3f} m",
                    umbmark.clockwise.x_m, umbmark.clockwise.y_m, umbmark.counter_clockwise.x_m,
                    umbmark.counter_clockwise.y_m, umbmark.worst_m));
    dialogue_.say(fmt::format("  Type A, separation: alpha {:.3f} degrees, E_b {:.5f}", kDegrees * umbmark.alpha_rad,
                              umbmark.separation_ratio));
    dialogue_.say(fmt::format("  Type B, unequal wheels: beta {:.3f} degrees, E_d {:.5f}", kDegrees * umbmark.beta_rad,
                              umbmark.radius_ratio));
    auto found =
        estimate_base(believed_, corrected(believed_, umbmark), ways_, wish_.truth.empty() ? kByHand : kByTopic);
    if (!found) return complain(problem_of(found.error(), node_));
    found_ = *found;
    const BaseGeometry& base = found_->base;
    dialogue_.say(fmt::format("was:  wheel radius {:.5f} m left, {:.5f} m right, separation {:.5f} m",
                              believed_.left_radius_m(), believed_.right_radius_m(), believed_.separation_m()));
    dialogue_.say(fmt::format(
        "now:  wheel radius {:.5f} m left (+-{:.2f} %), {:.5f} m right (+-{:.2f} %), separation {:.5f} m (+-{:.2f} %)",
        base.left_radius_m(), 100.0 * found_->left_stddev, base.right_radius_m(), 100.0 * found_->right_stddev,
        base.separation_m(), 100.0 * found_->separation_stddev));
    dialogue_.say(fmt::format("  the ends were off by {:.4f} m, and are now by {:.4f} m (RMS)", found_->rms_before_m,
                              found_->rms_after_m));
    if (!found_->slip) {
      dialogue_.say("slip: left out: too few measurements; 3 squares each way tell it");
    } else if (odometry_.empty()) {
      dialogue_.say("slip: left out: there is no node " + wish_.odometry + "; name the odometry with --odometry");
    } else {
      dialogue_.say(fmt::format(
          "slip: after 1 m {:.1f} mm and {:.2f} degrees, after a turn on the spot of 90 degrees {:.2f} degrees",
          1e3 * std::sqrt(found_->slip->distance_m), kDegrees * std::sqrt(found_->slip->heading_per_m),
          kDegrees * std::sqrt(corner_variance())));
    }
    return kDone;
  }

  /// Of the heading, after a corner.
  [[nodiscard]] double corner_variance() const {
    const double rolled_m = kCorner_rad * found_->base.separation_m() / 2.0;
    return found_->slip->heading_per_m * rolled_m + found_->slip->heading_per_rad * kCorner_rad;
  }

  const BaseWish& wish_;
  Dialogue& dialogue_;
  const std::string node_, odometry_;
  const Duration silence_;
  const BaseGeometry believed_;
  BaseDriver driver_;
  std::vector<DrivenWay> ways_;
  std::vector<SquareError> left_, right_;
  std::optional<BaseEstimate> found_;
};

}  // namespace

std::string wrong_end(const std::string& text) {
  return end_in(text) ? "" : "'" + text + "' is not X,Y in metres, such as 0.03,-0.12";
}

int calibrate_by_squares(const BaseWish& wish, Dialogue& dialogue, ask::Nodes& nodes, const std::string& node,
                         BaseTopics topics, const BaseParameters& base) {
  topics.still_for = kStillFor;
  const auto odometry = nodes.find(wish.odometry);
  BaseWish asked = wish;
  if (!asked.truth.empty()) asked.truth = beside(node, asked.truth);
  SquareCalibration calibration{asked, dialogue, node, odometry ? *odometry : std::string{}, std::move(topics), base};
  if (const int code = calibration.run(); code != kDone) return code;
  return write_output(wish.output, calibration.text());
}

}  // namespace nacelle::cli
