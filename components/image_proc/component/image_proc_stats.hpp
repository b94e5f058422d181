// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::image_proc {

/// What became of the images: images == made + unread + refused + waiting + no_message.
struct ImageProcStats {
  std::uint64_t images{};
  std::uint64_t made{};        ///< A result was published, or two of them.
  std::uint64_t unread{};      ///< Left out, since the results have no reader.
  std::uint64_t refused{};     ///< Encodings, sizes and calibrations that cannot be used.
  std::uint64_t waiting{};     ///< Came before the first camera_info that they need.
  std::uint64_t no_message{};  ///< Every pooled message was still being read.
};

}  // namespace nacelle::image_proc
