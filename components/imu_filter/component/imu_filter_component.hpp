// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/magnetic_field.hpp>
#include "imu_filter/model/field_gate.hpp"
#include "imu_filter/model/orientation_filter.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::imu_filter {

/// What became of the readings: received == published + waiting + unusable + out_of_order + unread.
struct ImuFilterStats {
  std::uint64_t received{};
  std::uint64_t published{};
  std::uint64_t waiting{};        ///< Before the first magnetic field, with use_mag.
  std::uint64_t unusable{};       ///< A number that is none, or a covariance that says "not there".
  std::uint64_t out_of_order{};   ///< Not later than the reading before.
  std::uint64_t unread{};         ///< Every pooled message was still being read.
  std::uint64_t gaps{};           ///< Pauses after which the tilt was taken anew; their readings were published.
  std::uint64_t without_field{};  ///< Published without a fresh field, with use_mag.
  std::uint64_t unusable_fields{};
  std::uint64_t gated_fields{};  ///< Of another strength or dip than the reference, with mag_gate_*.
};

/// imu/data_raw and imu/mag in, imu/data with orientation out (node name "imu_filter"; one message per reading, with its stamp).
///
/// Sensor and magnetometer must have the same axes. The first reading, and with use_mag the first field, give the start;
/// while the field is away the gyro carries the heading. The filter's bias is taken off the angular velocity.
/// Parameters have the names of imu_tools. This node broadcasts no transform: the frame of a sensor that is mounted on a robot
/// belongs to the robot's description.
/// Covariance: orientation_stddev squared; without a field the heading's is that of an unknown angle (pi^2 / 3).
/// Threads: the component's executor. Allocates: nothing per reading.
class ImuFilterComponent : public LifecycleNode {
 public:
  [[nodiscard]] const ImuFilterStats& stats() const { return stats_; }

 protected:
  ImuFilterComponent(const NodeOptions& options, bool use_mag);
  /// Makes the filter of the parameters as they are now.
  [[nodiscard]] virtual std::unique_ptr<OrientationFilter> make_filter(const WorldFrame& world) const = 0;

  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  struct Options {
    bool use_mag = true, stateless = false, remove_gravity_vector = false;
    double constant_dt_s = 0.0, orientation_stddev_rad = 0.05, yaw_offset_rad = 0.0;
    WorldFrame world{};
    Eigen::Vector3d mag_bias_t{Eigen::Vector3d::Zero()};
  };
  enum class Step : std::uint8_t { Publish, Waiting, OutOfOrder };

  void on_raw(const sensor_msgs::msg::Imu& raw);
  void on_field(const sensor_msgs::msg::MagneticField& field);
  [[nodiscard]] FieldGateOptions read_field_gate() const;
  /// Whether the field may be used; logs if not.
  [[nodiscard]] bool fits(WallTime stamp, const Eigen::Vector3d& field_t);
  [[nodiscard]] Step advance(WallTime stamp, Measurement& measurement);
  [[nodiscard]] Step start(WallTime stamp, const Measurement& measurement);
  void publish(const sensor_msgs::msg::Imu& raw, bool has_field);

  Options options_;
  std::unique_ptr<OrientationFilter> filter_;
  std::shared_ptr<Publisher<sensor_msgs::msg::Imu>> data_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Imu>> raw_;
  std::shared_ptr<Subscription<sensor_msgs::msg::MagneticField>> field_;
  std::optional<WallTime> last_stamp_;
  std::optional<WallTime> waiting_since_;
  std::optional<Eigen::Vector3d> last_field_t_;
  std::optional<FieldGate> field_gate_;
  std::optional<Eigen::Vector3d> up_S_;  // before the filter has started, by the accelerometer
  WallTime last_field_stamp_{};
  ImuFilterStats stats_;
};

/// Madgwick's filter, with the parameters of imu_filter_madgwick.
class MadgwickFilterComponent final : public ImuFilterComponent {
 public:
  explicit MadgwickFilterComponent(const NodeOptions& options);

 private:
  [[nodiscard]] std::unique_ptr<OrientationFilter> make_filter(const WorldFrame& world) const override;
};

/// The complementary filter, with the parameters of imu_complementary_filter.
class ComplementaryFilterComponent final : public ImuFilterComponent {
 public:
  explicit ComplementaryFilterComponent(const NodeOptions& options);

 private:
  [[nodiscard]] std::unique_ptr<OrientationFilter> make_filter(const WorldFrame& world) const override;
};

}  // namespace nacelle::imu_filter
