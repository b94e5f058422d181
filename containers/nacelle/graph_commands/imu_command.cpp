// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ask/parameters.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/commands.hpp"
#include "graph_commands/topic_listener.hpp"
#include "imu/model/imu_fit.hpp"
#include "nacelle/base/json_text.hpp"

namespace nacelle::cli {
namespace {

using imu::Vector3;
using nlohmann::json;

constexpr double kGravity = 9.80665;
constexpr double kStillGyro = 0.02, kStillAcceleration = 0.3;  // rad/s, m/s^2: scatter of a sensor that is held still

struct ImuWish {
  Whom whom;
  std::string node = "imu", output = "imu_calibration.yaml";
  double rest_s = 2.0, turn_s = 30.0;
  bool gyro = false, accel = false, mag = false;
};

struct Readings {
  std::vector<Vector3> rates, accelerations;
};

Vector3 vector_in(const json& message, const char* field) {
  const json& v = message.at(field);
  return {v.at("x").get<double>(), v.at("y").get<double>(), v.at("z").get<double>()};
}

double seconds_in(const json& message) {
  const json& stamp = message.at("header").at("stamp");
  return stamp.at("sec").get<double>() + 1e-9 * stamp.at("nanosec").get<double>();
}

/// Passes the messages of a topic to `take`, for so long by their stamps. Errors: the exit code.
Result<void, int> collect(const ImuWish& wish, const std::string& topic, double seconds,
                          const std::function<void(const json&)>& take) {
  Listening listening;
  listening.whom = wish.whom;
  listening.topics = {{topic, ""}};
  listening.show = "json";
  std::optional<double> begin;
  bool complete = false;
  const int code = listen(listening, [&](std::size_t, std::string_view text) {
    const json message = parse_json_or_discard(std::string{text});
    if (!message.is_object() || !message.contains("header")) return true;
    const double now = seconds_in(message);
    if (!begin) begin = now;
    take(message);
    complete = now - *begin >= seconds;
    return !complete;
  });
  if (complete) return {};
  return err(code == kDone ? kFailed : code);
}

Vector3 mean_of(const std::vector<Vector3>& all) {
  Vector3 mean{};
  for (const auto& v : all) {
    for (std::size_t i = 0; i < 3; ++i) mean[i] += v[i] / static_cast<double>(all.size());
  }
  return mean;
}

/// The standard deviation of the worst axis.
double scatter_of(const std::vector<Vector3>& all) {
  const Vector3 mean = mean_of(all);
  Vector3 squares{};
  for (const auto& v : all) {
    for (std::size_t i = 0; i < 3; ++i) squares[i] += std::pow(v[i] - mean[i], 2) / static_cast<double>(all.size());
  }
  return std::sqrt(std::max({squares[0], squares[1], squares[2]}));
}

void say(const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); }

/// Waits for Enter. False at the end of the input.
bool ask_for_enter(const std::string& text) {
  std::fprintf(stderr, "%s, then press Enter ", text.c_str());
  std::string line;
  return static_cast<bool>(std::getline(std::cin, line));
}

std::string why(imu::FitFault fault) {
  switch (fault) {
    case imu::FitFault::TooFew: return "too few readings";
    case imu::FitFault::NotCovered: return "not all directions were seen: turn it further, and into every direction";
    case imu::FitFault::NoEllipsoid:
      return "the readings do not lie on an ellipsoid: it moved, or something magnetic is near";
    case imu::FitFault::Absurd: return "the scale is off by more than a third: is this the right topic?";
  }
  return "unknown";
}

template <std::size_t N>
std::array<double, N> list_in(const std::map<std::string, json>& parameters, const char* name,
                              std::array<double, N> otherwise) {
  const auto found = parameters.find(name);
  if (found == parameters.end() || !found->second.is_array() || found->second.size() != N) return otherwise;
  for (std::size_t i = 0; i < N; ++i) otherwise[i] = found->second[i].get<double>();
  return otherwise;
}

/// One run of the command.
class Calibration {
 public:
  Calibration(const ImuWish& wish, std::string node, std::map<std::string, json> parameters)
      : wish_(wish),
        node_(std::move(node)),
        parameters_(std::move(parameters)),
        mounting_(list_in<3>(parameters_, "mounting_rpy", {})) {}

