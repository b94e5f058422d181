// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/imu_drive.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "ask/frames.hpp"
#include "calibration_commands/base_driver.hpp"
#include "calibration_commands/imu_message.hpp"
#include "calibration_commands/model/lever_fit.hpp"
#include "calibration_commands/model/rest.hpp"
#include "calibration_commands/parameter_lines.hpp"
#include "calibration_commands/topic_reader.hpp"
#include "calibration_commands/wheel_reading.hpp"
#include "cli/program.hpp"
#include "nacelle/spatial/rotation.hpp"

namespace nacelle::cli {
namespace {

using calibration::LeverFault;
using calibration::LeverFit;
using calibration::PlanarReading;
using calibration::Progress;
using imu::Vector3;

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
constexpr Duration kTransformLimit = 2s;

Problem problem_of(LeverFault fault, const std::string& node) {
  switch (fault) {
    case LeverFault::TooFew:
      return {node, "too few readings of IMU and wheels came together",
              "drive more --eights, while the machine is less busy"};
    case LeverFault::GyroDisagrees:
      return {node, "the gyro's z axis turns otherwise than the wheels say",
              "is the IMU upside down in mounting_rpy or the description, or are the wheels uncalibrated (`nacelle "
              "base calibrate`)?"};
    case LeverFault::HardlyTurned:
      return {node, "the robot hardly turned: a lever arm shows in turns only",
              "turn faster (--yaw-rate), or drive more --eights"};
    case LeverFault::OneWay:
      return {node, "the robot turned one way only: the pull inwards cannot be told from a lever arm to the side",
              "let it drive whole eights"};
    case LeverFault::HardlyDriven:
      return {node, "the robot hardly accelerated: there is no direction to compare the IMU's with",
              "drive faster (--yaw-rate) or in wider circles (--radius)"};
    case LeverFault::Mismatch: break;
  }
  return {node, "the accelerations of the IMU are not those of the wheels",
          "did a wheel slip, or is this another robot's IMU? Calibrate the accelerometer (--accel), and drive on an "
          "even floor"};
}

Eigen::Vector3d eigen_of(const Vector3& v) { return {v[0], v[1], v[2]}; }
Vector3 listed(const Eigen::Quaterniond& q) {
  const auto rpy = spatial::rpy_from_quaternion(q);
  return {rpy.roll_rad, rpy.pitch_rad, rpy.yaw_rad};
}

/// One run of the drive. Each step returns its exit code when it fails, and has printed why.
class FigureOfEight {
 public:
  FigureOfEight(const ImuWish& wish, Dialogue& dialogue, std::string node, std::string base_frame, BaseTopics topics,
                const BaseParameters& base)
      : wish_(wish),
        dialogue_(dialogue),
        node_(std::move(node)),
        base_frame_(std::move(base_frame)),
        topic_(beside(node_, wish.data)),
        silence_(topics.silence),
        geometry_(base.geometry),
        driver_(dialogue, std::move(topics), base) {}

  Result<ImuMounting, int> run(const Vector3& mounting_rpy_rad) {
    const double radius_m = wish_.course.radius_m;
    const std::string plan = fmt::format(
        "drive: the robot will drive figures of eight, {} of them, with a radius of {:.2f} m to its left and to its "
        "right. "
        "It needs {:.2f} m to both sides, {:.2f} m ahead and behind, and half a metre around that. Clear the place",
        wish_.course.eights, radius_m, 2.0 * radius_m, radius_m);
    if (wish_.course.yes) {
      dialogue_.say(plan);
    } else if (const int code = dialogue_.ask_for_enter(plan); code != kDone) {
      return err(code);
    }
    if (const int code = rest(); code != kDone) return err(code);
    if (const int code = find_frame(); code != kDone) return err(code);
    if (const int code = drive(); code != kDone) return err(code);
    const auto fit = fit_lever(readings_, wheels_);
    if (!fit) return err(complain(problem_of(fit.error(), node_)));
    if (!fit->is_sure()) {
      return err(complain(
          {node_,
           fmt::format("the yaw is known to {:.2f} degrees and the place to {:.1f} mm only; 0.25 and 5 are asked for",
                       kDegreesPerRadian * fit->yaw_stddev_rad, 1e3 * std::max(fit->x_stddev_m, fit->y_stddev_m)),
           "turn faster (--yaw-rate), drive more --eights, and on an even floor"}));
    }
    return mounting_of(*fit, mounting_rpy_rad);
  }

