// SPDX-License-Identifier: Apache-2.0
#include "detector/model/disc_detector.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace nacelle::detector {
namespace {

constexpr double kPi = 3.141592653589793;

}  // namespace

// After this, mask_ is 255 where the colour fits, decimation times smaller than the picture in both directions.
void DiscDetector::threshold(const ImageView& image) {
  const int n = settings_.decimation;
  const cv::Size size{image.pixels.cols / n, image.pixels.rows / n};
  // Whole multiples only: with any rest, resize() would scale by a little more or less than n.
  const cv::Mat pixels = image.pixels(cv::Rect(0, 0, size.width * n, size.height * n));
  const cv::Scalar least(settings_.hue_min, settings_.saturation_min, settings_.value_min);
  const cv::Scalar most(settings_.hue_max, 255, settings_.value_max);
  if (image.layout == Layout::Mono8) {
    cv::resize(pixels, small_, size, 0, 0, cv::INTER_NEAREST);
    cv::inRange(small_, cv::Scalar(settings_.value_min), cv::Scalar(settings_.value_max), mask_);
    return;
  }
  if (image.layout == Layout::Yuyv) {
    // Rows first: two pixels share their colour, so columns can only be left out once each pixel has its own.
    // cvtColor() takes even widths only; an odd last column is worth nothing here.
    const cv::Mat pairs = pixels(cv::Rect(0, 0, pixels.cols - pixels.cols % 2, pixels.rows));
    if (pairs.cols == 0) {
      mask_ = cv::Mat::zeros(size, CV_8UC1);
      return;
    }
    cv::resize(pairs, colour_, {pairs.cols, size.height}, 0, 0, cv::INTER_NEAREST);
    cv::cvtColor(colour_, small_, cv::COLOR_YUV2RGB_YUY2);
    cv::resize(small_, colour_, size, 0, 0, cv::INTER_NEAREST);
  } else {
    cv::resize(pixels, colour_, size, 0, 0, cv::INTER_NEAREST);
  }
  cv::cvtColor(colour_, hsv_, image.layout == Layout::Bgr8 ? cv::COLOR_BGR2HSV : cv::COLOR_RGB2HSV);
  if (settings_.hue_min <= settings_.hue_max) {
    cv::inRange(hsv_, least, most, mask_);
    return;
  }
  cv::inRange(hsv_, least, cv::Scalar(179, 255, settings_.value_max), mask_);
  cv::inRange(hsv_, cv::Scalar(0, settings_.saturation_min, settings_.value_min), most, second_mask_);
  cv::bitwise_or(mask_, second_mask_, mask_);
}

const std::vector<Disc>& DiscDetector::find(const ImageView& image) {
  found_.clear();
  const int n = settings_.decimation;
  if (image.pixels.cols < n || image.pixels.rows < n) return found_;
  threshold(image);
  // Outlines only: labelling every pixel takes twenty times as long.
  cv::findContours(mask_, outlines_, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  for (const auto& outline : outlines_) {
    const cv::Moments moments = cv::moments(outline);
    if (moments.m00 <= 0) continue;  // a line
    // Pick's theorem: the pixels of a polygon through pixel centres are its area, half its edge, and one.
    const double pixels = moments.m00 + 0.5 * static_cast<double>(outline.size()) + 1;
    const double area_px = pixels * n * n;
    if (area_px < settings_.min_area_px) continue;
    const cv::Rect box = cv::boundingRect(outline);
    if (box.x == 0 || box.y == 0 || box.x + box.width == mask_.cols || box.y + box.height == mask_.rows) continue;
    // A disc is as wide as high (but for a pixel of rounding), and fills its bounding ellipse.
    const double slimness = std::min(1.0, (std::min(box.width, box.height) + 1.0) / std::max(box.width, box.height));
    const double filled = pixels / (0.25 * kPi * box.width * box.height);
    const double roundness = slimness * std::min(filled, 1.0 / filled);
    if (roundness < settings_.min_roundness) continue;
    found_.push_back(
        {moments.m10 / moments.m00 * n, moments.m01 / moments.m00 * n, std::sqrt(area_px / kPi), roundness});
  }
  std::sort(found_.begin(), found_.end(), [](const Disc& a, const Disc& b) { return a.radius_px > b.radius_px; });
  if (found_.size() > settings_.most) found_.resize(settings_.most);
  return found_;
}

}  // namespace nacelle::detector
