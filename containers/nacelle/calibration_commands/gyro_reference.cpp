// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/gyro_reference.hpp"

#include <fmt/format.h>

#include <optional>

#include "calibration_commands/imu_message.hpp"
#include "calibration_commands/model/rest.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {
namespace {

constexpr double kRest_s = 2.0;

}  // namespace

Result<GyroReference, int> GyroReference::begin(const Dialogue& dialogue, const std::string& container,
                                                const std::string& topic, Duration silence) {
  calibration::RestReadings still;
  std::optional<double> begin;
  const int code = collect(dialogue, container, topic, silence, [&](const nlohmann::json& message) {
    const double now = stamp_s(message);
    if (!begin || now < *begin) begin = now;
    still.rates_rps.push_back(vector_in(message, "angular_velocity"));
    still.accelerations_mps2.push_back(vector_in(message, "linear_acceleration"));
    return now - *begin < kRest_s;
  });
  if (code != kDone) return err(code);
  if (const auto fine = calibration::check_rest(still); !fine)
    return err(complain({"topic " + topic, "the robot was not at rest, or the gyro is not one",
                         "let it stand still and begin anew, or answer the question about the turns instead"}));
  auto reader = TopicReader::open(container, topic);
  if (!reader) return err(reader.error());
  return GyroReference{std::move(reader).value(), calibration::mean_of(still.rates_rps)[2]};
}

Result<void, Problem> GyroReference::take() {
  while (true) {
    const auto message = reader_.take();
    if (!message) return err(message.error());
    if (!*message) return {};
    try {
      yaw_.take(stamp_s(**message), vector_in(**message, "angular_velocity")[2]);
    } catch (const nlohmann::json::exception&) {
      return err(Problem{"topic " + reader_.topic(), "has messages of another type than sensor_msgs/Imu", ""});
    }
  }
}

Result<double, Problem> GyroReference::yaw_rad() const {
  if (yaw_.is_whole()) return yaw_.yaw_rad();
  return err(Problem{"topic " + reader_.topic(),
                     fmt::format("readings are missing: a gap of {:.2f} s", yaw_.longest_gap_s()),
                     "begin anew while the machine is less busy, or answer the question about the turns instead"});
}

}  // namespace nacelle::cli
