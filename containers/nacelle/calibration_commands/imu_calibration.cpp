// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/imu_calibration.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/imu_drive.hpp"
#include "calibration_commands/imu_message.hpp"
#include "calibration_commands/model/rest.hpp"
#include "calibration_commands/parameter_lines.hpp"
#include "calibration_commands/topic_reader.hpp"
#include "cli/asking.hpp"
#include "cli/program.hpp"
#include "imu/model/imu_fit.hpp"

namespace nacelle::cli {
namespace {

using calibration::RestFault;
using calibration::RestReadings;
using imu::Vector3;
using nlohmann::json;

/// A field is longer, even its part along the floor near a magnetic pole; the noise of a sensor at rest is shorter. Unit: T.
constexpr double kLeastField = 2e-6;

/// Whether a part of sensor_msgs/Imu is absent: REP 145, the first element of its covariance is -1.
bool is_absent(const json& message, const char* covariance) {
  return message.at(covariance).at(0).get<double>() == -1.0;
}

std::string why(RestFault fault, const RestReadings& got, double rest_s) {
  switch (fault) {
    case RestFault::TooFew: return fmt::format("only {} readings came in {:.1f} s", got.rates_rps.size(), rest_s);
    case RestFault::Moving:
      return fmt::format("it moved: the gyro scatters by {:.3f} rad/s, the accelerometer by {:.2f} m/s^2",
                         calibration::scatter_of(got.rates_rps), calibration::scatter_of(got.accelerations_mps2));
    case RestFault::Turning:
      return fmt::format("it turns: the gyro reads ({:.3f}) rad/s",
                         fmt::join(calibration::mean_of(got.rates_rps), " "));
  }
  return "unknown";
}

std::string way_out(RestFault fault) {
  return fault == RestFault::TooFew ? "measure longer with --rest" : "put it down, and do not touch it meanwhile";
}

/// `otherwise`: why the readings may lie on no ellipsoid.
std::string why(imu::FitFault fault, const char* otherwise) {
  switch (fault) {
    case imu::FitFault::TooFew: return "too few readings came";
    case imu::FitFault::NotCovered: return "it was not turned into every direction";
    case imu::FitFault::NoEllipsoid: return std::string{"the readings do not lie on an ellipsoid: "} + otherwise;
    case imu::FitFault::Absurd: return "the scale is off by more than a third: this may be the wrong topic";
  }
  return "unknown";
}

/// One run of the command. Each step returns its exit code when it fails, and has printed why.
class ImuCalibration {
 public:
  ImuCalibration(const ImuWish& wish, Dialogue& dialogue, std::string node, ParametersOf parameters, bool has_field)
      : wish_(wish),
        dialogue_(dialogue),
        node_(std::move(node)),
        parameters_(std::move(parameters)),
        mounting_(list_in<3>(parameters_, "mounting_rpy", {})),
        gyro_bias_(list_in<3>(parameters_, "gyro_bias", {})),
        accel_(correction_in("accel")),
        mag_(correction_in("mag")),
        has_field_(has_field) {}

  int run(ask::Nodes& nodes) {
    const bool all = !wish_.gyro && !wish_.accel && !wish_.mag && !wish_.drive;
    if (wish_.gyro || all) {
      if (const int code = gyro(all); code != kDone) return code;
    }
    if (wish_.accel || all) {
      if (const int code = accel(); code != kDone) return code;
    }
    if (wish_.mag || all) {
      if (const int code = mag(all); code != kDone) return code;
    }
    if (!wish_.drive) return kDone;
    const auto found = find_mounting(wish_, dialogue_, nodes, node_, mounting_);
    if (!found) return found.error();
    found_ = *found;
    return kDone;
  }