  int run() {
    if (wish_.gyro && !gyro()) return code_;
    if (wish_.accel && !accel()) return code_;
    if (wish_.mag && !mag()) return code_;
    return write();
  }

 private:
  [[nodiscard]] std::string topic(const char* name) const {
    const auto slash = node_.rfind('/');
    return node_.substr(0, slash + 1) + name;
  }
  bool fail(const std::string& what, const std::string& way_out) {
    code_ = complain(Problem{node_, what, way_out});
    return false;
  }
  bool rest(Readings& into) {
    const auto done = collect(wish_, topic("imu/data_raw"), wish_.rest_s, [&](const json& message) {
      into.rates.push_back(vector_in(message, "angular_velocity"));
      into.accelerations.push_back(vector_in(message, "linear_acceleration"));
    });
    if (!done) code_ = done.error();
    return static_cast<bool>(done);
  }

  bool gyro() {
    if (parameters_.count("calibrate_gyro") != 0 && parameters_["calibrate_gyro"] == json(true)) {
      say("gyro: left out, since calibrate_gyro measures its bias at each activation");
      return true;
    }
    if (!ask_for_enter("gyro: keep the robot still")) return fail("the input ended", "run it in a terminal");
    Readings still;
    if (!rest(still)) return false;
    if (scatter_of(still.rates) > kStillGyro)
      return fail(fmt::format("it moved: the gyro scatters by {:.3f} rad/s", scatter_of(still.rates)), "keep it still");
    const Vector3 left = imu::in_sensor_axes(mean_of(still.rates), mounting_);
    Vector3 bias = list_in<3>(parameters_, "gyro_bias", {});
    for (std::size_t i = 0; i < 3; ++i) bias[i] += left[i];
    say(fmt::format("gyro: bias ({:.5f}) rad/s", fmt::join(bias, " ")));
    lines_.push_back(fmt::format("gyro_bias: [{:.9g}]", fmt::join(bias, ", ")));
    return true;
  }

  bool accel() {
    std::vector<Vector3> positions;
    std::array<bool, 6> seen{};
    while (positions.size() < 6) {
      if (!ask_for_enter(
              fmt::format("accelerometer, side {} of 6: put the sensor on another side", positions.size() + 1)))
        return fail("the input ended", "run it in a terminal");
      Readings still;
      if (!rest(still)) return false;
      if (scatter_of(still.accelerations) > kStillAcceleration || scatter_of(still.rates) > kStillGyro) {
        say("  it moved; once more");
        continue;
      }
      const Vector3 mean = mean_of(still.accelerations);
      std::size_t axis = 0;
      for (std::size_t i = 1; i < 3; ++i) {
        if (std::abs(mean[i]) > std::abs(mean[axis])) axis = i;
      }
      const std::size_t side = 2 * axis + (mean[axis] > 0 ? 0 : 1);
      const std::string name = fmt::format("{}{}", mean[axis] > 0 ? '+' : '-', "xyz"[axis]);
      if (std::exchange(seen[side], true)) {
        say(fmt::format("  {} is up again; another side, please", name));
        continue;
      }
      say(fmt::format("  {} is up: ({:.3f}) m/s^2", name, fmt::join(mean, " ")));
      positions.push_back(mean);
    }
    const auto fit = imu::fit_acceleration(positions, kGravity);
    if (!fit) return fail("accelerometer: " + why(fit.error()), "begin anew");
    take("accelerometer", "accel", *fit, "m/s^2", 1.0);
    return true;
  }

