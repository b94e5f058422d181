// SPDX-License-Identifier: Apache-2.0
// Any bytes, in any chopping: nothing crashes, every byte is accounted for, the output does not depend on the
// chopping, and every scan made of it has its length and only ranges that REP 117 allows.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "lidar/model/scan_assembler.hpp"
#include "lidar/protocol/ld_protocol.hpp"

namespace {

using namespace nacelle::lidar;

void require(bool holds) {
  if (!holds) std::abort();
}

void require_accounted(const Ld06Decoder& decoder) {
  const auto& s = decoder.stats();
  require(s.bytes == 47 * (s.frames + s.implausible) + s.skipped_bytes + decoder.pending());
}

void require_scan(const Scan& scan) {
  require(scan.ranges_m.size() == 450 && scan.intensities.size() == 450);
  for (const float range : scan.ranges_m) {
    require(std::isnan(range) || std::isinf(range) || (range >= 0.0199F && range <= 12.001F));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  std::vector<Ld06Frame> whole, chopped;

  Ld06Decoder at_once;
  at_once.feed(bytes, [&](const Ld06Frame& frame, std::size_t after) {
    require(after < size);
    whole.push_back(frame);
  });
  require(at_once.stats().bytes == size);
  require_accounted(at_once);

  Ld06Decoder in_parts;
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 61U);
    in_parts.feed(bytes.subspan(at, part), [&](const Ld06Frame& frame, std::size_t) { chopped.push_back(frame); });
    at += part;
  }
  require(in_parts.stats() == at_once.stats());
  require(whole == chopped);

  struct Assembly final : SweepSink {
    void on_sweep(const Sweep& sweep, std::size_t) override {
      require(sweep.since_last >= nacelle::Duration{} && sweep.since_last <= std::chrono::milliseconds{1001});
      // The device's clock decides how late the packet is: also late by more than a turn.
      now += sweep.since_last / 4;
      assembler.add(sweep, now, require_scan);
    }
    ScanAssembler assembler{{}};
    nacelle::MonotonicTime now{};
  } assembly;
  LdProtocol protocol{4500};
  protocol.feed(bytes, assembly);
  require(assembly.assembler.stats().points == 12 * whole.size());
  const LineStats line = protocol.stats();
  require(line.bytes == line.framed_bytes + line.skipped_bytes + protocol.pending());
  in_parts.restart();
  require(in_parts.pending() == 0);
  require_accounted(in_parts);
  return 0;
}
