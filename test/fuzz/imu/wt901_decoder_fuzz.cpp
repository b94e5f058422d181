// SPDX-License-Identifier: Apache-2.0
// Any bytes, in any chopping: nothing crashes, every byte and every frame is accounted for, the output does not
// depend on the chopping, and every sample is finite with a unit quaternion.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "imu/model/sample_assembler.hpp"
#include "imu/protocol/wt901_decoder.hpp"

namespace {

using namespace nacelle::imu;

void require(bool holds) {
  if (!holds) std::abort();
}

void require_accounted(const Wt901Decoder& decoder) {
  const auto& s = decoder.stats();
  require(s.bytes == 11 * s.frames + s.skipped_bytes + decoder.pending());
}

void require_sane(const Sample& sample) {
  for (const double value : sample.acceleration_mps2) require(std::abs(value) <= 16.0 * kGravityMps2 + 1e-9);
  for (const double value : sample.angular_velocity_rps) require(std::abs(value) <= 35.0);
  if (sample.orientation) {
    const auto& q = *sample.orientation;
    require(std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1.0) < 1e-9);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  std::vector<Wt901Frame> whole, chopped;

  Wt901Decoder at_once;
  at_once.feed(bytes, [&](const Wt901Frame& frame, std::size_t after) {
    require(after < size);
    whole.push_back(frame);
  });
  require(at_once.stats().bytes == size);
  require_accounted(at_once);

  Wt901Decoder in_parts;
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 17U);
    in_parts.feed(bytes.subspan(at, part), [&](const Wt901Frame& frame, std::size_t) { chopped.push_back(frame); });
    at += part;
  }
  require(in_parts.stats() == at_once.stats());
  require(whole == chopped);

  SampleAssembler assembler{0x021E, 1.5e-7};
  for (const Wt901Frame& frame : whole) {
    if (assembler.add(frame, {})) require_sane(assembler.sample());
  }
  assembler.restart();
  const auto& s = assembler.stats();
  require(s.frames + s.foreign_frames == whole.size());
  require(s.frames == 5 * s.samples + s.given_up_frames);
  in_parts.restart();
  require_accounted(in_parts);
  return 0;
}
