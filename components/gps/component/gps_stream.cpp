// SPDX-License-Identifier: Apache-2.0
#include "gps/component/gps_stream.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

namespace nacelle::gps {
namespace {

using sensor_msgs::msg::NavSatFix;
using sensor_msgs::msg::NavSatStatus;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Without a course, a receiver stands still. Faster than this it would have one.
constexpr double kStandsStill_mps = 0.5;
constexpr Duration kDay = 24h;
// A longer step between two bursts says nothing about when the second one came.
constexpr Duration kLongestStep = 10s;

std::int8_t status_of(std::uint8_t quality) {
  switch (quality) {
    case 1: return NavSatStatus::STATUS_FIX;
    case 2:
    case 9: return NavSatStatus::STATUS_SBAS_FIX;
    case 4:
    case 5: return NavSatStatus::STATUS_GBAS_FIX;
    default: return NavSatStatus::STATUS_NO_FIX;  // also for what is dead reckoned, set by hand or simulated
  }
}

std::uint16_t service_of(std::string_view talker) {
  if (talker == "GL") return NavSatStatus::SERVICE_GLONASS;
  if (talker == "GA") return NavSatStatus::SERVICE_GALILEO;
  if (talker == "GB" || talker == "BD") return NavSatStatus::SERVICE_COMPASS;
  return NavSatStatus::SERVICE_GPS;  // GN names no system; in practice GPS is among them
}

std::uint8_t type_of(ErrorModel::Source source) {
  switch (source) {
    case ErrorModel::Source::Receiver: return NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
    case ErrorModel::Source::Dilution: return NavSatFix::COVARIANCE_TYPE_APPROXIMATED;
    case ErrorModel::Source::None: break;
  }
  return NavSatFix::COVARIANCE_TYPE_UNKNOWN;
}

}  // namespace

GpsStream::GpsStream(const GpsOptions& options, const Clock& clock, GpsPublishers publishers, const Logger& logger,
                     DeviceWatch& watch)
    : options_(options),
      clock_(clock),
      publishers_(std::move(publishers)),
      logger_(logger),
      watch_(watch),
      errors_(options.errors_m) {}

void GpsStream::on_bytes(ByteView bytes, MonotonicTime received) {
  framer_.feed(bytes, received, [&](const NmeaSentence& sentence) {
    on_sentence(sentence);
    watch_.heard(received);
  });
  {
    const LockGuard lock{mutex_};
    const bool first = counters_.line.sentences == 0 && framer_.stats().sentences > 0;
    counters_ = {framer_.stats(), used_, other_, malformed_, published_};
    if (first) sentence_came_.notify_all();
  }
  watch_silence(received);
}

void GpsStream::on_sentence(const NmeaSentence& sentence) {
  const MonotonicTime started = sentence.started;
  ++used_;
  std::visit(
      [&](const auto& message) {
        using Message = std::decay_t<decltype(message)>;
        if constexpr (std::is_same_v<Message, OtherSentence>) {
          --used_;
          ++other_;
        } else if constexpr (std::is_same_v<Message, MalformedSentence>) {
          --used_;
          ++malformed_;
        } else if constexpr (std::is_same_v<Message, Gsa>) {
          errors_.add(message, started);
        } else if constexpr (std::is_same_v<Message, Gst>) {
          if (message.utc) moment_of(*message.utc, started);
          errors_.add(message, started);
        } else if constexpr (std::is_same_v<Message, Gga>) {
          publish_fix(message, talker_of(sentence.text), message.utc ? moment_of(*message.utc, started) : started);
        } else if constexpr (std::is_same_v<Message, Rmc>) {
          const MonotonicTime moment = message.utc ? moment_of(*message.utc, started) : started;
          publish_time(message, moment);
          hears_rmc_ = message.valid;
          if (message.valid) publish_velocity(message.speed_mps, message.course_deg, moment);
        } else if constexpr (std::is_same_v<Message, Vtg>) {
          if (has_fix_ && !hears_rmc_)
            publish_velocity(message.speed_mps, message.course_deg, utc_ ? moment_ : started);
        }
      },
      read_nmea(sentence.text));
}

MonotonicTime GpsStream::moment_of(Duration utc, MonotonicTime started) {
  if (utc_ == utc) return moment_;
  Duration step = utc_ ? (utc - *utc_ + kDay) % kDay : Duration{};
  if (step > kLongestStep) step = {};
  if (step > Duration{}) watch_.expect_every(step);
  utc_ = utc;
  moment_ = arrival_.settle(started, Duration{}, step);
  return moment_;
}

WallTime GpsStream::stamp_of(MonotonicTime moment) const {
  // Both clocks are read here, so that a step of the wall clock cannot come between measuring and stamping.
  return clock_.wall_now() - (clock_.now() - moment);
}

void GpsStream::publish_fix(const Gga& gga, std::string_view talker, MonotonicTime moment) {
  const std::int8_t status = status_of(gga.quality);
  const bool has_fix = status != NavSatStatus::STATUS_NO_FIX && gga.position;
  if (std::exchange(has_fix_, has_fix) != has_fix)
    logger_.info("{}: {}", options_.port, has_fix ? "the receiver has a fix" : "the receiver has no fix");
  if (!is_active()) return;
  auto message = publishers_.fix->borrow();
  if (!message) return;  // every pooled message is still being read; the publisher counted it
  message->header.stamp = stamp_of(moment);
  message->header.frame_id = options_.frame_id;
  message->status.status = has_fix ? status : std::int8_t{NavSatStatus::STATUS_NO_FIX};
  message->status.service = service_of(talker);
  const bool has_altitude = has_fix && gga.above_geoid_m && gga.geoid_m;
  message->latitude = has_fix ? gga.position->latitude_deg : kNaN;
  message->longitude = has_fix ? gga.position->longitude_deg : kNaN;
  message->altitude = has_altitude ? *gga.above_geoid_m + *gga.geoid_m : kNaN;
  const auto variances = has_fix ? errors_.of(gga, moment) : ErrorModel::Variances{};
  message->position_covariance = {};
  message->position_covariance[0] = variances.east_m2;
  message->position_covariance[4] = variances.north_m2;
  message->position_covariance[8] = variances.up_m2;
  message->position_covariance_type = type_of(variances.source);
  publishers_.fix->publish(std::move(message));
  ++published_;
}

void GpsStream::publish_velocity(std::optional<double> speed_mps, std::optional<double> course_deg,
                                 MonotonicTime moment) {
  if (!is_active() || !speed_mps || (!course_deg && *speed_mps > kStandsStill_mps)) return;
  auto message = publishers_.velocity->borrow();
  if (!message) return;
  const double course_rad = course_deg.value_or(0.0) * std::numbers::pi / 180.0;
  const double known_mps = course_deg ? *speed_mps : 0.0;
  message->header.stamp = stamp_of(moment);
  message->header.frame_id = options_.frame_id;
  message->twist = {};
  message->twist.linear.x = known_mps * std::sin(course_rad);
  message->twist.linear.y = known_mps * std::cos(course_rad);
  publishers_.velocity->publish(std::move(message));
}

void GpsStream::publish_time(const Rmc& rmc, MonotonicTime moment) {
  if (!is_active() || !rmc.valid || !rmc.utc || !rmc.date) return;
  auto message = publishers_.time->borrow();
  if (!message) return;
  const std::chrono::sys_days day{std::chrono::year{rmc.date->year} / rmc.date->month / rmc.date->day};
  message->header.stamp = stamp_of(moment);
  message->header.frame_id = options_.frame_id;
  message->time_ref = WallTime{day.time_since_epoch() + *rmc.utc};
  message->source = options_.time_ref_source;
  publishers_.time->publish(std::move(message));
}

void GpsStream::watch_silence(MonotonicTime now) {
  watch_.look(now, [this] {
    const auto& line = framer_.stats();
    return fmt::format("{} bytes came so far, {} sentences, {} bad checksums", line.bytes, line.sentences,
                       line.bad_checksums);
  });
}

void GpsStream::on_break(io::StreamFault fault, MonotonicTime) {
  watch_.lose(std::string(io::explain(fault)));
  framer_.restart();
  errors_.restart();
  arrival_.restart();
  utc_.reset();
  hears_rmc_ = false;
}

void GpsStream::on_return(MonotonicTime) { logger_.info("{}: the line is back", options_.port); }

bool GpsStream::wait_for_sentence(Duration limit) {
  UniqueLock lock{mutex_};
  return sentence_came_.wait_for(lock.raw(), limit,
                                 [this]() NACELLE_REQUIRES(mutex_) { return counters_.line.sentences > 0; });
}

GpsCounters GpsStream::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::gps
