// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lidar/protocol/rplidar_protocol.hpp"
#include "simulation/model/rplidar.hpp"

namespace nacelle::lidar {
namespace {

using simulation::RplidarPoint;

Bytes bytes_of(const char* hex) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(hex, bytes));
  return bytes;
}

/// The beams of all sweeps, and how the sweeps join.
struct Beams final : SweepSink {
  void on_sweep(const Sweep& sweep, std::size_t) override {
    ++sweeps;
    beams.insert(beams.end(), sweep.beams.begin(), sweep.beams.end());
    since_last.push_back(sweep.since_last);
    speed_dps = sweep.speed_dps;
  }
  int sweeps = 0;
  double speed_dps = 0.0;
  std::vector<Beam> beams;
  std::vector<Duration> since_last;
};

void expect_every_byte_accounted_for(const RplidarDecoder& decoder) {
  const LineStats& s = decoder.stats();
  EXPECT_EQ(s.bytes, s.framed_bytes + s.skipped_bytes + decoder.pending());
}

std::vector<Bytes> packets_of(RplidarDecoder& decoder, ByteView bytes, std::size_t chunk) {
  std::vector<Bytes> packets;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(chunk, bytes.size()));
    decoder.feed(part, [&](const RplidarPacket& packet, std::size_t) {
      packets.emplace_back(packet.bytes.begin(), packet.bytes.end());
    });
    bytes = bytes.subspan(part.size());
  }
  return packets;
}

// Descriptors as the maker's protocol description prints them.
constexpr const char* kScanDescriptor = "a55a0500004081";
constexpr const char* kInfoDescriptor = "a55a1400000004";
constexpr const char* kHealthDescriptor = "a55a0300000006";
constexpr const char* kExpressDescriptor = "a55a5400004082";

TEST(RplidarDecoder, knows_the_makers_descriptors) {
  RplidarDecoder decoder;
  decoder.expect(RplidarAnswer::Health);
  Bytes line = bytes_of("00ff");  // the rest of something
  for (const char* text : {kInfoDescriptor, kHealthDescriptor}) {
    const Bytes more = bytes_of(text);
    line.insert(line.end(), more.begin(), more.end());
  }
  line.insert(line.end(), {0x01, 0x34, 0x12, 0x77});
  const auto packets = packets_of(decoder, line, 1);
  ASSERT_EQ(packets.size(), 1U) << "an answer that nobody asked for is none";
  EXPECT_EQ(packets[0], (Bytes{0x01, 0x34, 0x12}));
  EXPECT_EQ(decoder.stats().skipped_bytes, 2U + 7U + 1U);
  expect_every_byte_accounted_for(decoder);
}

// Worked out by hand from the maker's figure: quality 15 and S in 3d, 90 deg * 64 << 1 | 1 in 012d, 1000 mm * 4 in a00f.
constexpr const char* kNodeAt90 = "3d012da00f";

TEST(RplidarFrames, a_node_worked_out_by_hand) {
  const Bytes node = bytes_of(kNodeAt90);
  EXPECT_TRUE(is_rplidar_node(node.data()));
  EXPECT_EQ(node_angle_q6(node.data()), 90U * 64U);
  Bytes wrong = node;
  wrong[0] ^= 2U;
  EXPECT_FALSE(is_rplidar_node(wrong.data())) << "S and not S are equal";
  wrong = node;
  wrong[1] ^= 1U;
  EXPECT_FALSE(is_rplidar_node(wrong.data())) << "the check bit is 0";

  RplidarDecoder decoder;
  RplidarSweeps sweeps;
  Beams seen;
  sweeps.begin(508us);
  decoder.expect(RplidarAnswer::Nodes);
  Bytes line = bytes_of(kScanDescriptor);
  for (int i = 0; i < 3; ++i) line.insert(line.end(), node.begin(), node.end());
  decoder.feed(line, [&](const RplidarPacket& packet, std::size_t after) { sweeps.take(packet, after, seen); });
  ASSERT_EQ(seen.beams.size(), 3U);
  EXPECT_EQ(seen.beams[0], (Beam{90.0F, 1.0F, 15.0F}));
}

TEST(RplidarDevice, prints_what_the_maker_prints) {
  // The emulator is held by the same bytes, not by the decoder.
  EXPECT_EQ(to_hex(simulation::print_rplidar_descriptor(5, true, 0x81)), kScanDescriptor);
  EXPECT_EQ(to_hex(simulation::print_rplidar_descriptor(20, false, 0x04)), kInfoDescriptor);
  EXPECT_EQ(to_hex(simulation::print_rplidar_descriptor(3, false, 0x06)), kHealthDescriptor);
  EXPECT_EQ(to_hex(simulation::print_rplidar_descriptor(84, true, 0x82)), kExpressDescriptor);
  EXPECT_EQ(to_hex(simulation::print_rplidar_node({90.0, 0.0, 1000.0}, true, 15)), kNodeAt90);
}

