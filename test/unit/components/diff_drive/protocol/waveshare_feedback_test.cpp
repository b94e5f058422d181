// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/waveshare_feedback.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace nacelle::diff_drive {
namespace {

using Stats = WaveshareLineDecoder::Stats;

// One line per age of the firmware, in the fields of the table in waveshare_feedback.hpp.
constexpr const char* kOldest =
    R"({"T":1001,"L":0.25,"R":-0.125,"r":90,"p":-45,"v":11.9,"x":1,"y":2,"z":3,"b":0,"s":0,"e":1,"t":2,"torB":0})";
constexpr const char* kMiddle = R"({"T":1001,"L":0.5,"R":0.25,"r":1,"p":2,"y":180,"q0":1,"q1":0,"q2":0,"q3":0,)"
                                R"("ax":0,"ay":0,"az":9.8,"gx":0,"gy":0,"gz":0,"odl":1.25,"odr":-0.75,"v":12.1})";
constexpr const char* kNewest = R"({"T":1001,"L":0.5,"R":0.25,"ax":1,"ay":2,"az":8192,"gx":3,"gy":4,"gz":5,)"
                                R"("mx":6,"my":7,"mz":8,"odl":125,"odr":-75,"v":1210,"pan":0,"tilt":1})";

void expect_accounted(const WaveshareLineDecoder& decoder) {
  const Stats& s = decoder.stats();
  EXPECT_EQ(s.bytes, s.feedback_bytes + s.other_bytes + s.malformed_bytes + s.overlong_bytes + s.blank_bytes +
                         decoder.pending());
}
std::vector<BaseFeedback> feed_chopped(WaveshareLineDecoder& decoder, const std::string& text, std::mt19937& random) {
  std::vector<BaseFeedback> got;
  ByteView rest = as_bytes(text);
  while (!rest.empty()) {
    const std::size_t size = std::min<std::size_t>(rest.size(), random() % 40);
    decoder.feed(rest.first(size), [&](const BaseFeedback& feedback) { got.push_back(feedback); });
    rest = rest.subspan(size);
  }
  return got;
}

TEST(WaveshareFeedback, reads_every_age_of_the_firmware_in_si_units) {
  const auto oldest = decode_base_feedback(kOldest);
  ASSERT_TRUE(oldest);
  EXPECT_EQ(oldest.value().left_mps, 0.25);
  EXPECT_EQ(oldest.value().right_mps, -0.125);
  EXPECT_EQ(oldest.value().voltage_v, 11.9);
  EXPECT_NEAR(oldest.value().roll_rad.value(), std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(oldest.value().pitch_rad.value(), -std::numbers::pi / 4, 1e-12);
  EXPECT_FALSE(oldest.value().yaw_rad) << "y is a coordinate of the arm here";
  EXPECT_FALSE(oldest.value().left_travel_m);

  const auto middle = decode_base_feedback(kMiddle);
  ASSERT_TRUE(middle);
  EXPECT_EQ(middle.value().left_travel_m, 1.25);
  EXPECT_EQ(middle.value().right_travel_m, -0.75);
  EXPECT_EQ(middle.value().voltage_v, 12.1);
  EXPECT_NEAR(middle.value().yaw_rad.value(), std::numbers::pi, 1e-12);

  const auto newest = decode_base_feedback(kNewest);
  ASSERT_TRUE(newest);
  EXPECT_NEAR(newest.value().left_travel_m.value(), 1.25, 1e-12);
  EXPECT_NEAR(newest.value().right_travel_m.value(), -0.75, 1e-12);
  EXPECT_NEAR(newest.value().voltage_v.value(), 12.10, 1e-12);
  EXPECT_FALSE(newest.value().roll_rad);
}

TEST(WaveshareFeedback, a_value_the_board_could_not_compute_is_absent) {
  const auto feedback = decode_base_feedback(R"({"T":1001,"L":0,"R":0,"odl":null,"odr":1.0,"v":null})");
  ASSERT_TRUE(feedback);
  EXPECT_FALSE(feedback.value().left_travel_m);
  EXPECT_FALSE(feedback.value().right_travel_m) << "one wheel's travel alone is no travel";
  EXPECT_FALSE(feedback.value().voltage_v);
}

TEST(WaveshareFeedback, says_why_a_line_is_not_feedback) {
  EXPECT_EQ(decode_base_feedback(R"({"T":1002,"r":1})").error(), LineFault::OtherType);
  for (const char* line :
       {"", "boot ok", R"({"L":1,"R":1})", R"({"T":"1001","L":1,"R":1})", R"({"T":1001,"L":1})",
        R"({"T":1001,"L":"x","R":1})", R"({"T":1001,"L":1,"R":1)", R"({"T":1001,"L":1e9,"R":1})",
        R"({"T":1001,"L":0,"R":0,"odl":1e300,"odr":0})", R"({"T":1001,"L":0,"R":0}{"T":1001,"L":0,"R":0})"}) {
    const auto feedback = decode_base_feedback(line);
    ASSERT_FALSE(feedback) << line;
    EXPECT_EQ(feedback.error(), LineFault::Malformed) << line;
  }
}

TEST(WaveshareLines, come_through_any_chopping) {
  const std::string text =
      std::string(kOldest) + "\n" + kMiddle + "\r\n\n" + kNewest + "\n{\"T\":1002}\nnoise\n" + kMiddle + "\n";
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random{seed};
    WaveshareLineDecoder decoder;
    const auto got = feed_chopped(decoder, text, random);
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    ASSERT_EQ(got.size(), 4U);
    EXPECT_EQ(got[1], got[3]);
    EXPECT_EQ(got[0], decode_base_feedback(kOldest).value());
    EXPECT_EQ(got[2], decode_base_feedback(kNewest).value());
    EXPECT_EQ(decoder.stats().other_lines, 1U);
    EXPECT_EQ(decoder.stats().malformed_lines, 1U);
    EXPECT_EQ(decoder.stats().blank_bytes, 1U);
    expect_accounted(decoder);
  }
}

TEST(WaveshareLines, account_for_every_byte_of_noise) {
  const std::string alphabet = "{}\":,\\\n\r T10LRodlv.-+eE\x01\xff";
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random{seed};
    std::string text;
    for (int i = 0; i < 3000; ++i) {
      if (random() % 200 == 0) text += std::string(kMiddle) + "\n";
      text += alphabet[random() % alphabet.size()];
    }
    WaveshareLineDecoder decoder;
    feed_chopped(decoder, text, random);
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    EXPECT_EQ(decoder.stats().bytes, text.size());
    expect_accounted(decoder);
  }
}

