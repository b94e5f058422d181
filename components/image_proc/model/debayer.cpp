// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/debayer.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>

namespace nacelle::image_proc {
namespace {

struct Codes {
  int bgr, rgb, mono;
};

Codes codes_of(std::string_view mosaic) {
  if (mosaic == "bayer_rggb8") return {cv::COLOR_BayerBG2BGR, cv::COLOR_BayerBG2RGB, cv::COLOR_BayerBG2GRAY};
  if (mosaic == "bayer_bggr8") return {cv::COLOR_BayerRG2BGR, cv::COLOR_BayerRG2RGB, cv::COLOR_BayerRG2GRAY};
  if (mosaic == "bayer_gbrg8") return {cv::COLOR_BayerGR2BGR, cv::COLOR_BayerGR2RGB, cv::COLOR_BayerGR2GRAY};
  return {cv::COLOR_BayerGB2BGR, cv::COLOR_BayerGB2RGB, cv::COLOR_BayerGB2GRAY};
}

}  // namespace

void debayer(const Picture& mosaic, const Encoding& to, std::uint8_t* out) {
  const Codes codes = codes_of(mosaic.encoding.name);
  const int rows = static_cast<int>(mosaic.height), cols = static_cast<int>(mosaic.width);
  // OpenCV has no read-only matrix; it does not write into its source.
  const cv::Mat from(rows, cols, CV_8UC1, const_cast<std::uint8_t*>(mosaic.pixels), mosaic.step);
  cv::Mat made(rows, cols, CV_8UC(to.channels), out);
  cv::cvtColor(from, made, to.channels == 1 ? codes.mono : to.name == "rgb8" ? codes.rgb : codes.bgr);
}

}  // namespace nacelle::image_proc