TEST(RplidarFrames, a_capsule_worked_out_by_hand) {
  // Start 10 deg; the first cabin: 1000 mm at offset 2.5 deg (20/8: low nibble 4, high bits 1), 2000 mm at offset 0.625 deg (5/8).
  Bytes capsule(84, 0);
  capsule[0] = 0xA0;
  capsule[1] = 0x50;
  store_le16(capsule.data() + 2, 10 * 64);
  store_le16(capsule.data() + 4, 1000 << 2 | 1);
  store_le16(capsule.data() + 6, 2000 << 2);
  capsule[8] = 0x54;
  std::uint8_t sum = 0;
  for (std::size_t i = 2; i < capsule.size(); ++i) sum = static_cast<std::uint8_t>(sum ^ capsule[i]);
  capsule[0] = static_cast<std::uint8_t>(capsule[0] | (sum & 0xFU));
  capsule[1] = static_cast<std::uint8_t>(capsule[1] | sum >> 4U);
  ASSERT_TRUE(is_rplidar_capsule(capsule));

  std::array<Beam, rplidar_layout::kMostPoints> beams{};
  EXPECT_EQ(rplidar_beams(RplidarAnswer::Capsules, capsule, capsule, 10.0, 1.0, beams), 32U);
  EXPECT_EQ(beams[0], (Beam{7.5F, 1.0F, 0.0F}));
  EXPECT_EQ(beams[1], (Beam{10.375F, 2.0F, 0.0F}));
  EXPECT_EQ(beams[31].range_m, 0.0F);
  for (std::size_t bit = 16; bit < capsule.size() * 8; ++bit) {
    Bytes bad = capsule;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1U << bit % 8);
    EXPECT_FALSE(is_rplidar_capsule(bad)) << "bit " << bit;
  }
}

TEST(RplidarFrames, the_scales_of_ultra_capsules_join) {
  // The ends of the maker's segments: 512, 1280, 1792 and 3328 stand for 2^9, 2^11, 2^12 and 2^14 mm.
  EXPECT_EQ(ultra_range(0).mm, 0U);
  EXPECT_EQ(ultra_range(511).mm, 511U);
  EXPECT_EQ(ultra_range(512).mm, 512U);
  EXPECT_EQ(ultra_range(1279).mm, 2046U);
  EXPECT_EQ(ultra_range(1280).mm, 2048U);
  EXPECT_EQ(ultra_range(1792).mm, 4096U);
  EXPECT_EQ(ultra_range(3327).mm, 16376U);
  EXPECT_EQ(ultra_range(3328).mm, 16384U);
  EXPECT_EQ(ultra_range(4095).mm, 16384U + 767U * 16U);
}

