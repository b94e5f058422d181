// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::imu_filter {

/// The magnetic field at one place: how strong it is, and how far it points below the horizon.
struct FieldShape {
  double strength_t{}, dip_rad{};
};

struct FieldGateOptions {
  double strength_tolerance_t = 0.0;      ///< 0: the strength is not looked at.
  double dip_tolerance_rad = 0.0;         ///< 0: the dip is not looked at.
  std::optional<FieldShape> reference{};  ///< Nothing: learnt from the fields of the first second.
  Duration patience = 10s;  ///< A field that is refused for so long and stays the same becomes a reference, too.
  [[nodiscard]] bool any() const { return strength_tolerance_t > 0.0 || dip_tolerance_rad > 0.0; }
};

/// Refuses magnetic fields whose strength or dip is not the earth's: iron and currents are near, and the heading would bend.
///
/// A reference that is wrong must not silence the sensor for ever. If nothing fits for FieldGateOptions::patience while what is
/// refused stays the same, it is accepted from then on, beside the reference.
/// Threads: one. Allocates: nothing.
class FieldGate {
 public:
  enum class Verdict : std::uint8_t { Fits, WrongStrength, WrongDip };

  explicit FieldGate(const FieldGateOptions& options) : options_(options), reference_(options.reference) {}

  /// `up_S`: upwards in the axes of the sensor, length 1; nothing: not known yet, the dip is not looked at.
  [[nodiscard]] Verdict judge(WallTime stamp, const Eigen::Vector3d& field_S_t,
                              const std::optional<Eigen::Vector3d>& up_S);

  /// Of the last field.
  [[nodiscard]] const FieldShape& last() const { return last_; }
  /// Nothing while it is learnt.
  [[nodiscard]] const std::optional<FieldShape>& reference() const { return reference_; }
  /// What the reference did not allow but stayed the same.
  [[nodiscard]] const std::optional<FieldShape>& second() const { return second_; }
  [[nodiscard]] std::uint64_t adoptions() const { return adoptions_; }

 private:
  struct Mean {
    FieldShape shape;
    std::uint64_t count{}, dips{};
    WallTime since{};
    void add(WallTime stamp, const FieldShape& seen, bool has_dip);
  };
  [[nodiscard]] Verdict compare(const FieldShape& seen, bool has_dip, const FieldShape& with) const;
  void learn(WallTime stamp, bool has_dip);

  FieldGateOptions options_;
  std::optional<FieldShape> reference_, second_;
  FieldShape last_;
  Mean learning_, refused_;
  WallTime last_refused_{};
  std::uint64_t adoptions_{};
};

}  // namespace nacelle::imu_filter
