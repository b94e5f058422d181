// SPDX-License-Identifier: Apache-2.0
#include "gps/protocol/nmea_sentence.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace nacelle::gps {
namespace {

constexpr double kMpsPerKnot = 1852.0 / 3600.0;
constexpr double kMpsPerKmh = 1.0 / 3.6;

/// Takes one field after the other. A field that cannot be sets the mark `bad`; an empty one, or one behind the end, is no value.
class Fields {
 public:
  explicit Fields(std::string_view text) : rest_(text) {}

  [[nodiscard]] bool bad() const { return bad_; }

  std::string_view text() {
    const std::size_t comma = std::min(rest_.find(','), rest_.size());
    const std::string_view field = rest_.substr(0, comma);
    rest_.remove_prefix(std::min(comma + 1, rest_.size()));
    return field;
  }
  void skip(int count) {
    for (int i = 0; i < count; ++i) text();
  }
  std::optional<double> number() {
    const std::string_view field = text();
    if (field.empty()) return std::nullopt;
    double value = 0.0;
    const auto read = std::from_chars(field.data(), field.data() + field.size(), value, std::chars_format::fixed);
    if (read.ec != std::errc{} || read.ptr != field.data() + field.size() || !std::isfinite(value)) return fail();
    return value;
  }
  std::optional<double> within(double lowest, double highest) {
    const auto value = number();
    if (value && (*value < lowest || *value > highest)) return fail();
    return value;
  }
  /// One of these characters; 0 for an empty field.
  char letter(std::string_view allowed) {
    const std::string_view field = text();
    if (field.empty()) return 0;
    if (field.size() == 1 && allowed.find(field[0]) != std::string_view::npos) return field[0];
    fail();
    return 0;
  }
  std::uint8_t digit() {
    const char found = letter("0123456789");
    return found == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(found - '0');
  }
  /// hhmmss.sss
  std::optional<Duration> time_of_day() {
    const auto value = within(0.0, 235960.999999);
    if (!value) return std::nullopt;
    const auto whole = static_cast<int>(*value);
    const int hours = whole / 10000, minutes = whole / 100 % 100, seconds = whole % 100;
    if (minutes > 59 || seconds > 60) return bad_ = true, std::nullopt;
    return std::chrono::hours{hours} + std::chrono::minutes{minutes} + std::chrono::seconds{seconds} +
           from_seconds(std::round((*value - whole) * 1e6) / 1e6);
  }
  /// ddmm.mmmm,N,dddmm.mmmm,E
  std::optional<GeoPosition> position() {
    const auto latitude = angle(90.0, "NS", 'S'), longitude = angle(180.0, "EW", 'W');
    if (!latitude || !longitude) return std::nullopt;
    return GeoPosition{*latitude, *longitude};
  }
  /// ddmmyy; receivers that count years in two digits are younger than 1980
  std::optional<CalendarDate> date() {
    const std::string_view field = text();
    if (field.empty()) return std::nullopt;
    int value = 0;
    const auto read = std::from_chars(field.data(), field.data() + field.size(), value);
    const CalendarDate date{value % 100 + (value % 100 < 80 ? 2000 : 1900), value / 100 % 100, value / 10000};
    const std::chrono::year_month_day day{std::chrono::year{date.year},
                                          std::chrono::month{static_cast<unsigned>(date.month)},
                                          std::chrono::day{static_cast<unsigned>(date.day)}};
    if (read.ptr != field.data() + field.size() || field.size() != 6 || value < 0 || !day.ok()) {
      bad_ = true;
      return std::nullopt;
    }
    return date;
  }

 private:
  std::nullopt_t fail() {
    bad_ = true;
    return std::nullopt;
  }
  std::optional<double> angle(double limit_deg, std::string_view letters, char negative) {
    const auto value = within(0.0, limit_deg * 100.0);
    const char side = letter(letters);
    if (!value || side == 0) return std::nullopt;
    const double degrees = std::floor(*value / 100.0);
    const double minutes = *value - degrees * 100.0;
    if (minutes >= 60.0) return fail();
    const double angle_deg = degrees + minutes / 60.0;
    return side == negative ? -angle_deg : angle_deg;
  }

  std::string_view rest_;
  bool bad_ = false;
};

Gga read_gga(Fields& fields) {
  Gga gga;
  gga.utc = fields.time_of_day();
  gga.position = fields.position();
  gga.quality = fields.digit();
  fields.skip(1);
  gga.hdop = fields.within(0.0, 1e3);
  gga.above_geoid_m = fields.within(-1e5, 1e8);
  fields.letter("M");
  gga.geoid_m = fields.within(-1e3, 1e3);
  fields.letter("M");
  return gga;
}

Rmc read_rmc(Fields& fields) {
  Rmc rmc;
  rmc.utc = fields.time_of_day();
  rmc.valid = fields.letter("AV") == 'A';
  rmc.position = fields.position();
  if (const auto knots = fields.within(0.0, 1e5)) rmc.speed_mps = *knots * kMpsPerKnot;
  rmc.course_deg = fields.within(-360.0, 360.0);
  rmc.date = fields.date();
  return rmc;
}

Gsa read_gsa(Fields& fields) {
  Gsa gsa;
  fields.letter("MA");
  gsa.fix = fields.digit();
  fields.skip(12);
  gsa.pdop = fields.within(0.0, 1e3);
  gsa.hdop = fields.within(0.0, 1e3);
  gsa.vdop = fields.within(0.0, 1e3);
  return gsa;
}

Gst read_gst(Fields& fields) {
  Gst gst;
  gst.utc = fields.time_of_day();
  fields.skip(4);
  gst.latitude_stddev_m = fields.within(0.0, 1e8);
  gst.longitude_stddev_m = fields.within(0.0, 1e8);
  gst.altitude_stddev_m = fields.within(0.0, 1e8);
  return gst;
}

Vtg read_vtg(Fields& fields) {
  Vtg vtg;
  vtg.course_deg = fields.within(-360.0, 360.0);
  fields.skip(3);
  if (const auto knots = fields.within(0.0, 1e5)) vtg.speed_mps = *knots * kMpsPerKnot;
  fields.skip(1);
  if (const auto kmh = fields.within(0.0, 1e5); kmh && !vtg.speed_mps) vtg.speed_mps = *kmh * kMpsPerKmh;
  return vtg;
}

template <typename Message>
NmeaMessage judged(const Message& message, const Fields& fields) {
  if (fields.bad()) return MalformedSentence{};
  return message;
}

}  // namespace

std::string_view talker_of(std::string_view text) { return text.substr(0, 2); }

NmeaMessage read_nmea(std::string_view text) {
  Fields fields{text};
  const std::string_view address = fields.text();
  // $PGRMC is Garmin's own, not an RMC.
  if (address.size() != 5 || address[0] == 'P') return OtherSentence{};
  const std::string_view kind = address.substr(2);
  if (kind == "GGA") return judged(read_gga(fields), fields);
  if (kind == "RMC") return judged(read_rmc(fields), fields);
  if (kind == "GSA") return judged(read_gsa(fields), fields);
  if (kind == "GST") return judged(read_gst(fields), fields);
  if (kind == "VTG") return judged(read_vtg(fields), fields);
  return OtherSentence{};
}

}  // namespace nacelle::gps
