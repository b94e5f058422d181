// SPDX-License-Identifier: Apache-2.0
// Any bytes as each stream of an RPLIDAR, and as its answers: nothing crashes, every byte is accounted for, the chopping changes
// nothing, and every sweep and scan keeps its promises.
#include <algorithm>
#include <memory>

#include "lidar/protocol/rplidar_protocol.hpp"
#include "sweep_laws.hpp"

using namespace nacelle::lidar;

namespace {

/// One stream, without the conversation before it.
class Stream final : public LidarProtocol {
 public:
  explicit Stream(RplidarAnswer type) {
    decoder_.expect(type);
    sweeps_.begin(std::chrono::microseconds{125});
  }
  void feed(nacelle::ByteView bytes, SweepSink& sink) override {
    decoder_.feed(bytes, [&](const RplidarPacket& packet, std::size_t after) {
      if (is_stream(packet.type)) sweeps_.take(packet, after, sink);
    });
  }
  void restart() override { decoder_.restart(); }
  [[nodiscard]] LineStats stats() const override { return decoder_.stats(); }
  [[nodiscard]] std::size_t pending() const override { return decoder_.pending(); }

 private:
  RplidarDecoder decoder_;
  RplidarSweeps sweeps_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  for (const RplidarAnswer type : {RplidarAnswer::Nodes, RplidarAnswer::Capsules, RplidarAnswer::UltraCapsules,
                                   RplidarAnswer::DenseCapsules, RplidarAnswer::Configuration})
    hold_the_laws_of_bytes(bytes, [&] { return std::make_unique<Stream>(type); });

  // A device that answers with these bytes whatever it is asked.
  for (const char* mode : {"", "Boost"}) {
    RplidarProtocol protocol{mode};
    SweepLaws beams;
    nacelle::MonotonicTime now{std::chrono::seconds{1}};
    for (std::size_t at = 0; at < size; at += 16) {
      protocol.want(at % 160 >= 48);
      protocol.feed(bytes.subspan(at, std::min<std::size_t>(16, size - at)), beams);
      now += std::chrono::milliseconds{data[at]};
      for (int i = 0; i < 20 && protocol.next_action(now); ++i) require(i < 19);  // it comes to an end
    }
    const LineStats s = protocol.stats();
    require(s.bytes == s.framed_bytes + s.skipped_bytes + protocol.pending());
    static_cast<void>(protocol.identity());
  }
  return 0;
}
