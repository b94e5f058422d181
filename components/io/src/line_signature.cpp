// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/line_signature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace nacelle::io {
namespace {

constexpr std::size_t kNone = 0;
/// No frame is longer, so that noise is not waited for.
constexpr std::size_t kLongestFrame = 256;

bool begins_with(ByteView bytes, std::initializer_list<int> start) {
  if (bytes.size() < start.size()) return false;
  return std::equal(start.begin(), start.end(), bytes.begin());
}
std::uint8_t sum_of(ByteView bytes) {
  return static_cast<std::uint8_t>(std::accumulate(bytes.begin(), bytes.end(), 0U));
}
std::uint16_t word_at(ByteView bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8U);
}

// 54 2C, 12 points, CRC-8 with the polynomial 4D. Source: LDROBOT, ldlidar_stl_ros2, lipkg.cpp.
std::size_t ldrobot_frame(ByteView bytes) {
  constexpr std::size_t kLength = 47;
  if (!begins_with(bytes, {0x54, 0x2C})) return kNone;
  if (bytes.size() < kLength) return kLength;
  unsigned crc = 0;
  for (std::size_t i = 0; i + 1 < kLength; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1U ^ ((crc & 0x80U) != 0 ? 0x4DU : 0U)) & 0xFFU;
  }
  return crc == bytes[kLength - 1] ? kLength : kNone;
}

// 55, 50 to 5F, 8 bytes, their sum. Source: WitMotion's protocol page.
std::size_t wit_frame(ByteView bytes) {
  constexpr std::size_t kLength = 11;
  if (!begins_with(bytes, {0x55}) || (bytes.size() > 1 && (bytes[1] & 0xF0U) != 0x50)) return kNone;
  if (bytes.size() < kLength) return kLength;
  return sum_of(bytes.first(kLength - 1)) == bytes[kLength - 1] ? kLength : kNone;
}

// AA AA, 16 bytes, their sum. Source: BNO080 data sheet, 1.3.5.2 "UART-RVC".
std::size_t rvc_frame(ByteView bytes) {
  constexpr std::size_t kLength = 19;
  if (!begins_with(bytes, {0xAA, 0xAA})) return kNone;
  if (bytes.size() < kLength) return kLength;
  return sum_of(bytes.subspan(2, 16)) == bytes[kLength - 1] ? kLength : kNone;
}

// AA 55, type, count, two angles, XOR of words, samples of 2 bytes. Source: YDLidar-SDK, Communication-Protocol.md.
std::size_t ydlidar_frame(ByteView bytes) {
  constexpr std::size_t kHead = 10;
  if (!begins_with(bytes, {0xAA, 0x55})) return kNone;
  if (bytes.size() < kHead) return kHead;
  const std::size_t length = kHead + 2U * bytes[3];
  if (length > kLongestFrame || bytes[3] == 0) return kNone;
  if (bytes.size() < length) return length;
  unsigned check = 0;
  for (std::size_t at = 0; at < length; at += 2) check ^= at == 8 ? 0U : word_at(bytes, at);
  return check == word_at(bytes, 8) ? length : kNone;
}

// AA 55, function, length, data, CRC-8/MAXIM. Source: Hiwonder, ros_robot_controller_sdk.
std::size_t hiwonder_frame(ByteView bytes) {
  if (!begins_with(bytes, {0xAA, 0x55})) return kNone;
  if (bytes.size() < 4) return 5;
  const std::size_t length = 5U + bytes[3];
  if (bytes[2] > 11 || length > kLongestFrame) return kNone;
  if (bytes.size() < length) return length;
  unsigned crc = 0;
  for (std::size_t i = 2; i + 1 < length; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ ((crc & 1U) != 0 ? 0x8CU : 0U);
  }
  return crc == bytes[length - 1] ? length : kNone;
}

/// A line of text that begins so; its length with the line feed.
std::size_t text_line(ByteView bytes, std::string_view beginning) {
  const std::size_t known = std::min(bytes.size(), beginning.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known), beginning.begin())) return kNone;
  const auto end = std::find(bytes.begin(), bytes.end(), '\n');
  if (end != bytes.end()) return static_cast<std::size_t>(end - bytes.begin()) + 1;
  return bytes.size() < kLongestFrame ? bytes.size() + 1 : kNone;
}

// {"T":1001,...}: an object a line. Source: Waveshare, ugv_base_ros, json_cmd.h.
std::size_t waveshare_line(ByteView bytes) { return text_line(bytes, "{\"T\":"); }