 private:
  /// Two seconds at rest: the gyro's bias, and the frame of the readings.
  int rest() {
    calibration::RestReadings still;
    std::optional<double> begin;
    const int code = collect(dialogue_, wish_.container, topic_, silence_, [&](const nlohmann::json& message) {
      const double now = stamp_s(message);
      if (!begin || now < *begin) begin = now;
      still.rates_rps.push_back(vector_in(message, "angular_velocity"));
      still.accelerations_mps2.push_back(vector_in(message, "linear_acceleration"));
      frame_ = message.at("header").at("frame_id").get<std::string>();
      return now - *begin < wish_.rest_s;
    });
    if (code != kDone) return code;
    // A bias of the gyro is no motion.
    if (const auto fine = calibration::check_rest(still); !fine && fine.error() != calibration::RestFault::Turning)
      return complain(
          {"topic " + topic_, "the robot was not at rest before the drive", "let it stand still, and begin anew"});
    gyro_bias_ = eigen_of(calibration::mean_of(still.rates_rps));
    return kDone;
  }

  /// How the IMU's frame is believed to lie in the base.
  int find_frame() {
    auto client = connect(wish_.container);
    if (!client) return client.error();
    const auto found = client.value().lookup(base_frame_, frame_, kTransformLimit);
    if (!found) return complain(found.error());
    if (!found->known) {
      dialogue_.say(
          fmt::format("  no transform leads from {} to {}: their axes are taken as the same", base_frame_, frame_));
      return kDone;
    }
    const auto& q = found->rotation_xyzw;
    R_BF_ = Eigen::Quaterniond{q[3], q[0], q[1], q[2]};
    p_BF_ = eigen_of(found->translation_m);
    return kDone;
  }

  Result<void, Problem> take(TopicReader& reader) {
    while (true) {
      const auto message = reader.take();
      if (!message) return err(message.error());
      if (!*message) return {};
      try {
        const Eigen::Vector3d rate = R_BF_ * (eigen_of(vector_in(**message, "angular_velocity")) - gyro_bias_);
        const Eigen::Vector3d force = R_BF_ * eigen_of(vector_in(**message, "linear_acceleration"));
        const double stamp = stamp_s(**message);
        // A stamp that does not grow would be no function of time.
        if (readings_.empty() || stamp > readings_.back().stamp_s)
          readings_.push_back({stamp, rate.z(), force.x(), force.y()});
      } catch (const nlohmann::json::exception&) {
        return err(Problem{"topic " + topic_, "has messages of another type than sensor_msgs/Imu", ""});
      }
    }
  }

  int drive() {
    auto reader = TopicReader::open(wish_.container, topic_);
    if (!reader) return reader.error();
    const double turn_rad = 2.0 * std::numbers::pi, radius_m = wish_.course.radius_m;
    for (std::size_t eight = 0; eight < wish_.course.eights; ++eight) {
      for (const Motion& motion : {arc_left(radius_m), arc_right(radius_m)}) {
        const auto driven =
            driver_.drive(motion, turn_rad, wish_.course.yaw_rate_rps, [&] { return take(reader.value()); });
        if (!driven) return driven.error();
        append(driver_.path());
      }
      dialogue_.say(fmt::format("  {} of {}", eight + 1, wish_.course.eights));
    }
    return kDone;
  }

