// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/vesc_frame.hpp"
#include "framing_laws.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle::diff_drive;
  hold_laws<VescDecoder, VescValues>(
      {data, size}, [](const auto& stats) { return stats.value_bytes + stats.other_bytes + stats.lost_bytes; });
  return 0;
}
