// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>

#include "any_bytes.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  nacelle::launch::read_any_bytes({reinterpret_cast<const char*>(data), size}, "fuzz.launch.xml");
  return 0;
}
