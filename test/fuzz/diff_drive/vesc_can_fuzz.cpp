// SPDX-License-Identifier: Apache-2.0
#include "can_laws.hpp"
#include "diff_drive/protocol/vesc_can.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle::diff_drive;
  hold_laws<VescCanDecoder, VescReport>(data, size);
  return 0;
}
