// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <optional>
#include <string>

#include "imu/component/imu_options.hpp"
#include "imu/model/device_reader.hpp"
#include "imu/model/gyro_calibration.hpp"
#include "imu/model/sample_correction.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/arrival_filter.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/node/device_watch.hpp"
#include "sensor_msgs/msg/imu.hpp"
#include "sensor_msgs/msg/magnetic_field.hpp"
#include "sensor_msgs/msg/temperature.hpp"

namespace nacelle::imu {

/// The topics of the component; null for what the device does not measure.
struct ImuPublishers {
  std::shared_ptr<Publisher<sensor_msgs::msg::Imu>> raw, oriented;
  std::shared_ptr<Publisher<sensor_msgs::msg::MagneticField>> field;
  std::shared_ptr<Publisher<sensor_msgs::msg::Temperature>> temperature;
};

/// What the reading thread counted.
struct ImuCounters {
  DeviceReader::Counters device{};
  std::uint64_t published{};
};

/// What the sensor read while it should have been at rest.
struct RestFault {
  CalibrationFault fault = CalibrationFault::TooFewSamples;
  Vector3 mean_rps{};
  double stddev_rps{};
  Vector3 acceleration_mps2{};  ///< The mean.
};

/// From bytes to published samples, on the reading thread.
///
/// Stamps: the device's own clock as far as it has one, laid on this machine's by an ArrivalFilter, which removes the thread's delays.
/// Allocates: nothing once the publishers' messages have their size.
class ImuStream final : public io::ByteSink, private SampleSink {
 public:
  /// The reader outlives this object.
  ImuStream(const ImuOptions& options, DeviceReader& reader, const Clock& clock, ImuPublishers publishers,
            const Logger& logger, DeviceWatch& watch);

  void on_bytes(ByteView bytes, MonotonicTime received) override;
  void on_silence(MonotonicTime now) override;
  void on_break(io::StreamFault fault, MonotonicTime now) override;
  void on_refusal(io::StreamFault fault) override { watch_.lose(std::string(io::explain(fault))); }
  [[nodiscard]] bool hears() const override { return clock_.now() - last_sample_ <= silence_of(period_); }
  void on_return(MonotonicTime now) override;

  // The rest from any thread but the reading one.

  /// Messages leave only while it is set.
  void set_active(bool active) { active_.store(active, std::memory_order_relaxed); }
  /// Waits, by an event, for the first sample.
  [[nodiscard]] bool wait_for_sample(Duration limit);
  /// Blocks until a calibration at rest is complete and returns its result. Motion restarts the calibration, so the first
  /// sufficiently long rest counts. Errors: what the last attempt before the limit measured.
  [[nodiscard]] Result<GyroBias, RestFault> take_calibration(Duration limit);
  /// For an absent device: its later samples are published after a calibration at rest, and its open fault lasts until then.
  void calibrate_later();
  [[nodiscard]] ImuCounters counters() const;

 private:
  void on_sample(const Sample& raw, Duration step) override;
  /// Adds to the calibration. Returns whether samples may be published.
  bool calibrate(const Sample& sample, Vector3& bias_rps);
  void publish(const Sample& sample, const Vector3& bias_rps);
  void publish_field(const Sample& sample, WallTime stamp);
  void publish_temperature(const Sample& sample, WallTime stamp);
  void watch_silence(MonotonicTime now);
  [[nodiscard]] RestFault rest_fault(CalibrationFault fault) const NACELLE_REQUIRES(mutex_);

  const ImuOptions options_;
  const Clock& clock_;
  const Duration period_;
  DeviceReader& reader_;
  const SampleCorrector corrector_;
  ImuPublishers publishers_;
  const Logger& logger_;
  DeviceWatch& watch_;

  io::ArrivalFilter arrival_;
  MonotonicTime received_{};  // of the chunk that is being decoded
  std::optional<MonotonicTime> last_temperature_{};
  MonotonicTime last_sample_;
  std::uint64_t published_ = 0;
  std::atomic<bool> active_{false};

  mutable Mutex mutex_;
  std::condition_variable progress_;
  ImuCounters counters_ NACELLE_GUARDED_BY(mutex_);
  GyroCalibration calibration_ NACELLE_GUARDED_BY(mutex_);
  RestFault last_fault_ NACELLE_GUARDED_BY(mutex_){};
  Vector3 acceleration_sum_ NACELLE_GUARDED_BY(mutex_){};
  Vector3 bias_rps_ NACELLE_GUARDED_BY(mutex_){};
  bool waits_for_calibration_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::imu