/// What the device's side packs, through the driver's decoder. Ranges and angles as they were, within the format's steps.
void expect_round_trip(RplidarAnswer type, double range_step_mm, double angle_step_deg) {
  const unsigned seed = 4;
  std::mt19937 random{seed};
  const std::size_t count = points_of(type);
  RplidarDecoder decoder;
  RplidarSweeps sweeps;
  Beams seen;
  std::vector<RplidarPoint> all;
  double rotor_deg = 350.0;
  const auto point = [&] {
    RplidarPoint made;
    made.rotor_deg = std::fmod(rotor_deg, 360.0);
    rotor_deg += 0.25;
    made.range_mm = random() % 20 == 0 ? 0.0 : 200.0 + random() % 1000 / 10.0 + (all.size() / 50) % 30 * 300.0;
    if (type == RplidarAnswer::Capsules) made.offset_deg = random() % 63 / 8.0;
    if (type == RplidarAnswer::UltraCapsules) made.offset_deg = simulation::rplidar_offset_deg(made.range_mm);
    all.push_back(made);
    return made;
  };
  point();
  decoder.expect(type);
  sweeps.begin(100us);
  const auto feed = [&](ByteView bytes) {
    decoder.feed(bytes, [&](const RplidarPacket& packet, std::size_t after) { sweeps.take(packet, after, seen); });
  };
  feed(simulation::print_rplidar_descriptor(static_cast<std::uint32_t>(packet_bytes_of(type)), true,
                                            static_cast<std::uint8_t>(type)));
  for (std::size_t packet = 0; packet < 40; ++packet) {
    while (all.size() < (packet + 1) * count + 1) point();
    const std::span<const RplidarPoint> points{all.data() + packet * count, count};
    feed(type == RplidarAnswer::Capsules ? simulation::print_rplidar_capsule(points, packet == 0)
         : type == RplidarAnswer::DenseCapsules
             ? simulation::print_rplidar_dense_capsule(points, packet == 0)
             : simulation::print_rplidar_ultra_capsule(points, all.back(), packet == 0));
  }
  ASSERT_EQ(seen.beams.size(), 39 * count) << "the last capsule waits for the next";
  EXPECT_NEAR(seen.speed_dps, 2500.0, 10.0);
  for (std::size_t i = 0; i < seen.beams.size(); ++i) {
    const bool too_far_aside = type == RplidarAnswer::UltraCapsules && seen.beams[i].range_m == 0.0F;
    if (!too_far_aside) {
      EXPECT_NEAR(seen.beams[i].range_m * 1000.0, all[i].range_mm, range_step_mm) << "point " << i;
    }
    const double off_deg =
        std::remainder(static_cast<double>(seen.beams[i].angle_deg) - (all[i].rotor_deg - all[i].offset_deg), 360.0);
    if (seen.beams[i].range_m != 0.0F) { EXPECT_NEAR(off_deg, 0.0, angle_step_deg) << "point " << i; }
    EXPECT_GE(seen.beams[i].angle_deg, 0.0F);
    EXPECT_LE(seen.beams[i].angle_deg, 360.0F);
  }
  for (std::size_t i = 1; i < seen.since_last.size(); ++i)
    EXPECT_EQ(seen.since_last[i], static_cast<std::int64_t>(count) * Duration{100us});
  expect_every_byte_accounted_for(decoder);
}

TEST(RplidarSweeps, read_back_what_the_device_side_packs) {
  expect_round_trip(RplidarAnswer::Capsules, 0.51, 0.09);
  expect_round_trip(RplidarAnswer::DenseCapsules, 0.51, 0.02);
  expect_round_trip(RplidarAnswer::UltraCapsules, 8.1, 0.3);
}

Bytes stream_of(RplidarAnswer type, unsigned packets) {
  Bytes line = simulation::print_rplidar_descriptor(static_cast<std::uint32_t>(packet_bytes_of(type)), true,
                                                    static_cast<std::uint8_t>(type));
  double rotor_deg = 0.0;
  for (unsigned i = 0; i < packets; ++i) {
    std::vector<RplidarPoint> points(97);
    for (RplidarPoint& point : points) point = {std::fmod(rotor_deg += 0.7, 360.0), 0.0, 1000.0 + rotor_deg};
    rotor_deg -= (97.0 - static_cast<double>(points_of(type))) * 0.7;
    Bytes packet;
    if (type == RplidarAnswer::Nodes) {
      const auto node = simulation::print_rplidar_node(points[0], false, 40);
      packet.assign(node.begin(), node.end());
    } else {
      packet = type == RplidarAnswer::Capsules ? simulation::print_rplidar_capsule(points, i == 0)
               : type == RplidarAnswer::DenseCapsules
                   ? simulation::print_rplidar_dense_capsule(points, i == 0)
                   : simulation::print_rplidar_ultra_capsule(points, points[96], i == 0);
    }
    line.insert(line.end(), packet.begin(), packet.end());
  }
  return line;
}

TEST(RplidarDecoder, gives_the_same_packets_for_any_chopping) {
  const unsigned seed = 6;
  std::mt19937 random{seed};
  for (const RplidarAnswer type :
       {RplidarAnswer::Nodes, RplidarAnswer::Capsules, RplidarAnswer::DenseCapsules, RplidarAnswer::UltraCapsules}) {
    Bytes line = stream_of(type, 60);
    for (int i = 0; i < 6; ++i) line[40 + random() % (line.size() - 40)] = static_cast<std::uint8_t>(random());
    line.erase(line.begin() + 200);
    RplidarDecoder whole;
    whole.expect(type);
    const auto expected = packets_of(whole, line, line.size());
    EXPECT_GE(expected.size(), 40U) << "type " << static_cast<int>(type) << ", seed " << seed;
    for (const std::size_t chunk : {1U, 2U, 7U, 83U, 84U, 131U, 1000U}) {
      RplidarDecoder chopped;
      chopped.expect(type);
      EXPECT_EQ(packets_of(chopped, line, chunk), expected) << "chunks of " << chunk;
      EXPECT_EQ(chopped.stats(), whole.stats()) << "chunks of " << chunk;
      expect_every_byte_accounted_for(chopped);
    }
  }
}