// $GPRMC,...*hh: XOR of what is between. Source: NMEA 0183.
std::size_t nmea_line(ByteView bytes) {
  const std::size_t length = text_line(bytes, "$G");
  if (length == kNone || length > bytes.size()) return length;
  const auto star = std::find(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length), '*');
  const auto at = static_cast<std::size_t>(star - bytes.begin());
  if (at + 2 >= length) return kNone;
  const unsigned check = std::accumulate(bytes.begin() + 1, star, 0U, [](unsigned a, std::uint8_t b) { return a ^ b; });
  return fmt::format("{:02X}", check) == std::string(star + 1, star + 3) ? length : kNone;
}

constexpr std::array kDevices{
    SerialDevice{"LD06, LD19 or STL LiDAR", 230400, "nacelle::lidar::LidarComponent", "port_name", "", ldrobot_frame},
    SerialDevice{"WT901 IMU", 9600, "nacelle::imu::ImuComponent", "port", "", wit_frame},
    SerialDevice{"BNO08x IMU (UART-RVC)", 115200, "nacelle::imu::ImuComponent", "port",
                 "{name: model, value: bno08x_rvc}", rvc_frame},
    SerialDevice{"YDLIDAR", 115200, "nacelle::lidar::LidarComponent", "port_name", "{name: model, value: ydlidar_x2}",
                 ydlidar_frame},
    SerialDevice{"Hiwonder RRC motor board", 1000000, "", "", "", hiwonder_frame},
    SerialDevice{"Waveshare motor board", 115200, "nacelle::diff_drive::DiffDriveComponent", "serial_port", "",
                 waveshare_line},
    SerialDevice{"GPS receiver (NMEA 0183)", 9600, "nacelle::gps::GpsComponent", "port", "", nmea_line},
};

bool has_two_frames(const SerialDevice& device, ByteView bytes) {
  for (; !bytes.empty(); bytes = bytes.subspan(1)) {
    const std::size_t first = device.frame_at(bytes);
    if (first == kNone || first >= bytes.size()) continue;
    const std::size_t second = device.frame_at(bytes.subspan(first));
    if (second != kNone && first + second <= bytes.size()) return true;
  }
  return false;
}

}  // namespace

std::span<const SerialDevice> known_serial_devices() { return kDevices; }

const SerialDevice* recognise(ByteView bytes) {
  const auto* const found = std::find_if(kDevices.begin(), kDevices.end(),
                                         [&](const SerialDevice& device) { return has_two_frames(device, bytes); });
  return found == kDevices.end() ? nullptr : found;
}

void FirstBytes::add(ByteView bytes) {
  const std::size_t count = std::min(bytes.size(), bytes_.size() - count_);
  std::copy_n(bytes.begin(), count, bytes_.begin() + static_cast<std::ptrdiff_t>(count_));
  count_ += count;
}

Problem why_no_frames(const ExpectedDevice& expected, const HeardOnLine& heard, Duration waited) {
  const double seconds = to_seconds(waited);
  if (heard.bytes == 0) return {expected.path, fmt::format("nothing came in {:.1f} s", seconds), expected.when_silent};
  Problem problem{expected.path,
                  fmt::format("{} bytes came in {:.1f} s, but no {} frame", heard.bytes, seconds, expected.name), ""};
  // First: by chance, bytes of another device look like frames with a bad checksum.
  if (const SerialDevice* const other = recognise(heard.first.view()); other != nullptr) {
    problem.what += fmt::format(": they come from a {}", other->name);
    problem.way_out =
        fmt::format("is the {} on another line? nacelle device list shows what is plugged in", expected.name);
  } else if (heard.bad_checksums > 0) {
    problem.what = fmt::format("{} bytes came in {:.1f} s; all {} frames had a bad checksum", heard.bytes, seconds,
                               heard.bad_checksums);
    problem.way_out = "the line is disturbed: look at the cable, the ground wire and what runs beside it";
  } else if (!expected.otherwise.empty()) {
    problem.way_out = expected.otherwise;
  } else if (expected.baud != expected.usual_baud) {
    problem.way_out = fmt::format("{} is {}, the {} leaves the factory with {}", expected.baud_parameter, expected.baud,
                                  expected.name, expected.usual_baud);
  } else {
    problem.way_out = fmt::format("is it another device, or was its baud rate changed? {} is {}",
                                  expected.baud_parameter, expected.baud);
  }
  return problem;
}

}  // namespace nacelle::io
