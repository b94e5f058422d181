// SPDX-License-Identifier: Apache-2.0
#include "battery/protocol/ina219_decoder.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace nacelle::battery {
namespace {

Bytes bytes_of(std::string_view text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes)) << text;
  return bytes;
}
// The data sheet's example: 20 mV over the shunt, 11.98 V at the load (5D98 hex), 10 A in steps of 1 mA.
constexpr std::string_view kExample = "00 0200 3fff  01 0200 07d0  02 0200 5d9a  04 0200 2710";

struct Decoded {
  explicit Decoded(const Bytes& bytes) {
    decoder.feed(bytes, [this](const Ina219Reading& reading) { all.push_back(reading); });
    const auto& stats = decoder.stats();
    EXPECT_EQ(stats.bytes, Ina219Decoder::kBlockBytes * stats.blocks + stats.skipped_bytes + decoder.pending());
  }
  Ina219Decoder decoder;
  std::vector<Ina219Reading> all;
};

TEST(Ina219Decoder, reads_the_data_sheets_example) {
  const Decoded decoded{bytes_of(kExample)};
  ASSERT_EQ(decoded.all.size(), 1U);
  const Ina219Reading& reading = decoded.all[0];
  EXPECT_EQ(reading.config, 0x3FFF);
  EXPECT_NEAR(reading.shunt_v(), 0.020, 1e-12);
  EXPECT_NEAR(reading.bus_v(), 11.98, 1e-9);
  EXPECT_EQ(reading.current_counts, 10000);
  EXPECT_TRUE(reading.is_converted);
  EXPECT_FALSE(reading.has_overflown);
}

TEST(Ina219Decoder, reads_negative_values_and_the_overflow) {
  const Decoded decoded{bytes_of("00 0200 3fff  01 0200 8300  02 0200 0001  04 0200 f000")};
  ASSERT_EQ(decoded.all.size(), 1U);
  EXPECT_NEAR(decoded.all[0].shunt_v(), -0.32, 1e-12) << "of the data sheet's table";
  EXPECT_EQ(decoded.all[0].current_counts, -4096);
  EXPECT_TRUE(decoded.all[0].has_overflown);
  EXPECT_FALSE(decoded.all[0].is_converted);
}

TEST(Ina219Decoder, a_poll_that_broke_off_makes_no_reading_with_the_next) {
  const Decoded decoded{bytes_of("00 0200 3fff 01 0200 1111" + std::string(kExample))};
  ASSERT_EQ(decoded.all.size(), 1U);
  EXPECT_EQ(decoded.all[0].shunt_counts, 2000);
  EXPECT_TRUE(Decoded{bytes_of("01 0200 07d0 02 0200 5d9a 04 0200 2710")}.all.empty()) << "without its beginning";
}

TEST(Ina219Decoder, takes_any_chopping_and_accounts_for_noise) {
  std::mt19937 random{20261128};
  Bytes bytes;
  std::size_t whole = 0;
  for (int i = 0; i < 2000; ++i) {
    if (random() % 3 == 0) {
      for (auto noise = random() % 7; noise > 0; --noise) bytes.push_back(static_cast<std::uint8_t>(random() % 6));
    } else {
      const Bytes example = bytes_of(kExample);
      bytes.insert(bytes.end(), example.begin(), example.end());
      ++whole;
    }
  }
  const Decoded at_once{bytes};
  EXPECT_GT(at_once.all.size(), whole / 2);
  EXPECT_GT(at_once.decoder.stats().skipped_bytes, 0U);
  Ina219Decoder in_parts;
  std::vector<Ina219Reading> all;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - at, 1 + random() % 13);
    in_parts.feed(ByteView{bytes}.subspan(at, part), [&](const Ina219Reading& reading) { all.push_back(reading); });
    at += part;
  }
  EXPECT_EQ(all, at_once.all);
  EXPECT_EQ(in_parts.stats(), at_once.decoder.stats());
  in_parts.restart();
  EXPECT_EQ(in_parts.pending(), 0U);
}

}  // namespace
}  // namespace nacelle::battery
