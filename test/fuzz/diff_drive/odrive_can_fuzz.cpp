// SPDX-License-Identifier: Apache-2.0
#include "can_laws.hpp"
#include "diff_drive/protocol/odrive_can.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle::diff_drive;
  hold_laws<OdriveCanDecoder, OdriveReport>(data, size);
  return 0;
}