TEST(WaveshareLines, skip_an_overlong_line_and_take_the_next) {
  std::mt19937 random{9};
  WaveshareLineDecoder decoder;
  const auto got = feed_chopped(decoder, std::string(100000, 'x') + "\n" + kMiddle + "\n", random);
  EXPECT_EQ(got.size(), 1U);
  EXPECT_EQ(decoder.stats().overlong_lines, 1U);
  EXPECT_EQ(decoder.stats().overlong_bytes, 100001U);
  expect_accounted(decoder);
}

TEST(WaveshareLines, take_a_line_of_exactly_the_greatest_length) {
  std::string line = kMiddle;
  line.append(WaveshareLineDecoder::kMaxLineBytes - line.size(), ' ');
  std::mt19937 random{10};
  WaveshareLineDecoder decoder;
  EXPECT_EQ(feed_chopped(decoder, line + "\n", random).size(), 1U);
  EXPECT_EQ(feed_chopped(decoder, line + " \n", random).size(), 0U);
  EXPECT_EQ(decoder.stats().overlong_lines, 1U);
  expect_accounted(decoder);
}

TEST(WaveshareLines, a_restart_drops_the_line_that_had_begun) {
  std::mt19937 random{11};
  WaveshareLineDecoder decoder;
  feed_chopped(decoder, R"({"T":1001,"L":)", random);
  decoder.restart();
  EXPECT_EQ(decoder.pending(), 0U);
  EXPECT_EQ(feed_chopped(decoder, std::string(kMiddle) + "\n", random).size(), 1U);
  EXPECT_EQ(decoder.stats().malformed_lines, 1U);
  expect_accounted(decoder);
}

}  // namespace
}  // namespace nacelle::diff_drive
