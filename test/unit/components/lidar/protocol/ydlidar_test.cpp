// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lidar/protocol/ydlidar_protocol.hpp"
#include "simulation/model/ydlidar.hpp"

namespace nacelle::lidar {
namespace {

struct YdBeams final : SweepSink {
  void on_sweep(const Sweep& sweep, std::size_t) override {
    beams.insert(beams.end(), sweep.beams.begin(), sweep.beams.end());
  }
  std::vector<Beam> beams;
};

void expect_accounted(const YdlidarProtocol& protocol) {
  const LineStats s = protocol.stats();
  EXPECT_EQ(s.bytes, s.framed_bytes + s.skipped_bytes + protocol.pending());
}

// The example of the maker's protocol description: a zero packet with one sample.
constexpr const char* kMakersZeroPacket = "aa55010153ae53aeab540000";

TEST(YdlidarDecoder, reads_the_makers_example) {
  Bytes packet;
  ASSERT_TRUE(from_hex(kMakersZeroPacket, packet));
  YdlidarDecoder decoder{false};
  int packets = 0;
  decoder.feed(packet, [&](const YdlidarPacket& read, std::size_t) {
    ++packets;
    EXPECT_TRUE(read.starts_turn);
    EXPECT_EQ(read.count, 1U);
    EXPECT_NEAR(read.first_deg, (0xAE53 >> 1) / 64.0, 1e-9);
    EXPECT_EQ(load_le16(read.samples.data()), 0);
  });
  EXPECT_EQ(packets, 1);
  for (std::size_t bit = 0; bit < packet.size() * 8; ++bit) {
    Bytes bad = packet;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1U << bit % 8);
    YdlidarDecoder other{false};
    other.feed(bad, [&](const YdlidarPacket&, std::size_t) { ADD_FAILURE() << "bit " << bit; });
  }
}

TEST(YdlidarDevice, prints_what_the_maker_prints) {
  // The emulator is held by the same bytes, not by the decoder.
  const simulation::YdlidarSample sample{(0xAE53 >> 1) / 64.0, 0.0, 0};
  EXPECT_EQ(to_hex(simulation::print_ydlidar({&sample, 1}, true, 0.0, false)), kMakersZeroPacket);
}

/// A packet of `count` samples like the one that the description works through: FSA 6fe5, LSA 79bd.
Bytes worked_example(const Bytes& samples, std::uint8_t count, bool with_intensities) {
  Bytes packet{0xAA, 0x55, 0x00, count, 0xE5, 0x6F, 0xBD, 0x79, 0, 0};
  packet.insert(packet.end(), samples.begin(), samples.end());
  unsigned check = 0x55AAU ^ 0x6FE5U ^ 0x79BDU ^ static_cast<unsigned>(count << 8);
  for (std::size_t i = 0; i < samples.size(); i += with_intensities ? 3 : 2) {
    if (with_intensities) check ^= samples[i];
    check ^= load_le16(samples.data() + i + (with_intensities ? 1 : 0));
  }
  store_le16(packet.data() + 8, static_cast<std::uint16_t>(check));
  return packet;
}

TEST(YdlidarProtocol, agrees_with_the_figures_that_the_makers_description_works_out) {
  // Angles 223.78 and 243.47 deg; corrections -6.7622 deg at 1000 mm and -7.8374 deg at 8000 mm; e5 6f is 7161.25 mm, and
  // 1f e5 6f intensity 287 at 7161 mm.
  EXPECT_NEAR(ydlidar_correction_deg(1000.0), -6.7622, 1e-4);
  EXPECT_NEAR(ydlidar_correction_deg(8000.0), -7.8374, 1e-4);
  EXPECT_EQ(ydlidar_correction_deg(0.0), 0.0);

  Bytes samples(80, 0);
  store_le16(samples.data(), 4000);  // 1000 mm
  samples[2] = 0xE5, samples[3] = 0x6F;
  store_le16(samples.data() + 78, 32000);  // 8000 mm
  YdlidarProtocol plain{{.points_per_second = 5000}};
  YdBeams seen;
  plain.feed(worked_example(samples, 40, false), seen);
  ASSERT_EQ(seen.beams.size(), 40U);
  EXPECT_NEAR(seen.beams[0].angle_deg, 217.0178, 0.01);
  EXPECT_NEAR(seen.beams[39].angle_deg, 235.6326, 0.01);
  EXPECT_FLOAT_EQ(seen.beams[0].range_m, 1.0F);
  EXPECT_FLOAT_EQ(seen.beams[1].range_m, 7.16125F);

  YdlidarProtocol bright{{.points_per_second = 5000, .has_intensities = true}};
  YdBeams also;
  bright.feed(worked_example({0x1F, 0xE5, 0x6F}, 1, true), also);
  ASSERT_EQ(also.beams.size(), 1U);
  EXPECT_EQ(also.beams[0].intensity, 287.0F);
  EXPECT_FLOAT_EQ(also.beams[0].range_m, 7.161F);
}

TEST(YdlidarProtocol, gives_the_same_beams_for_any_chopping_and_accounts_for_every_byte) {
  const unsigned seed = 9;
  std::mt19937 random{seed};
  for (const bool with_intensities : {false, true}) {
    Bytes line;
    double rotor_deg = 0.0;
    for (int i = 0; i < 60; ++i) {
      std::vector<simulation::YdlidarSample> samples(1 + random() % 80);
      for (auto& sample : samples)
        sample = {std::fmod(rotor_deg += 0.5, 360.0), static_cast<double>(random() % 8000),
                  static_cast<unsigned>(random() % 1024)};
      const Bytes packet = simulation::print_ydlidar(samples, false, 0.0, with_intensities);
      line.insert(line.end(), packet.begin(), packet.end());
      for (unsigned noise = random() % 4; noise > 0; --noise) line.push_back(random() % 2 == 0 ? 0xAA : 0x55);
    }
    for (int i = 0; i < 5; ++i) line[random() % line.size()] = static_cast<std::uint8_t>(random());
    const YdlidarProtocol::Settings settings{.points_per_second = 5000, .has_intensities = with_intensities};
    YdlidarProtocol whole{settings};
    YdBeams expected;
    whole.feed(line, expected);
    EXPECT_GT(expected.beams.size(), 1000U);
    expect_accounted(whole);
    for (const std::size_t chunk : {1U, 3U, 9U, 10U, 100U}) {
      YdlidarProtocol chopped{settings};
      YdBeams seen;
      for (std::size_t at = 0; at < line.size(); at += chunk)
        chopped.feed(ByteView{line}.subspan(at, std::min(chunk, line.size() - at)), seen);
      EXPECT_EQ(seen.beams, expected.beams) << "chunks of " << chunk;
      EXPECT_EQ(chopped.stats(), whole.stats());
    }
  }
}

TEST(YdlidarProtocol, identifies_measures_and_really_stops) {
  for (const char* model : {"ydlidar_x4", "ydlidar_g2", "ydlidar_g4", "ydlidar_g6"}) {
    const auto settings = simulation::Ydlidar::settings_of(model);
    simulation::Ydlidar device{settings, simulation::Room::with_two_boxes()};
    YdlidarProtocol protocol{{.points_per_second = static_cast<unsigned>(settings.rotor.points_per_second),
                              .has_intensities = settings.has_intensities,
                              .is_commanded = true}};
    YdBeams seen;
    Duration now{};
    const auto run = [&](Duration length) {
      for (const Duration end = now + length; now < end; now += 1ms) {
        device.advance(now, [&](Duration, ByteView bytes) { protocol.feed(bytes, seen); });
        while (const auto action = protocol.next_action(MonotonicTime{1s} + now)) {
          if (action->data_terminal_ready) device.set_data_terminal_ready(*action->data_terminal_ready);
          device.receive(action->bytes, now);
        }
      }
    };
    run(500ms);
    EXPECT_TRUE(protocol.is_settled()) << model;
    EXPECT_NE(protocol.identity().find("firmware 2.1, hardware 3"), std::string::npos) << protocol.identity();
    EXPECT_FALSE(device.is_scanning() || device.motor_turns()) << model;
    protocol.want(true);
    run(1s);
    EXPECT_TRUE(protocol.is_settled() && device.motor_turns()) << model;
    EXPECT_GT(seen.beams.size(), 2000U) << model;
    protocol.want(false);
    run(2ms);
    EXPECT_TRUE(protocol.is_settled()) << model;
    EXPECT_FALSE(device.is_scanning() || device.motor_turns()) << model << ", deactivated";
    expect_accounted(protocol);
    device.set_health(2, 7);
    protocol.restart();
    run(1s);
    EXPECT_EQ(protocol.refusal(), "the LiDAR protects itself: health is error, code 7");
  }
}

}  // namespace
}  // namespace nacelle::lidar
