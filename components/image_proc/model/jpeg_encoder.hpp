// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "image_proc/model/picture.hpp"
#include "nacelle/base/buffer.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::image_proc {

/// Why a picture was not encoded. The output's bytes are not to be used then.
enum class EncodeFault : std::uint8_t {
  OutOfMemory,  ///< The output, or libjpeg's own memory, could not grow.
  Refused       ///< libjpeg does not take the picture: no encoding of plain_encodings(), say.
};
[[nodiscard]] const char* to_text(EncodeFault fault);

/// Encodes pictures as baseline JPEG with libjpeg-turbo: 4:2:0, standard tables, grey for mono8. Alpha is left out.
///
/// Threads:   one at a time.
/// Allocates: at the first picture of a size, and if the output has too little capacity. libjpeg's memory of a picture is
///            kept for the next one.
class JpegEncoder {
 public:
  JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
  ~JpegEncoder();

  /// Replaces the output. `quality` is libjpeg's, 1 to 100.
  [[nodiscard]] Result<void, EncodeFault> encode(const Picture& picture, int quality, Buffer<std::uint8_t>& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nacelle::image_proc
