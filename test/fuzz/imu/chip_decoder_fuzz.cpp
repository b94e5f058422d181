// SPDX-License-Identifier: Apache-2.0
// Any bytes as the stream of a polled chip, in any chopping: nothing crashes, every byte is accounted for by the blocks and
// again by the chip's decoder, the output does not depend on the chopping, and every sample is finite.
// The first byte chooses the chip.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <vector>

#include "imu/model/chip_reader.hpp"

namespace {

using namespace nacelle::imu;

void require(bool holds) {
  if (!holds) std::abort();
}

std::unique_ptr<ChipDecoder> make(unsigned which) {
  using Compass = InvensenseDecoder::Compass;
  switch (which % 6) {
    case 0: return std::make_unique<InvensenseDecoder>(false, Compass::Ak8963);
    case 1: return std::make_unique<InvensenseDecoder>(true, Compass::Ak09916);
    case 2: return std::make_unique<Lsm6dsoxDecoder>(true);
    case 3: return std::make_unique<Lsm6dsoxDecoder>(false);
    case 4: return std::make_unique<Bmi088Decoder>();
    default: return std::make_unique<Bno055Decoder>();
  }
}

class Readings final : public ReadingSink {
 public:
  void on_reading(const ChipReading& reading) override { all.push_back(reading); }
  std::vector<ChipReading> all;
};

class Samples final : public SampleSink {
 public:
  void on_sample(const Sample& sample, nacelle::Duration step) override {
    require(step >= nacelle::Duration::zero());
    for (const double value : sample.acceleration_mps2) require(std::isfinite(value));
    for (const double value : sample.angular_velocity_rps) require(std::isfinite(value));
    if (sample.orientation) {
      const auto& q = *sample.orientation;
      require(std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1.0) < 1e-9);
    }
  }
};

std::vector<ChipReading> decode(unsigned which, nacelle::ByteView bytes, bool chopped) {
  BlockDecoder blocks;
  const auto decoder = make(which);
  Readings readings;
  const auto on_block = [&](std::uint8_t tag, nacelle::ByteView payload) { decoder->feed(tag, payload, readings); };
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = chopped ? std::min<std::size_t>(bytes.size() - at, 1 + bytes[at] % 17U) : bytes.size();
    blocks.feed(bytes.subspan(at, part), on_block);
    at += part;
  }
  const auto& b = blocks.stats();
  require(b.bytes == bytes.size());
  require(b.bytes == 3 * b.blocks + b.payload_bytes + b.skipped_bytes + blocks.pending());
  const auto& c = decoder->stats();
  require(c.bytes == b.payload_bytes);
  require(c.bytes == c.used_bytes + c.skipped_bytes);
  require(c.readings == readings.all.size());
  return readings.all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const nacelle::ByteView bytes{data + 1, size - 1};
  require(decode(data[0], bytes, false) == decode(data[0], bytes, true));

  ChipUnits units;
  units.acceleration_mps2 = units.angular_velocity_rps = units.magnetic_field_t = units.temperature_k = 1e-3;
  units.quaternion = 1.0 / 16384;
  units.tick = nacelle::Duration{25'000};
  units.period = nacelle::Duration{10'000'000};
  ChipReader reader{make(data[0]), units};
  Samples samples;
  reader.feed(bytes, {}, samples);
  reader.restart();
  reader.feed(bytes, {}, samples);
  return 0;
}