  /// All of the corrections, so that the file may replace an earlier one.
  [[nodiscard]] std::string text() const {
    std::vector<std::string> comments{"Written by `nacelle imu calibrate`: they replace the corrections that " + node_ +
                                      " had when it was measured."};
    if (found_) {
      comments.push_back("The joint of " + found_->frame + " in the robot's description, seen from " +
                         found_->base_frame + " (the height is as it was):");
      comments.push_back(fmt::format("  <origin xyz=\"{:.4f}\" rpy=\"{:.4f}\"/>", fmt::join(found_->place_m, " "),
                                     fmt::join(found_->rpy_rad, " ")));
    }
    return parameter_file(node_, comments,
                          {parameter_line("mounting_rpy", found_ ? found_->mounting_rpy_rad : mounting_),
                           parameter_line("gyro_bias", gyro_bias_), parameter_line("accel_bias", accel_.bias),
                           parameter_line("accel_matrix", accel_.matrix), parameter_line("mag_bias", mag_.bias),
                           parameter_line("mag_matrix", mag_.matrix)});
  }

 private:
  [[nodiscard]] imu::AffineCorrection correction_in(const std::string& prefix) const {
    return {list_in<3>(parameters_, prefix + "_bias", {}),
            list_in<9>(parameters_, prefix + "_matrix", imu::kIdentity3)};
  }

  /// Passes the messages of so many seconds, by their stamps.
  int listen(const std::string& topic, double seconds, const std::function<void(const json&)>& take) {
    std::optional<double> begin;
    int quarters = 0;
    return collect(dialogue_, wish_.container, beside(node_, topic), from_seconds(wish_.wait_s),
                   [&](const json& message) {
                     const double now = stamp_s(message);
                     if (!begin || now < *begin) begin = now;  // the clock was set back
                     take(message);
                     const double part = (now - *begin) / seconds;
                     if (seconds > 5.0 && part < 1.0 && static_cast<int>(4.0 * part) > quarters)
                       dialogue_.say(fmt::format("  {} %", 25 * (quarters = static_cast<int>(4.0 * part))));
                     return part < 1.0;
                   });
  }

  Result<RestReadings, int> rest() {
    RestReadings got;
    const int code = listen(wish_.data, wish_.rest_s, [&](const json& message) {
      got.rates_rps.push_back(vector_in(message, "angular_velocity"));
      got.accelerations_mps2.push_back(vector_in(message, "linear_acceleration"));
      has_gyro_ = !is_absent(message, "angular_velocity_covariance");
    });
    if (code != kDone) return err(code);
    return got;
  }

  int gyro(bool may_be_left_out) {
    if (const auto own = parameters_.find("calibrate_gyro"); own != parameters_.end() && own->second == json(true)) {
      const Problem problem{Place::of_parameter("calibrate_gyro", node_),
                            "the node measures the gyro's bias itself at each activation",
                            "set it to false to use a bias from a file"};
      if (!may_be_left_out) return complain(problem);
      dialogue_.say("gyro: left out: " + problem.what);
      return kDone;
    }
    if (const int code = dialogue_.ask_for_enter("gyro: put the robot down and keep it still"); code != kDone)
      return code;
    auto still = rest();
    if (!still) return still.error();
    if (!has_gyro_) return leave_out("gyro", "the device sends no angular velocity", may_be_left_out);
    if (const auto fine = calibration::check_rest(*still); !fine)
      return complain({node_, "gyro: " + why(fine.error(), *still, wish_.rest_s), way_out(fine.error())});
    const Vector3 left = imu::in_sensor_axes(calibration::mean_of(still->rates_rps), mounting_);
    for (std::size_t i = 0; i < 3; ++i) gyro_bias_[i] += left[i];
    dialogue_.say(fmt::format("gyro: bias ({:.5f}) rad/s", fmt::join(gyro_bias_, " ")));
    return kDone;
  }

  int leave_out(const char* what, const std::string& because, bool may_be_left_out) {
    if (!may_be_left_out) return complain({node_, fmt::format("{}: {}", what, because), "leave its option out"});
    dialogue_.say(fmt::format("{}: left out: {}", what, because));
    return kDone;
  }