  bool mag() {
    if (!ask_for_enter(
            fmt::format("magnetometer: turn the robot slowly into every direction for {:.0f} s (a robot that cannot "
                        "tilt: on the spot, more than once); begin",
                        wish_.turn_s)))
      return fail("the input ended", "run it in a terminal");
    std::vector<Vector3> readings;
    const auto done = collect(wish_, topic("imu/mag"), wish_.turn_s,
                              [&](const json& message) { readings.push_back(vector_in(message, "magnetic_field")); });
    if (!done) {
      code_ = done.error();
      return false;
    }
    const auto fit = imu::fit_field(readings);
    if (!fit) return fail("magnetometer: " + why(fit.error()), "begin anew, away from iron and motors");
    if (fit->is_flat) say("  turned about z only: x and y are calibrated, z is left as it is");
    take("magnetometer", "mag", *fit, "uT", 1e6);
    return true;
  }

  void take(const char* what, const std::string& prefix, const imu::VectorFit& fit, const char* unit, double scale) {
    const imu::AffineCorrection now{list_in<3>(parameters_, (prefix + "_bias").c_str(), {}),
                                    list_in<9>(parameters_, (prefix + "_matrix").c_str(), imu::kIdentity3)};
    const auto total = imu::composed(now, mounting_, fit);
    say(fmt::format("{}: length {:.3f} {} within {:.3f} RMS", what, scale * fit.length, unit, scale * fit.rms_error));
    lines_.push_back(fmt::format("{}_bias: [{:.9g}]", prefix, fmt::join(total.bias, ", ")));
    lines_.push_back(fmt::format("{}_matrix: [{:.9g}]", prefix, fmt::join(total.matrix, ", ")));
  }

  int write() {
    if (lines_.empty()) return complain(Problem{node_, "nothing was calibrated", "name --gyro, --accel or --mag"});
    std::ofstream file{wish_.output};
    file << "# Written by `nacelle imu calibrate`: parameters of " << node_ << ", instead of those it had then.\n"
         << node_ << ":\n  ros__parameters:\n";
    for (const auto& line : lines_) file << "    " << line << '\n';
    file.close();
    if (!file) return complain(Problem{wish_.output, "cannot be written", "give another --output"});
    print_text("%s written; give it to the IMU's entry of the launch file: parameters: [%s]\n", wish_.output.c_str(),
               wish_.output.c_str());
    return kDone;
  }

  const ImuWish& wish_;
  const std::string node_;
  std::map<std::string, json> parameters_;
  const Vector3 mounting_;
  std::vector<std::string> lines_;
  int code_ = kDone;
};

int calibrate(ImuWish wish) {
  if (!wish.gyro && !wish.accel && !wish.mag) wish.gyro = wish.accel = wish.mag = true;
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  auto node = nodes.find(wish.node);
  if (!node) return complain(node.error());
  auto listed = ask::list_parameters(nodes, node.value());
  if (!listed) return complain(listed.error());
  std::map<std::string, json> parameters;
  for (const auto& row : listed.value()) parameters[row["name"].get<std::string>()] = row["value"];
  if (parameters.count("accel_matrix") == 0)
    return complain(Problem{node.value(), "is no IMU of nacelle::imu::ImuComponent", "name the node with --node"});
  return Calibration{wish, node.value(), std::move(parameters)}.run();
}

}  // namespace

void add_imu_commands(Command& root) {
  auto wish = std::make_shared<ImuWish>();
  Command& group = root.add("imu", "inertial sensors");
  Command& command = group.add("calibrate", "measure the errors of an IMU, and write its parameters as YAML");
  command.option("--node", wish->node, "the IMU's node").with_default().names_a(Names::Node);
  command.option("-o,--output", wish->output, "the file").with_default().names_a(Names::File);
  command.flag("--gyro", wish->gyro, "the gyro's bias, at rest");
  command.flag("--accel", wish->accel, "the accelerometer's bias and scale, from six sides");
  command.flag("--mag", wish->mag, "the magnetometer's hard and soft iron, from turns");
  command.option("--rest", wish->rest_s, "s of readings at rest").with_default().within(0.1, 600.0);
  command.option("--turn", wish->turn_s, "s of readings while it turns").with_default().within(1.0, 600.0);
  command.note("Without --gyro, --accel and --mag all three. The IMU must be active.");
  add_container_option(command, wish->whom.container);
  command.runs([wish] { return calibrate(*wish); });
}

}  // namespace nacelle::cli
