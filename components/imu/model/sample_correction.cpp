// SPDX-License-Identifier: Apache-2.0
#include "imu/model/sample_correction.hpp"

#include <cmath>

namespace nacelle::imu {
namespace {

Vector3 minus(const Vector3& a, const Vector3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Vector3 times(const Matrix3& m, const Vector3& v) {
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

Orientation times(const Orientation& a, const Orientation& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Orientation from_rpy(const Vector3& rpy) {
  const Orientation roll{std::cos(rpy[0] / 2), std::sin(rpy[0] / 2), 0, 0};
  const Orientation pitch{std::cos(rpy[1] / 2), 0, std::sin(rpy[1] / 2), 0};
  const Orientation yaw{std::cos(rpy[2] / 2), 0, 0, std::sin(rpy[2] / 2)};
  return times(yaw, times(pitch, roll));
}

Matrix3 matrix_of(const Orientation& q) {
  return {1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.w * q.z),     2 * (q.x * q.z + q.w * q.y),
          2 * (q.x * q.y + q.w * q.z),     1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.w * q.x),
          2 * (q.x * q.z - q.w * q.y),     2 * (q.y * q.z + q.w * q.x),     1 - 2 * (q.x * q.x + q.y * q.y)};
}

}  // namespace

SampleCorrector::SampleCorrector(const SampleCorrection& correction)
    : correction_(correction), mounting_(from_rpy(correction.mounting_rpy_rad)), R_FS_(matrix_of(mounting_)) {}

void SampleCorrector::apply(Sample& sample) const {
  const auto& c = correction_;
  sample.angular_velocity_rps = times(R_FS_, minus(sample.angular_velocity_rps, c.gyro_bias_rps));
  sample.acceleration_mps2 =
      times(R_FS_, times(c.acceleration_matrix, minus(sample.acceleration_mps2, c.acceleration_bias_mps2)));
  if (sample.magnetic_field_t) {
    sample.magnetic_field_t = times(R_FS_, times(c.field_matrix, minus(*sample.magnetic_field_t, c.field_bias_t)));
  }
  if (sample.orientation) {
    // R_WF = R_WS R_SF
    sample.orientation = times(*sample.orientation, {mounting_.w, -mounting_.x, -mounting_.y, -mounting_.z});
  }
}

}  // namespace nacelle::imu
