// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "camera/model/pixel_format.hpp"

namespace nacelle::camera {

/// Returns the name that the kernel's graphics drivers, and libcamera, have for a layout of V4L2, and back.
///
/// They name colours by the bits of a little-endian number: their RGB888 has blue in the first byte. Other names are the same.
/// Source: kernel, include/uapi/drm/drm_fourcc.h; libcamera 0.4, src/libcamera/v4l2_pixelformat.cpp.
[[nodiscard]] constexpr std::uint32_t drm_of(FourCc v4l2) {
  if (v4l2 == kBgr24) return fourcc("RG24");
  if (v4l2 == kRgb24) return fourcc("BG24");
  if (v4l2 == kGrey) return fourcc("R8  ");
  return v4l2;
}
[[nodiscard]] constexpr FourCc v4l2_of(std::uint32_t drm) {
  for (const FourCc v4l2 : {kBgr24, kRgb24, kGrey}) {
    if (drm_of(v4l2) == drm) return v4l2;
  }
  return drm;
}

/// Whether frames of that layout come from the sensor unprocessed.
[[nodiscard]] constexpr bool is_bayer(FourCc v4l2) {
  return v4l2 == fourcc("BA81") || v4l2 == fourcc("GBRG") || v4l2 == fourcc("GRBG") || v4l2 == fourcc("RGGB");
}

}  // namespace nacelle::camera
