// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/world_model.hpp"

#include <cmath>

namespace nacelle::simulation {

WorldModel::WorldModel(const WorldSettings& settings)
    : settings_(settings),
      room_(Room::with_two_boxes()),
      drive_(settings, room_),
      board_(settings.robot),
      lidar_(settings, room_),
      imu_(settings),
      gps_(settings) {}

void WorldModel::receive(Device device, ByteView bytes) {
  if (device == Device::Imu) imu_registers_.feed(bytes, to_seconds(now_));
  if (device != Device::Base) return;
  base_reader_.feed(bytes, [this](const UgvCommand& command, std::string_view text) {
    if (board_.echoes()) {
      line(Device::Base).send(now_, as_bytes(text));
      line(Device::Base).send(now_, as_bytes("\r\n"));
    }
    if (board_.on_command(command, now_)) send_feedback();
  });
}

void WorldModel::advance() {
  const Pose before = drive_.pose();
  const Duration from = now_;
  now_ += kStep;
  drive_.step(to_seconds(kStep), board_.left_target_rps(), board_.right_target_rps());
  board_.step(now_, drive_.left_angle_rad(), drive_.right_angle_rad());

  const Pose after = drive_.pose();
  for (Duration at = lidar_.next_point(); at <= now_; at = lidar_.next_point()) {
    // Between two steps the pose moves by less than a millimetre: a straight line is good enough.
    const double share = to_seconds(at - from) / to_seconds(kStep);
    const Pose pose{before.x_m + share * (after.x_m - before.x_m), before.y_m + share * (after.y_m - before.y_m),
                    before.yaw_rad + share * (after.yaw_rad - before.yaw_rad)};
    if (const auto packet = lidar_.measure(pose)) line(Device::Lidar).send(at, print_ld06(*packet));
  }

  if (imu_registers_.rate_hz() > 0.0) {
    const Duration period = from_seconds(1.0 / imu_registers_.rate_hz());
    // After a change to a higher rate the next sample must not wait for the old one's time.
    next_imu_sample_ = std::min(next_imu_sample_, from + period);
    while (next_imu_sample_ <= now_) {
      send_imu_sample();
      next_imu_sample_ += period;
    }
  } else {
    next_imu_sample_ = now_ + kStep;
  }

  for (; next_fix_ <= now_; next_fix_ += gps_.period())
    line(Device::Gps).send(next_fix_, as_bytes(print_nmea_burst(gps_.measure(after, drive_.speed_mps(), next_fix_))));

  // Serial.println() of the firmware waits for the line: a feedback of some 180 bytes takes 16 ms at 115200 baud, so
  // lines come at about 60 Hz, not at the loop's 100 Hz.
  if (board_.feedback_flows() && now_ - last_feedback_ >= board_.feedback_interval() &&
      line(Device::Base).free_at() <= now_) {
    send_feedback();
  }
}

void WorldModel::send_imu_sample() {
  const Wt901Reading reading = imu_.measure(drive_);
  for (const std::uint8_t type : {0x51, 0x52, 0x53, 0x54, 0x59}) {
    if ((imu_registers_.mask() >> (type - 0x50U) & 1U) != 0) {
      line(Device::Imu).send(next_imu_sample_, print_wt901(type, reading));
    }
  }
}

void WorldModel::send_feedback() {
  constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
  UgvFeedback feedback;
  board_.describe(feedback);
  const double yaw_rad = std::remainder(drive_.pose().yaw_rad, 2.0 * std::numbers::pi);
  feedback.yaw_deg = yaw_rad * kDegreesPerRadian;
  feedback.q0 = std::cos(yaw_rad / 2.0);
  feedback.q3 = std::sin(yaw_rad / 2.0);
  feedback.gz = drive_.yaw_rate_rps() * kDegreesPerRadian;
  const std::string text = print_feedback(feedback);
  line(Device::Base).send(now_, as_bytes(text));
  last_feedback_ = now_;
}

}  // namespace nacelle::simulation