  int accel() {
    std::vector<Vector3> positions;
    std::array<bool, 6> seen{};
    while (positions.size() < seen.size()) {
      const int code = dialogue_.ask_for_enter(
          fmt::format("accelerometer, side {} of 6: put another side up and let go", positions.size() + 1));
      if (code != kDone) return code;
      auto still = rest();
      if (!still) return still.error();
      // A bias of the gyro is no motion.
      if (const auto fine = calibration::check_rest(*still); !fine && fine.error() != RestFault::Turning) {
        dialogue_.say(fmt::format("  {}; {}", why(fine.error(), *still, wish_.rest_s), way_out(fine.error())));
        continue;
      }
      const Vector3 mean = calibration::mean_of(still->accelerations_mps2);
      const auto side = calibration::side_up(mean);
      if (std::exchange(seen[side.index], true)) {
        dialogue_.say("  " + side.name + " is up again; choose another side");
        continue;
      }
      dialogue_.say(fmt::format("  {} is up: ({:.3f}) m/s^2", side.name, fmt::join(mean, " ")));
      positions.push_back(mean);
    }
    const auto fit = imu::fit_acceleration(positions, imu::kGravityMps2);
    if (!fit)
      return complain({node_, "accelerometer: " + why(fit.error(), "it moved"), "begin anew, and let go each time"});
    take("accelerometer", accel_, *fit, "m/s^2", 1.0);
    return kDone;
  }

  int mag(bool may_be_left_out) {
    if (!has_field_)
      return leave_out("magnetometer", "nothing publishes " + beside(node_, wish_.field), may_be_left_out);
    dialogue_.say(fmt::format("magnetometer: turn the robot slowly into every direction for {:.0f} s", wish_.turn_s));
    dialogue_.say("  (one that cannot be tilted: on the spot, at least twice round)");
    if (const int code = dialogue_.ask_for_enter("  be ready"); code != kDone) return code;
    std::vector<Vector3> readings;
    const int code = listen(wish_.field, wish_.turn_s,
                            [&](const json& message) { readings.push_back(vector_in(message, "magnetic_field")); });
    if (code != kDone) return code;
    auto fit = imu::fit_field(readings);
    if (fit && fit->length < kLeastField) fit = err(imu::FitFault::NotCovered);
    if (!fit)
      return complain({node_, "magnetometer: " + why(fit.error(), "it was not turned enough, or iron is near"),
                       "begin anew, away from iron, and turn it all the way round"});
    if (fit->is_flat) dialogue_.say("  turned about z only: x and y are calibrated, z stays as it was");
    take("magnetometer", mag_, *fit, "uT", 1e6);
    return kDone;
  }

  void take(const char* what, imu::AffineCorrection& correction, const imu::VectorFit& fit, const char* unit,
            double scale) {
    correction = imu::composed(correction, mounting_, fit);
    dialogue_.say(fmt::format("{}: length {:.3f} {}, {:.3f} {} RMS off it", what, scale * fit.length, unit,
                              scale * fit.rms_error, unit));
  }

  const ImuWish& wish_;
  Dialogue& dialogue_;
  const std::string node_;
  const ParametersOf parameters_;
  const Vector3 mounting_;
  Vector3 gyro_bias_;
  imu::AffineCorrection accel_, mag_;
  const bool has_field_;
  bool has_gyro_ = true;
  std::optional<ImuMounting> found_;
};

}  // namespace

int calibrate_imu(const ImuWish& wish) {
  Dialogue dialogue;
  if (auto fine = check_output(wish.output); !fine) return complain(fine.error());
  auto client = connect(wish.container);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  auto node = nodes.find(wish.node);
  if (!node) return complain(node.error());
  auto parameters = parameters_of(nodes, *node);
  if (!parameters) return complain(parameters.error());
  if (!parameters->contains("accel_matrix"))
    return complain({*node, "is not a nacelle::imu::ImuComponent", "name the IMU's node with --node"});
  const auto graph = nodes.graph();
  if (!graph) return complain(graph.error());
  const std::string field = beside(*node, wish.field);
  const bool has_field = !texts_of(graph.value()["endpoints"], "node", [&](const json& end) {
                            return end["publisher"].get<bool>() && text_of(end, "topic") == field;
                          }).empty();
  ImuCalibration calibration{wish, dialogue, *node, std::move(*parameters), has_field};
  if (const int code = calibration.run(nodes); code != kDone) return code;
  return write_output(wish.output, calibration.text());
}

}  // namespace nacelle::cli
