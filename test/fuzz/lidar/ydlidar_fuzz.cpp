// SPDX-License-Identifier: Apache-2.0
// Any bytes as the packets of a YDLIDAR, with and without intensities, and as its answers: nothing crashes, every byte is accounted
// for, the chopping changes nothing, and every sweep and scan keeps its promises.
#include <algorithm>
#include <memory>

#include "lidar/protocol/ydlidar_protocol.hpp"
#include "sweep_laws.hpp"

using namespace nacelle::lidar;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  for (const bool with_intensities : {false, true}) {
    hold_the_laws_of_bytes(bytes, [&] {
      return std::make_unique<YdlidarProtocol>(
          YdlidarProtocol::Settings{.points_per_second = 5000, .has_intensities = with_intensities});
    });
  }
  YdlidarProtocol commanded{{.points_per_second = 9000, .is_commanded = true}};
  SweepLaws beams;
  nacelle::MonotonicTime now{std::chrono::seconds{1}};
  for (std::size_t at = 0; at < size; at += 16) {
    commanded.want(at % 160 >= 48);
    commanded.feed(bytes.subspan(at, std::min<std::size_t>(16, size - at)), beams);
    now += std::chrono::milliseconds{data[at]};
    for (int i = 0; i < 20 && commanded.next_action(now); ++i) require(i < 19);  // it comes to an end
  }
  const LineStats s = commanded.stats();
  require(s.bytes == s.framed_bytes + s.skipped_bytes + commanded.pending());
  return 0;
}
