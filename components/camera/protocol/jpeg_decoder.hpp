// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::camera {

/// Why a JPEG frame was refused. Nothing of `out` may be used then.
enum class JpegFault : std::uint8_t {
  Corrupt,     ///< Not a JPEG, or damaged so that decoding stopped.
  Damaged,     ///< Decoded to the end, but parts are missing or guessed (a torn USB transfer).
  WrongSize,   ///< The picture has other sides than the stream was negotiated with, or `out` is too small.
  Unsupported  ///< Progressive, arithmetic-coded or many-scan: no camera sends these, and they cost without a bound.
};
[[nodiscard]] const char* to_text(JpegFault fault);

enum class JpegColours : std::uint8_t { Rgb, Bgr, Mono };

/// Decodes the frames of one MJPEG stream with libjpeg-turbo.
///
/// Bytes are treated as hostile. Frames without Huffman tables (many MJPEG cameras) are decoded with the standard ones;
/// nothing is taken from the frame before.
/// Threads:   one at a time.
/// Allocates: in the first frames of a size; nothing afterwards (libjpeg's per-frame memory is an arena that is kept).
class JpegDecoder {
 public:
  /// What one frame may take of memory beside its output.
  static constexpr std::size_t kMostWorkingBytes = std::size_t{64} << 20U;

  JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;
  ~JpegDecoder();

  /// Decodes to three bytes (Mono: one) per pixel without padding.
  [[nodiscard]] Result<void, JpegFault> decode(ByteView jpeg, std::uint32_t width, std::uint32_t height, JpegColours to,
                                               ByteSpan out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nacelle::camera
