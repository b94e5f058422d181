// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "detector/model/image_view.hpp"

namespace nacelle::detector {

/// What to look for. Hues are OpenCV's: degrees / 2, 0 to 179. The defaults are an orange disc.
struct DiscSettings {
  int hue_min = 5, hue_max = 25;  ///< Through 0 if hue_min is the larger: 170 to 10 is red.
  int saturation_min = 120;
  int value_min = 80, value_max = 255;  ///< Of brightness; all that counts in mono8.
  double min_area_px = 200;             ///< Of the whole picture's pixels.
  double min_roundness = 0.85;          ///< Of the share of its bounding ellipse that it fills; 1 is a disc.
  int decimation = 2;                   ///< Only every n-th row and column is looked at. 1 to 8.
  std::size_t most = 8;                 ///< Discs of one picture.
};

/// A disc in the picture. Units: pixels of the whole picture, the first one's centre is (0, 0).
struct Disc {
  double u_px, v_px, radius_px;
  double roundness;
};

/// Finds discs of one colour: threshold in hue, saturation and brightness, outlines, roundness. Holes do not count.
///
/// Areas that touch the edge of the picture are left out: their size is unknown.
/// Source:    the disc's radius is that of a circle of the same area, which averages over all pixels.
/// Threads:   one at a time. Allocates: OpenCV does.
class DiscDetector {
 public:
  explicit DiscDetector(const DiscSettings& settings) : settings_(settings) {}

  /// The largest first. The picture is not changed. The result is valid until the next call.
  [[nodiscard]] const std::vector<Disc>& find(const ImageView& image);

 private:
  void threshold(const ImageView& image);

  const DiscSettings settings_;
  cv::Mat small_, colour_, hsv_, mask_, second_mask_;  // kept for their memory
  std::vector<std::vector<cv::Point>> outlines_;
  std::vector<Disc> found_;
};

}  // namespace nacelle::detector
