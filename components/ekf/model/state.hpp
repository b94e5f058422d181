// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace nacelle::ekf {

/// Where a quantity stands in the state. Source: robot_localization, include/robot_localization/filter_common.hpp.
///
/// Frame: position and roll, pitch, yaw are X_WB (base in world, fixed axes); the other three groups are along the axes of B.
enum StateIndex : std::uint8_t {
  kX,
  kY,
  kZ,
  kRoll,
  kPitch,
  kYaw,
  kVx,
  kVy,
  kVz,
  kVroll,
  kVpitch,
  kVyaw,
  kAx,
  kAy,
  kAz
};
inline constexpr int kStates = 15;
inline constexpr std::array<std::string_view, kStates> kStateNames{
    "x", "y", "z", "roll", "pitch", "yaw", "vx", "vy", "vz", "vroll", "vpitch", "vyaw", "ax", "ay", "az"};

using StateVector = Eigen::Matrix<double, kStates, 1>;
using StateMatrix = Eigen::Matrix<double, kStates, kStates>;

/// The quantities that a sensor measures, bit i for StateIndex i: the 15 booleans of a `_config` parameter.
using StateMask = std::uint16_t;
[[nodiscard]] constexpr StateMask mask_of(StateIndex i) { return static_cast<StateMask>(1U << i); }
[[nodiscard]] constexpr bool has(StateMask mask, int i) { return ((static_cast<unsigned>(mask) >> i) & 1U) != 0; }

inline constexpr StateMask kPoseMask = 0x003F;
inline constexpr StateMask kTwistMask = 0x0FC0;
inline constexpr StateMask kAccelerationMask = 0x7000;

/// A symmetric 15x15 matrix whose rows are padded to 16, so that a row is eight aligned pairs.
/// Threads: a value. Allocates: nothing.
class StateCovariance {
 public:
  static constexpr int kStride = 16;

  StateCovariance() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a StateMatrix says the same thing
  StateCovariance(const StateMatrix& matrix) {
    for (int i = 0; i < kStates; ++i) {
      for (int j = 0; j < kStates; ++j) row(i)[j] = matrix(i, j);
    }
  }
  [[nodiscard]] StateMatrix matrix() const {
    StateMatrix dense;
    for (int i = 0; i < kStates; ++i) {
      for (int j = 0; j < kStates; ++j) dense(i, j) = row(i)[j];
    }
    return dense;
  }
  [[nodiscard]] double operator()(int i, int j) const { return row(i)[j]; }
  [[nodiscard]] double& operator()(int i, int j) { return row(i)[j]; }
  [[nodiscard]] const double* row(int i) const { return values_.data() + std::ptrdiff_t{i} * kStride; }
  [[nodiscard]] double* row(int i) { return values_.data() + std::ptrdiff_t{i} * kStride; }

 private:
  alignas(16) std::array<double, static_cast<std::size_t>(kStates) * kStride> values_{};
};

/// What the filter believes: a mean and how sure it is. Units: SI. The covariance is symmetric and positive definite.
struct Belief {
  StateVector mean = StateVector::Zero();
  StateCovariance covariance;
};

}  // namespace nacelle::ekf
