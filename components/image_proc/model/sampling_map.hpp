// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "image_proc/model/picture.hpp"

namespace nacelle::image_proc {

/// How a value between pixels is found. The numbers are those of OpenCV and of image_proc's parameter `interpolation`.
enum class Interpolation : std::uint8_t { Nearest = 0, Linear = 1, Cubic = 2, Area = 3, Lanczos4 = 4 };

/// A point of the source picture. Units: pixels, the first one's centre is (0, 0).
struct SourcePoint {
  double x, y;
};

/// For each pixel of a picture that is made: where in the source picture its value is taken from.
///
/// It is computed once and applied to many pictures. OpenCV's remap() would take scratch memory for each of them.
/// Units:     points are rounded to 1/256 pixel.
/// Threads:   apply() is const: any. Allocates: in the constructor alone, 8 bytes a pixel.
class SamplingMap {
 public:
  struct Size {
    std::uint32_t width, height;
    friend bool operator==(const Size&, const Size&) = default;
  };

  /// All points are outside until they are set. Preconditions: sides from 1 to kMostSide, at most kMostPixels.
  SamplingMap(Size source, Size made);

  /// Sets where a pixel is taken from. A point beyond the outermost pixel centres, or one that is no number, is outside: black.
  void set(std::uint32_t u, std::uint32_t v, SourcePoint from, Interpolation interpolation);

  [[nodiscard]] Size source() const { return source_; }
  [[nodiscard]] Size made() const { return made_; }

  /// Makes the picture: width * height * channels bytes from `out` on. Preconditions: the picture has the source's size.
  void apply(const Picture& picture, std::uint8_t* out) const;

 private:
  struct Tap {
    std::uint16_t x, y;                ///< The pixel up and left of the point.
    std::uint16_t weight_x, weight_y;  ///< Of its right and lower neighbours: 0 to 256.
  };
  template <int kChannels>
  void apply_to(const Picture& picture, std::uint8_t* out) const;

  Size source_, made_;
  std::vector<Tap> taps_;
};

}  // namespace nacelle::image_proc
