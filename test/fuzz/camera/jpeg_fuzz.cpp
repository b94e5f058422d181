// SPDX-License-Identifier: Apache-2.0
// Any bytes as a JPEG frame: nothing crashes or writes outside, the decoder stays fit for the next frame, and what it calls
// good it decodes to the same picture again.
#include <cstdlib>
#include <vector>

#include "camera/protocol/jpeg_decoder.hpp"
#include "nacelle/base/bytes.hpp"

namespace {
void require(bool holds) {
  if (!holds) std::abort();
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using nacelle::camera::JpegColours;
  static nacelle::camera::JpegDecoder decoder;  // one for all inputs, as in a stream
  constexpr std::uint32_t kWidth = 32, kHeight = 16;
  constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;
  // Of exactly the promised size, so that the address sanitizer sees the first byte too many.
  std::vector<std::uint8_t> first(kPixels * 3), second(first.size()), mono(kPixels);
  const bool good = decoder.decode({data, size}, kWidth, kHeight, JpegColours::Rgb, first).has_value();
  if (good) {
    require(decoder.decode({data, size}, kWidth, kHeight, JpegColours::Rgb, second).has_value());
    require(first == second);
  }
  static_cast<void>(decoder.decode({data, size}, kWidth, kHeight, JpegColours::Mono, mono));
  return 0;
}
