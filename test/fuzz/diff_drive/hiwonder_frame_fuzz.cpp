// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/hiwonder_frame.hpp"
#include "framing_laws.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle::diff_drive;
  hold_laws<HiwonderDecoder, HiwonderReport>({data, size},
                                             [](const auto& stats) { return stats.frame_bytes + stats.lost_bytes; });
  return 0;
}
