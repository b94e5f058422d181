// SPDX-License-Identifier: Apache-2.0
#include "gps/protocol/nmea_framer.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "simulation/protocol/nmea_receiver.hpp"

namespace nacelle::gps {
namespace {

// u-blox 7 Receiver Description Including Protocol Specification, chapter NMEA.
const std::string kGga = "$GPGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.01,499.6,M,48.0,M,,*5B\r\n";
const std::string kGst = "$GPGST,082356.00,1.8,,,,1.7,1.3,2.2*7E\r\n";

std::vector<std::string> sentences_of(NmeaFramer& framer, std::string_view text) {
  std::vector<std::string> found;
  framer.feed(as_bytes(text), {}, [&](const NmeaSentence& sentence) { found.emplace_back(sentence.text); });
  return found;
}

void expect_accounted(const NmeaFramer& framer) {
  const auto& s = framer.stats();
  EXPECT_EQ(s.bytes, s.sentence_bytes + s.line_end_bytes + s.skipped_bytes + framer.pending());
}

TEST(NmeaFramer, hands_over_the_text_between_dollar_and_star) {
  NmeaFramer framer;
  const auto found = sentences_of(framer, kGga + kGst);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0], "GPGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.01,499.6,M,48.0,M,,");
  EXPECT_EQ(found[1], "GPGST,082356.00,1.8,,,,1.7,1.3,2.2");
  EXPECT_EQ(framer.stats().line_end_bytes, 4U);
  EXPECT_EQ(framer.stats().skipped_bytes, 0U);
}

TEST(NmeaFramer, needs_neither_carriage_return_nor_line_feed) {
  NmeaFramer framer;
  EXPECT_EQ(sentences_of(framer, "$GPGST,082356.00,1.8,,,,1.7,1.3,2.2*7E$GPGST,082356.00,1.8,,,,1.7,1.3,2.2*7e").size(),
            2U);
}

// Both were published with a checksum that is not theirs: DFRobot TEL0137's page, and docs.fixposition.com, NMEA-GN-GST.
TEST(NmeaFramer, refuses_a_wrong_checksum) {
  NmeaFramer framer;
  EXPECT_TRUE(sentences_of(
                  framer, "$GPVTG,309.62,T, ,M,0.13,N,0.2,K*6E\r\n$GNGST,114319.60,5.2,0.4,0.3,62.5,0.3,0.4,1.1*68\r\n")
                  .empty());
  EXPECT_EQ(framer.stats().bad_checksums, 2U);
  expect_accounted(framer);
}

TEST(NmeaFramer, refuses_every_disturbance_of_one_bit) {
  for (std::size_t at = 0; at + 2 < kGga.size(); ++at) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      std::string disturbed = kGga;
      disturbed[at] = static_cast<char>(disturbed[at] ^ (1U << bit));
      NmeaFramer framer;
      const auto found = sentences_of(framer, disturbed);
      // Bit 5 of a hexadecimal letter only changes its case.
      const bool same_digit = at == kGga.size() - 3 && bit == 5;
      EXPECT_EQ(found.size(), same_digit ? 1U : 0U) << "byte " << at << ", bit " << bit;
      expect_accounted(framer);
    }
  }
}

TEST(NmeaFramer, refuses_what_is_torn_too_long_or_without_checksum) {
  NmeaFramer framer;
  EXPECT_TRUE(sentences_of(framer, "$GPGGA,0927").empty());
  EXPECT_EQ(framer.pending(), 11U);
  EXPECT_EQ(sentences_of(framer, kGst).size(), 1U) << "a new sentence ends a torn one";
  EXPECT_TRUE(sentences_of(framer, "$GPGST,082356.00,1.8,,,,1.7,1.3,2.2\r\n").empty());
  EXPECT_TRUE(sentences_of(framer, "$" + std::string(400, 'A') + "*00\r\n").empty());
  EXPECT_TRUE(sentences_of(framer, std::string_view{"$GPGST,\x01\xB5\x62*00\r\n", 15}).empty());
  EXPECT_EQ(framer.stats().broken, 4U);
  EXPECT_EQ(sentences_of(framer, kGst).size(), 1U);
  expect_accounted(framer);
}

TEST(NmeaFramer, restart_forgets_half_a_sentence) {
  NmeaFramer framer;
  EXPECT_TRUE(sentences_of(framer, "$GPGST,082356.00,1.8,").empty());
  framer.restart();
  EXPECT_TRUE(sentences_of(framer, ",,,1.7,1.3,2.2*7E\r\n").empty());
  expect_accounted(framer);
}

TEST(NmeaFramer, gives_the_time_of_the_chunk_with_the_dollar) {
  NmeaFramer framer;
  std::vector<MonotonicTime> starts;
  const auto note = [&](const NmeaSentence& sentence) { starts.push_back(sentence.started); };
  framer.feed(as_bytes("$GPGST,08"), MonotonicTime{5ms}, note);
  framer.feed(as_bytes("2356.00,1.8,,,,1.7,1.3,2.2*7E\r\n$G"), MonotonicTime{9ms}, note);
  framer.feed(as_bytes("PGST,082356.00,1.8,,,,1.7,1.3,2.2*7E\r\n"), MonotonicTime{20ms}, note);
  ASSERT_EQ(starts.size(), 2U);
  EXPECT_EQ(starts[0], MonotonicTime{5ms});
  EXPECT_EQ(starts[1], MonotonicTime{9ms});
}

TEST(NmeaFramer, finds_every_sentence_between_noise_however_it_is_chopped) {
  constexpr unsigned kSeed = 17;
  std::mt19937 random{kSeed};
  std::string line;
  std::size_t whole = 0;
  for (int second = 0; second < 200; ++second) {
    simulation::GpsReading reading;
    reading.time_of_day_ms = second * 1000;
    reading.quality = second % 7 == 0 ? 0 : 1;
    reading.latitude_deg = -33.0 + second * 1e-5;
    reading.longitude_deg = -179.99999;
    line += simulation::print_nmea_burst(reading);
    whole += 5;
    for (unsigned noise = random() % 20; noise > 0; --noise) line += static_cast<char>(random() % 256);
    line += '\n';  // ends a `$` among the noise
  }
  NmeaFramer at_once, chopped;
  EXPECT_EQ(sentences_of(at_once, line).size(), whole) << "seed " << kSeed;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t part = std::min<std::size_t>(line.size() - at, 1 + random() % 50);
    EXPECT_GE(sentences_of(chopped, std::string_view{line}.substr(at, part)).size(), 0U);
    at += part;
  }
  EXPECT_EQ(chopped.stats(), at_once.stats());
  expect_accounted(chopped);
}

}  // namespace
}  // namespace nacelle::gps