TEST(RplidarDecoder, a_lost_byte_costs_a_node_and_not_the_alignment) {
  Bytes line = stream_of(RplidarAnswer::Nodes, 100);
  line.erase(line.begin() + 7 + 50 * 5 + 2);
  RplidarDecoder decoder;
  decoder.expect(RplidarAnswer::Nodes);
  EXPECT_GE(packets_of(decoder, line, 64).size(), 98U);
  expect_every_byte_accounted_for(decoder);
}

TEST(RplidarDecoder, accounts_for_every_byte_of_noise) {
  const unsigned seed = 20261127;
  std::mt19937 random{seed};
  for (const RplidarAnswer type :
       {RplidarAnswer::Info, RplidarAnswer::Nodes, RplidarAnswer::Capsules, RplidarAnswer::UltraCapsules}) {
    RplidarDecoder decoder;
    decoder.expect(type);
    Bytes noise;
    if (is_stream(type)) noise = stream_of(type, 1);
    for (int i = 0; i < 30000; ++i) {
      const std::uint32_t draw = random();
      noise.push_back(draw % 6 == 0 ? 0xA5 : draw % 6 == 1 ? 0x5A : static_cast<std::uint8_t>(draw >> 8U));
    }
    packets_of(decoder, noise, 50);
    expect_every_byte_accounted_for(decoder);
  }
}

/// A simulated device and the protocol, joined without a line; time is told.
class Talk {
 public:
  Talk(simulation::Rplidar::Settings settings, std::string scan_mode)
      : device{std::move(settings), simulation::Room::with_two_boxes()}, protocol{std::move(scan_mode)} {}

  void run(Duration length) {
    for (const Duration end = now + length; now < end; now += 1ms) {
      device.advance(now, [&](Duration, ByteView bytes) { protocol.feed(bytes, beams); });
      while (const auto action = protocol.next_action(MonotonicTime{1s} + now)) {
        if (action->data_terminal_ready) device.set_data_terminal_ready(*action->data_terminal_ready);
        sent.insert(sent.end(), action->bytes.begin(), action->bytes.end());
        device.receive(action->bytes, now);
      }
    }
  }
  simulation::Rplidar device;
  RplidarProtocol protocol;
  Beams beams;
  Bytes sent;
  Duration now{};
};

TEST(RplidarProtocol, identifies_measures_and_really_stops) {
  Talk talk{simulation::Rplidar::settings_of("rplidar_a1"), ""};
  talk.run(500ms);
  EXPECT_TRUE(talk.protocol.is_settled());
  EXPECT_NE(talk.protocol.identity().find("RPLIDAR A1 (model 18), firmware 1.29"), std::string::npos)
      << talk.protocol.identity();
  EXPECT_NE(talk.protocol.identity().find("scan mode Express at 3937 points/s"), std::string::npos)
      << talk.protocol.identity();
  EXPECT_FALSE(talk.device.motor_turns()) << "idle: DTR stops the motor";
  EXPECT_FALSE(talk.device.is_scanning());

  talk.protocol.want(true);
  EXPECT_FALSE(talk.protocol.is_settled());
  talk.run(1s);
  EXPECT_TRUE(talk.protocol.is_settled());
  EXPECT_TRUE(talk.device.motor_turns());
  EXPECT_GT(talk.beams.beams.size(), 3000U);

  talk.protocol.want(false);
  talk.run(2ms);
  EXPECT_TRUE(talk.protocol.is_settled());
  EXPECT_FALSE(talk.device.is_scanning()) << "deactivated";
  EXPECT_FALSE(talk.device.motor_turns()) << "deactivated";
  EXPECT_EQ(talk.device.requests().bad_checksums, 0U);
}

TEST(RplidarProtocol, stops_the_motor_also_while_the_device_is_identified_anew) {
  Talk talk{simulation::Rplidar::settings_of("rplidar_a1"), ""};
  talk.protocol.want(true);
  talk.run(1s);
  talk.protocol.restart();  // the line was opened again
  talk.run(5ms);
  EXPECT_TRUE(talk.device.motor_turns());
  talk.protocol.want(false);
  talk.run(2ms);
  EXPECT_FALSE(talk.device.is_scanning() || talk.device.motor_turns());
  EXPECT_TRUE(talk.protocol.is_settled());
}

