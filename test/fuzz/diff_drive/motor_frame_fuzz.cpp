// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/motor_frame.hpp"
#include "framing_laws.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle::diff_drive;
  hold_laws<MotorFrameDecoder, MotorFrameState>(
      {data, size}, [](const auto& stats) { return stats.state_bytes + stats.other_bytes + stats.lost_bytes; });
  return 0;
}
