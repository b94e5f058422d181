// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/line_signature.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string_view>

namespace nacelle::io {
namespace {

using ::testing::HasSubstr;

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
Bytes text(std::string_view text) { return {text.begin(), text.end()}; }

// The LD06 development manual's example of a frame.
const Bytes kLd06{0x54, 0x2C, 0x68, 0x08, 0xAB, 0x7E, 0xE0, 0x00, 0xE4, 0xDC, 0x00, 0xE2, 0xD9, 0x00, 0xE5, 0xD5,
                  0x00, 0xE3, 0xD3, 0x00, 0xE4, 0xD0, 0x00, 0xE9, 0xCD, 0x00, 0xE4, 0xCA, 0x00, 0xE2, 0xC7, 0x00,
                  0xE9, 0xC5, 0x00, 0xE5, 0xC2, 0x00, 0xE5, 0xC0, 0x00, 0xE5, 0xBE, 0x82, 0x3A, 0x1A, 0x50};
// The BNO080 data sheet's example.
const Bytes kRvc{0xAA, 0xAA, 0xDE, 0x01, 0x00, 0x92, 0xFF, 0x25, 0x08, 0x8D,
                 0xFE, 0xEC, 0xFF, 0xD1, 0x03, 0x00, 0x00, 0x00, 0xE7};
// One sample at 0 mm, worked out by hand from YDLIDAR's rule.
const Bytes kYdlidar{0xAA, 0x55, 0x01, 0x01, 0x53, 0xAE, 0x53, 0xAE, 0xAB, 0x54, 0x00, 0x00};
const Bytes kWit{0x55, 0x51, 0, 0, 0, 0, 0, 0x08, 0, 0, 0xAE};

ExpectedDevice lidar() {
  return {"/dev/ttyUSB0", "LD06", 230400, 230400, "port_baudrate", "is the LiDAR powered and turning?"};
}

TEST(LineSignature, recognises_devices_by_two_whole_frames_wherever_the_bytes_begin) {
  const std::pair<Bytes, std::string_view> devices[] = {
      {kLd06, "LD06, LD19 or STL LiDAR"},
      {kRvc, "BNO08x IMU (UART-RVC)"},
      {kYdlidar, "YDLIDAR"},
      {kWit, "WT901 IMU"},
      {text("{\"T\":1001,\"L\":0,\"R\":0,\"v\":12.1}\r\n"), "Waveshare motor board"},
      {text("$GPRMC,081836,A,3751.65,S,14507.36,E,000.0,360.0,130998,011.3,E*62\r\n"), "GPS receiver (NMEA 0183)"},
  };
  for (const auto& [frame, name] : devices) {
    for (std::size_t skipped = 0; skipped < frame.size(); ++skipped) {
      const Bytes heard = frame + frame + frame;
      const SerialDevice* const found = recognise(ByteView{heard}.subspan(skipped));
      ASSERT_NE(found, nullptr) << name << " from byte " << skipped;
      EXPECT_EQ(found->name, name);
    }
  }
}

TEST(LineSignature, one_frame_or_a_bad_one_is_not_enough) {
  Bytes bad = kLd06;
  bad[10] ^= 1U;
  EXPECT_EQ(recognise(kLd06), nullptr);
  EXPECT_EQ(recognise(kLd06 + bad), nullptr);
  EXPECT_EQ(recognise({}), nullptr);
}

TEST(LineSignature, noise_is_no_device) {
  std::mt19937 random{20261127};
  for (int round = 0; round < 200; ++round) {
    Bytes noise(512);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
    EXPECT_EQ(recognise(noise), nullptr) << "round " << round;
  }
}

TEST(LineSignature, every_cut_of_a_recording_is_safe) {
  const Bytes all = kWit + kYdlidar + kRvc + text("$GP*") + text("{\"T\":") + kLd06;
  for (std::size_t begin = 0; begin < all.size(); ++begin) {
    for (std::size_t count = 0; begin + count <= all.size(); ++count) {
      const Bytes cut(all.begin() + static_cast<std::ptrdiff_t>(begin),
                      all.begin() + static_cast<std::ptrdiff_t>(begin + count));
      EXPECT_EQ(recognise(cut), nullptr);
    }
  }
}

TEST(FirstBytes, keeps_what_came_first_up_to_its_size) {
  FirstBytes first;
  first.add(Bytes(500, 1));
  first.add(Bytes(500, 2));
  ASSERT_EQ(first.view().size(), 512U);
  EXPECT_EQ(first.view()[499], 1);
  EXPECT_EQ(first.view()[500], 2);
  first.forget();
  EXPECT_TRUE(first.view().empty());
}

TEST(WhyNoFrames, silence_names_what_to_look_at_first) {
  const Problem problem = why_no_frames(lidar(), {}, 500ms);
  EXPECT_EQ(problem.text(), "/dev/ttyUSB0: nothing came in 0.5 s; is the LiDAR powered and turning?");
}

TEST(WhyNoFrames, another_device_is_named) {
  HeardOnLine heard{.bytes = 33};
  heard.first.add(kWit + kWit + kWit);
  EXPECT_THAT(why_no_frames(lidar(), heard, 1s).text(), HasSubstr("no LD06 frame: they come from a WT901 IMU"));
}

TEST(WhyNoFrames, another_baud_rate_is_suggested_with_the_parameter) {
  ExpectedDevice expected = lidar();
  expected.baud = 115200;
  EXPECT_THAT(why_no_frames(expected, {.bytes = 100}, 1s).way_out,
              HasSubstr("port_baudrate is 115200, the LD06 leaves the factory with 230400"));
}

TEST(WhyNoFrames, bad_checksums_are_a_disturbed_line) {
  EXPECT_THAT(why_no_frames(lidar(), {.bytes = 100, .bad_checksums = 2}, 1s).text(),
              HasSubstr("all 2 frames had a bad checksum; the line is disturbed"));
}

}  // namespace
}  // namespace nacelle::io