TEST(RplidarProtocol, sends_the_requests_that_the_makers_description_prints) {
  Talk talk{simulation::Rplidar::settings_of("rplidar_a2"), "express"};
  talk.protocol.want(true);
  talk.run(1s);
  const auto sent = [&](const char* hex) {
    const Bytes wanted = bytes_of(hex);
    return std::search(talk.sent.begin(), talk.sent.end(), wanted.begin(), wanted.end()) != talk.sent.end();
  };
  EXPECT_TRUE(sent("a525")) << "stop";
  EXPECT_TRUE(sent("a550")) << "info";
  EXPECT_TRUE(sent("a552")) << "health";
  EXPECT_TRUE(sent("a5f0029402c1")) << "motor at PWM 660";
  EXPECT_TRUE(sent("a58205010000000023")) << "express scan of mode 1";
  EXPECT_TRUE(talk.device.motor_turns());
}

TEST(RplidarProtocol, each_series_measures_in_the_mode_that_it_recommends_and_in_any_other) {
  for (const char* model : {"rplidar_a1", "rplidar_a2", "rplidar_a3", "rplidar_c1", "rplidar_s1", "rplidar_s2"}) {
    const auto settings = simulation::Rplidar::settings_of(model);
    for (std::size_t mode = 0; mode <= settings.modes.size(); ++mode) {
      Talk talk{settings, mode == 0 ? "" : settings.modes[mode - 1].name};
      talk.protocol.want(true);
      talk.run(1500ms);
      EXPECT_TRUE(talk.protocol.is_settled()) << model << ", mode " << mode << ": " << talk.protocol.refusal();
      EXPECT_TRUE(talk.device.motor_turns()) << model;
      EXPECT_GT(talk.beams.beams.size(), 1000U) << model << ", mode " << mode;
      talk.protocol.want(false);
      talk.run(2ms);
      EXPECT_FALSE(talk.device.is_scanning() || talk.device.motor_turns()) << model;
    }
  }
}

TEST(RplidarProtocol, old_firmware_without_scan_modes_has_standard_and_express) {
  auto settings = simulation::Rplidar::settings_of("rplidar_a1");
  settings.has_modes = false;
  Talk express{settings, ""};
  express.protocol.want(true);
  express.run(3s);
  EXPECT_TRUE(express.protocol.is_settled());
  EXPECT_NE(express.protocol.identity().find("Express at 3937"), std::string::npos) << express.protocol.identity();
  settings.firmware = 0x0110;  // 1.16 has no express scan
  Talk standard{settings, ""};
  standard.protocol.want(true);
  standard.run(3s);
  EXPECT_NE(standard.protocol.identity().find("Standard at 1969"), std::string::npos) << standard.protocol.identity();
  EXPECT_GT(standard.beams.beams.size(), 1000U);
}

TEST(RplidarProtocol, a_mode_that_the_device_does_not_have_is_refused_with_those_that_it_has) {
  Talk talk{simulation::Rplidar::settings_of("rplidar_a3"), "Turbo"};
  talk.run(1s);
  EXPECT_EQ(talk.protocol.refusal(), "scan_mode 'Turbo' is none of the LiDAR's: Standard, Express, Boost");
}

TEST(RplidarProtocol, bad_health_is_reset_once_and_then_refused) {
  Talk heals{simulation::Rplidar::settings_of("rplidar_a1"), ""};
  heals.device.set_health(2, 0x8001, true);
  heals.protocol.want(true);
  heals.run(5s);
  EXPECT_TRUE(heals.protocol.is_settled()) << heals.protocol.refusal();

  Talk stays{simulation::Rplidar::settings_of("rplidar_a1"), ""};
  stays.device.set_health(2, 0x8001, false);
  stays.run(5s);
  EXPECT_EQ(stays.protocol.refusal(), "the LiDAR protects itself: health is error, code 32769");
  stays.device.set_health(0, 0, false);
  stays.run(8s);
  EXPECT_EQ(stays.protocol.refusal(), "") << "it is asked again";
  EXPECT_TRUE(stays.protocol.is_settled());
}

TEST(RplidarProtocol, a_stream_that_dries_up_is_begun_anew) {
  Talk talk{simulation::Rplidar::settings_of("rplidar_a1"), ""};
  talk.protocol.want(true);
  talk.run(1s);
  talk.device.receive(Bytes{0xA5, 0x40}, talk.now);  // as after a dip of its supply
  talk.run(500ms);
  const std::size_t before = talk.beams.beams.size();
  talk.run(4s);
  EXPECT_TRUE(talk.protocol.is_settled());
  EXPECT_GT(talk.beams.beams.size(), before + 1000U);
}

}  // namespace
}  // namespace nacelle::lidar
