// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_stream.hpp"

#include <fmt/format.h>

#include <utility>

#include "nacelle/io/serial_port.hpp"

namespace nacelle::imu {
namespace {

// Element 0 of a covariance says that the field is not there (sensor_msgs/msg/Imu).
constexpr double kAbsent = -1.0;

void set_diagonal(std::array<double, 9>& covariance, double stddev) {
  covariance = {stddev * stddev, 0.0, 0.0, 0.0, stddev * stddev, 0.0, 0.0, 0.0, stddev * stddev};
}

template <typename XYZ>
void set_vector(XYZ& target, const Vector3& source) {
  target.x = source[0];
  target.y = source[1];
  target.z = source[2];
}

}  // namespace

ImuStream::ImuStream(const ImuOptions& options, const Clock& clock, ImuPublishers publishers, const Logger& logger,
                     DeviceWatch& watch)
    : options_(options),
      clock_(clock),
      byte_time_(io::byte_time(options.baudrate)),
      period_(from_seconds(1.0 / options.rate_hz)),
      publishers_(std::move(publishers)),
      logger_(logger),
      watch_(watch),
      assembler_(kOutputMask, options.magnetic_field_scale),
      last_sample_(clock.now()),
      calibration_(options.calibration_samples, options.calibration_max_stddev, options.calibration_max_bias) {}

void ImuStream::on_bytes(ByteView bytes, MonotonicTime received) {
  decoder_.feed(bytes, [&](const Wt901Frame& frame, std::size_t bytes_after) {
    const auto on_line = static_cast<std::int64_t>(bytes_after + wt901_layout::kFrameBytes);
    if (!assembler_.add(frame, received - byte_time_ * on_line)) return;
    last_sample_ = received;
    on_sample(received);
  });
  {
    const LockGuard lock{mutex_};
    const bool first = counters_.samples.samples == 0 && assembler_.stats().samples > 0;
    counters_ = {decoder_.stats(), assembler_.stats(), published_};
    if (first) progress_.notify_all();
  }
  watch_silence(received);
}

void ImuStream::on_sample(MonotonicTime received) {
  Sample sample = assembler_.sample();
  sample.captured = arrival_.settle(received, received - sample.captured, period_);
  Vector3 bias_rps{};
  if (!calibrate(sample, bias_rps)) return;
  watch_.heard(received);
  if (active_.load(std::memory_order_relaxed)) publish(sample, bias_rps);
}

bool ImuStream::calibrate(const Sample& sample, Vector3& bias_rps) {
  bool moves = false;
  {
    const LockGuard lock{mutex_};
    if (options_.calibrate_gyro && !calibration_.is_full()) {
      calibration_.add(sample.angular_velocity_rps);
      if (const auto result = calibration_.result(); result) {
        if (std::exchange(waits_for_calibration_, false)) bias_rps_ = result->mean_rps;
        progress_.notify_all();
      } else if (calibration_.is_full()) {
        last_fault_ = result.error();
        calibration_.restart();
        moves = waits_for_calibration_;
      }
    }
    bias_rps = bias_rps_;
    if (!waits_for_calibration_) return true;
  }
  if (moves) watch_.lose("it is there, but the gyro cannot be calibrated: the robot moves or turns; keep it still");
  return false;
}

void ImuStream::publish(const Sample& sample, const Vector3& bias_rps) {
  // Both clocks are read here, so that a step of the wall clock cannot come between measuring and stamping.
  const WallTime stamp = clock_.wall_now() - (clock_.now() - sample.captured);
  const auto set_header = [&](auto& header) {
    header.stamp = stamp;
    header.frame_id = options_.frame_id;
  };
  const auto send = [&](Publisher<sensor_msgs::msg::Imu>& publisher, const std::optional<Orientation>& orientation) {
    auto message = publisher.borrow();
    if (!message) return;  // every pooled message is still being read; the publisher counted it
    set_header(message->header);
    const Orientation q = orientation.value_or(Orientation{});
    message->orientation.x = q.x;
    message->orientation.y = q.y;
    message->orientation.z = q.z;
    message->orientation.w = q.w;
    set_diagonal(message->orientation_covariance, options_.orientation_stddev);
    if (!orientation) message->orientation_covariance = {kAbsent};
    set_vector(message->angular_velocity,
               {sample.angular_velocity_rps[0] - bias_rps[0], sample.angular_velocity_rps[1] - bias_rps[1],
                sample.angular_velocity_rps[2] - bias_rps[2]});
    set_diagonal(message->angular_velocity_covariance, options_.angular_velocity_stddev);
    set_vector(message->linear_acceleration, sample.acceleration_mps2);
    set_diagonal(message->linear_acceleration_covariance, options_.linear_acceleration_stddev);
    publisher.publish(std::move(message));
  };
  send(*publishers_.raw, std::nullopt);
  send(*publishers_.oriented, sample.orientation);
  if (sample.magnetic_field_t) {
    if (auto message = publishers_.field->borrow()) {
      set_header(message->header);
      set_vector(message->magnetic_field, *sample.magnetic_field_t);
      set_diagonal(message->magnetic_field_covariance, options_.magnetic_field_stddev);
      publishers_.field->publish(std::move(message));
    }
  }
  ++published_;
}

void ImuStream::watch_silence(MonotonicTime now) {
  watch_.look(now, [this] {
    return fmt::format("{} bytes came so far, {} frames, {} samples", decoder_.stats().bytes, decoder_.stats().frames,
                       assembler_.stats().samples);
  });
}

void ImuStream::on_silence(MonotonicTime now) { watch_silence(now); }

void ImuStream::on_break(io::StreamFault fault, MonotonicTime) {
  watch_.lose(std::string(io::explain(fault)));
  decoder_.restart();
  assembler_.restart();
  arrival_.restart();
}

void ImuStream::on_return(MonotonicTime) { logger_.info("{}: the line is back", options_.port); }

bool ImuStream::wait_for_sample(Duration limit) {
  UniqueLock lock{mutex_};
  return progress_.wait_for(lock.raw(), limit,
                            [this]() NACELLE_REQUIRES(mutex_) { return counters_.samples.samples > 0; });
}

Result<GyroBias, CalibrationFault> ImuStream::take_calibration(Duration limit) {
  UniqueLock lock{mutex_};
  if (!progress_.wait_for(lock.raw(), limit, [this]() NACELLE_REQUIRES(mutex_) { return calibration_.is_full(); }))
    return err(last_fault_);
  const auto result = calibration_.result();
  if (result) bias_rps_ = result->mean_rps;
  return result;
}

void ImuStream::calibrate_later() {
  const LockGuard lock{mutex_};
  const auto result = calibration_.result();
  waits_for_calibration_ = !result;
  if (result) bias_rps_ = result->mean_rps;
}

ImuCounters ImuStream::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::imu
