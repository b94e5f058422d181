// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "devices/device_runs.hpp"
#include "lidar/model/scan_assembler.hpp"
#include "lidar/protocol/ld_protocol.hpp"
#include "simulation/protocol/ld06_encoder.hpp"
#include "support/arguments.hpp"
#include "support/usage.hpp"

namespace nacelle::bench {
namespace {

constexpr unsigned kPointsPerSecond = 4500;
/// 69 reads a second of 17,625 bytes.
constexpr std::size_t kRead = 255;
/// Some turns of 10 per second; repeating them is a device whose clock restarts.
constexpr std::uint64_t kPackets = 375;

Bytes stream_of_a_second() {
  Bytes bytes;
  for (std::uint64_t i = 0; i < kPackets; ++i) {
    simulation::Ld06Packet packet;
    packet.speed_dps = 3600;
    packet.start_cdeg = static_cast<std::uint16_t>(i * 960 % 36000);
    packet.end_cdeg = static_cast<std::uint16_t>((i * 960 + 880) % 36000);
    packet.time_ms = static_cast<std::uint16_t>(i * 1000 / kPackets);
    for (std::size_t point = 0; point < packet.points.size(); ++point)
      packet.points[point] = {static_cast<std::uint16_t>(500 + (i * 12 + point) % 4000), 200};
    const auto printed = simulation::print_ld06(packet);
    bytes.insert(bytes.end(), printed.begin(), printed.end());
  }
  return bytes;
}

/// Hands reads to `take` until it has had `packets` packets.
template <typename Take>
void read(const Bytes& bytes, std::uint64_t packets, const Take& take) {
  std::size_t left = packets * 47;
  while (left > 0) {
    for (std::size_t at = 0; at < bytes.size() && left > 0; at += kRead) {
      const std::size_t count = std::min({kRead, bytes.size() - at, left});
      take(ByteView{bytes.data() + at, count});
      left -= count;
    }
  }
}

class Scans final : public lidar::SweepSink {
 public:
  void on_sweep(const lidar::Sweep& sweep, std::size_t) override {
    at_ += 12 * sweep.period;
    assembler_.add(sweep, at_, [this](const lidar::Scan&) { ++scans; });
  }
  std::uint64_t scans = 0;

 private:
  lidar::ScanAssembler assembler_{lidar::ScanOptions{}};
  MonotonicTime at_{};
};

}  // namespace

void run_ld06(std::uint64_t packets, bool assembles) {
  const Bytes bytes = stream_of_a_second();
  std::uint64_t frames = 0, scans = 0;
  Usage before;
  if (assembles) {
    lidar::LdProtocol protocol{kPointsPerSecond};
    Scans sink;
    before = Usage::now();
    read(bytes, packets, [&](ByteView part) { protocol.feed(part, sink); });
    frames = protocol.stats().frames;
    scans = sink.scans;
  } else {
    lidar::Ld06Decoder decoder{kPointsPerSecond};
    std::uint64_t sum = 0;
    before = Usage::now();
    read(bytes, packets, [&](ByteView part) {
      decoder.feed(part, [&](const lidar::Ld06Frame& frame, std::size_t) { sum += frame.points[11].range_mm; });
    });
    frames = sum == 0 ? 0 : decoder.stats().frames;
  }
  const Usage used = Usage::now() - before;
  print_figures({{"frames", static_cast<double>(frames)},
                 {"lost", static_cast<double>(packets) - static_cast<double>(frames)},
                 {"scans", static_cast<double>(scans)},
                 {"mallocs", static_cast<double>(used.mallocs)}});
}

}  // namespace nacelle::bench
