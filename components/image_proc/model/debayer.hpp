// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "image_proc/model/picture.hpp"

namespace nacelle::image_proc {

/// Smallest side of a mosaic that has a pixel with all its neighbours.
inline constexpr std::uint32_t kLeastMosaicSide = 4;

/// Makes rgb8, bgr8 or mono8 of a mosaic: width * height * channels bytes from `out` on.
///
/// A colour that a pixel lacks is the mean of the neighbours that have it.
/// Pixels at the edge are copies of their inner neighbours. Mono is the luma of the colours.
/// Preconditions: picture_of(mosaic_encodings(), kLeastMosaicSide) made the mosaic.
/// Threads:   any. Allocates: nothing if OpenCV has one thread (cv::setNumThreads(1)).
/// Source:    OpenCV's cvtColor(); ROS names a mosaic after the first two pixels of its first two rows, OpenCV after those of
///            its second row and column. Its edge-aware method reads a byte outside of each row.
void debayer(const Picture& mosaic, const Encoding& to, std::uint8_t* out);

}  // namespace nacelle::image_proc
