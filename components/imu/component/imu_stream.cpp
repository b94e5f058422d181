// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace nacelle::imu {
namespace {

// Element 0 of a covariance says that the field is not there (sensor_msgs/msg/Imu).
constexpr double kAbsent = -1.0;

// What a die does in a second is small; its thermometer is good to some degrees at most.
constexpr Duration kTemperaturePeriod = 1s;
constexpr double kTemperatureVariance = 9.0;

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

ImuStream::ImuStream(const ImuOptions& options, DeviceReader& reader, const Clock& clock, ImuPublishers publishers,
                     const Logger& logger, DeviceWatch& watch)
    : options_(options),
      clock_(clock),
      period_(from_seconds(1.0 / options.rate_hz)),
      reader_(reader),
      corrector_(options.correction),
      publishers_(std::move(publishers)),
      logger_(logger),
      watch_(watch),
      last_sample_(clock.now()),
      calibration_(options.calibration_samples, options.calibration_max_stddev, options.calibration_max_bias) {}

void ImuStream::on_bytes(ByteView bytes, MonotonicTime received) {
  received_ = received;
  reader_.feed(bytes, received, *this);
  {
    const LockGuard lock{mutex_};
    const auto counters = reader_.counters();
    const bool first = counters_.device.samples == 0 && counters.samples > 0;
    counters_ = {counters, published_};
    if (first) progress_.notify_all();
  }
  watch_silence(received);
}

void ImuStream::on_sample(const Sample& raw, Duration step) {
  last_sample_ = received_;
  Sample sample = raw;
  sample.captured = arrival_.settle(received_, received_ - raw.captured, step);
  corrector_.apply(sample);
  Vector3 bias_rps{};
  if (!calibrate(sample, bias_rps)) return;
  watch_.heard(received_);
  if (active_.load(std::memory_order_relaxed)) publish(sample, bias_rps);
}

RestFault ImuStream::rest_fault(CalibrationFault fault) const {
  RestFault rest{fault, calibration_.mean_rps(), calibration_.stddev_rps(), acceleration_sum_};
  for (double& axis : rest.acceleration_mps2) axis /= std::max(1.0, static_cast<double>(calibration_.count()));
  return rest;
}

bool ImuStream::calibrate(const Sample& sample, Vector3& bias_rps) {
  bool moves = false;
  {
    const LockGuard lock{mutex_};
    if (options_.calibrate_gyro && !calibration_.is_full()) {
      calibration_.add(sample.angular_velocity_rps);
      for (std::size_t i = 0; i < 3; ++i) acceleration_sum_[i] += sample.acceleration_mps2[i];
      if (const auto result = calibration_.result(); result) {
        if (std::exchange(waits_for_calibration_, false)) bias_rps_ = result->mean_rps;
        progress_.notify_all();
      } else if (calibration_.is_full()) {
        last_fault_ = rest_fault(result.error());
        calibration_.restart();
        acceleration_sum_ = {};
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
    if (!sample.has_angular_velocity) message->angular_velocity_covariance = {kAbsent};
    set_vector(message->linear_acceleration, sample.acceleration_mps2);
    set_diagonal(message->linear_acceleration_covariance, options_.linear_acceleration_stddev);
    publisher.publish(std::move(message));
  };
  // The field first: a filter that gets the reading has the field of the same time then.
  publish_field(sample, stamp);
  send(*publishers_.raw, std::nullopt);
  if (publishers_.oriented) send(*publishers_.oriented, sample.orientation);
  publish_temperature(sample, stamp);
  ++published_;
}

void ImuStream::publish_field(const Sample& sample, WallTime stamp) {
  if (!sample.magnetic_field_t || !publishers_.field) return;
  auto message = publishers_.field->borrow();
  if (!message) return;
  message->header.stamp = stamp;
  message->header.frame_id = options_.frame_id;
  set_vector(message->magnetic_field, *sample.magnetic_field_t);
  set_diagonal(message->magnetic_field_covariance, options_.magnetic_field_stddev);
  publishers_.field->publish(std::move(message));
}

void ImuStream::publish_temperature(const Sample& sample, WallTime stamp) {
  if (!sample.temperature_c || !publishers_.temperature) return;
  if (last_temperature_ && sample.captured - *last_temperature_ < kTemperaturePeriod) return;
  auto message = publishers_.temperature->borrow();
  if (!message) return;
  last_temperature_ = sample.captured;
  message->header.stamp = stamp;
  message->header.frame_id = options_.frame_id;
  message->temperature = *sample.temperature_c;
  message->variance = kTemperatureVariance;
  publishers_.temperature->publish(std::move(message));
}

void ImuStream::watch_silence(MonotonicTime now) {
  watch_.look(now, [this] {
    const auto counters = reader_.counters();
    return fmt::format("{} bytes came so far, {} frames, {} samples", counters.bytes, counters.frames,
                       counters.samples);
  });
}

void ImuStream::on_silence(MonotonicTime now) { watch_silence(now); }

void ImuStream::on_break(io::StreamFault fault, MonotonicTime) {
  watch_.lose(std::string(io::explain(fault)));
  reader_.restart();
  arrival_.restart();
}

void ImuStream::on_return(MonotonicTime) { logger_.info("{}: the line is back", options_.port); }

bool ImuStream::wait_for_sample(Duration limit) {
  UniqueLock lock{mutex_};
  return progress_.wait_for(lock.raw(), limit,
                            [this]() NACELLE_REQUIRES(mutex_) { return counters_.device.samples > 0; });
}

Result<GyroBias, RestFault> ImuStream::take_calibration(Duration limit) {
  UniqueLock lock{mutex_};
  if (!progress_.wait_for(lock.raw(), limit, [this]() NACELLE_REQUIRES(mutex_) { return calibration_.is_full(); }))
    return err(last_fault_.fault == CalibrationFault::TooFewSamples ? rest_fault(CalibrationFault::TooFewSamples)
                                                                    : last_fault_);
  const auto result = calibration_.result();
  if (!result) return err(rest_fault(result.error()));
  bias_rps_ = result->mean_rps;
  return *result;
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