  /// A leg begins where the last one ended: the wheels stood between them.
  void append(const std::vector<WheelSample>& path) {
    const Progress end = wheels_.empty() ? Progress{} : wheels_.back();
    for (const auto& sample : path) {
      if (!wheels_.empty() && sample.stamp_s <= wheels_.back().stamp_s) continue;
      wheels_.push_back({sample.stamp_s, end.distance_m + distance_m(geometry_, sample.turn),
                         end.yaw_rad + yaw_rad(geometry_, sample.turn)});
    }
  }

  [[nodiscard]] ImuMounting mounting_of(const LeverFit& fit, const Vector3& mounting_rpy_rad) const {
    // R_BS is found to be Rz(yaw) R_BF R_FS. The published frame is to lie as R_BF says: R_BF R_FS' = Rz(yaw) R_BF R_FS.
    const Eigen::Quaterniond R_FS =
        spatial::quaternion_from_rpy({mounting_rpy_rad[0], mounting_rpy_rad[1], mounting_rpy_rad[2]});
    const Eigen::Quaterniond turned = spatial::quaternion_from_yaw(fit.yaw_rad);
    ImuMounting mounting;
    mounting.mounting_rpy_rad = listed(R_BF_.conjugate() * turned * R_BF_ * R_FS);
    mounting.place_m = {fit.x_m, fit.y_m, p_BF_.z()};
    mounting.rpy_rad = listed(R_BF_);
    mounting.frame = frame_;
    mounting.base_frame = base_frame_;
    dialogue_.say(fmt::format(
        "mounting yaw: {:+.2f} degrees (+-{:.2f}) beyond what it was taken for; mounting_rpy yaw is {:.4f} rad",
        kDegreesPerRadian * fit.yaw_rad, kDegreesPerRadian * fit.yaw_stddev_rad, mounting.mounting_rpy_rad[2]));
    dialogue_.say(fmt::format(
        "lever arm: x {:.4f} m (+-{:.4f}), y {:.4f} m (+-{:.4f}) in {}; the description says {:.4f}, {:.4f}", fit.x_m,
        fit.x_stddev_m, fit.y_m, fit.y_stddev_m, base_frame_, p_BF_.x(), p_BF_.y()));
    dialogue_.say(fmt::format("  from {} windows, {:.3f} m/s^2 RMS off it", fit.windows, fit.rms_mps2));
    return mounting;
  }

  const ImuWish& wish_;
  Dialogue& dialogue_;
  const std::string node_, base_frame_, topic_;
  const Duration silence_;
  const calibration::BaseGeometry geometry_;
  BaseDriver driver_;
  std::string frame_;
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero(), p_BF_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond R_BF_ = Eigen::Quaterniond::Identity();
  std::vector<PlanarReading> readings_;
  std::vector<Progress> wheels_;
};

}  // namespace

Result<ImuMounting, int> find_mounting(const ImuWish& wish, Dialogue& dialogue, ask::Nodes& nodes,
                                       const std::string& node, const Vector3& mounting_rpy_rad) {
  const auto base_node = nodes.find(wish.course.base);
  if (!base_node) return err(complain(base_node.error()));
  const auto parameters = parameters_of(nodes, *base_node);
  if (!parameters) return err(complain(parameters.error()));
  const auto names = ask::list_frames(nodes, "");
  if (!names) return err(complain(names.error()));
  BaseTopics topics;
  topics.container = wish.container;
  topics.commands = beside(*base_node, wish.course.command);
  topics.joints = beside(*base_node, wish.course.joints);
  topics.frame = names.value()["frame_prefix"].get<std::string>() + "base_link";
  topics.stamped = !wish.course.twist;
  topics.silence = from_seconds(wish.wait_s);
  auto base = base_parameters(*parameters, *base_node, topics.commands);
  if (!base) {
    Problem problem = base.error();
    problem.way_out = "name the base's node with --base";
    return err(complain(problem));
  }
  const std::string base_frame = topics.frame;
  FigureOfEight drive{wish, dialogue, node, base_frame, std::move(topics), *base};
  return drive.run(mounting_rpy_rad);
}

}  // namespace nacelle::cli
