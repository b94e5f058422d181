// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/rectification.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core/matx.hpp>

namespace nacelle::image_proc {
namespace {

struct Distortion {
  double k1, k2, p1, p2, k3, k4, k5, k6;
};

// A point of the plane one metre ahead, as the lens shows it.
SourcePoint distorted(const Distortion& d, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = (1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3))) / (1 + r2 * (d.k4 + r2 * (d.k5 + r2 * d.k6)));
  return {x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x),
          y * radial + d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y};
}

template <typename Numbers>
bool all_finite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); });
}

Result<Distortion, CalibrationFault> distortion_of(const sensor_msgs::msg::CameraInfo& info) {
  std::size_t most = 0;
  if (info.distortion_model == "plumb_bob") most = 5;
  if (info.distortion_model == "rational_polynomial") most = 8;
  if (most == 0) return err(CalibrationFault::UnknownModel);
  if (info.d.size() > most || !all_finite(info.d)) return err(CalibrationFault::BadNumbers);
  std::array<double, 8> d{};
  std::copy(info.d.begin(), info.d.end(), d.begin());
  return Distortion{d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
}

// From pixels of the rectified picture to rays of the camera: (P' R)^-1, where P' is the left part of P.
Result<cv::Matx33d, CalibrationFault> ray_of_pixel(const sensor_msgs::msg::CameraInfo& info) {
  const auto& p = info.p;
  const cv::Matx33d projection =
      p[0] != 0 ? cv::Matx33d(p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]) : cv::Matx33d(info.k.data());
  const bool is_turned = std::any_of(info.r.begin(), info.r.end(), [](double n) { return n != 0; });
  const cv::Matx33d turned = is_turned ? projection * cv::Matx33d(info.r.data()) : projection;
  bool has_inverse = false;
  const cv::Matx33d inverse = turned.inv(cv::DECOMP_LU, &has_inverse);
  if (!has_inverse || !std::all_of(inverse.val, inverse.val + 9, [](double n) { return std::isfinite(n); }))
    return err(CalibrationFault::BadNumbers);
  return inverse;
}

}  // namespace

const char* to_text(CalibrationFault fault) {
  switch (fault) {
    case CalibrationFault::Uncalibrated: return "it has no calibration (K is 0); give the camera a camera_info_url";
    case CalibrationFault::UnknownModel: return "its distortion_model must be plumb_bob or rational_polynomial";
    case CalibrationFault::BadNumbers: return "its D, K, R or P are no calibration";
    case CalibrationFault::BadSize: return "its width and height are no size of a picture";
  }
  return "it cannot be used";
}

bool same_lens(const sensor_msgs::msg::CameraInfo& a, const sensor_msgs::msg::CameraInfo& b) {
  return a.width == b.width && a.height == b.height && a.distortion_model == b.distortion_model && a.d == b.d &&
         a.k == b.k && a.r == b.r && a.p == b.p;
}

Result<SamplingMap, CalibrationFault> rectification_map(const sensor_msgs::msg::CameraInfo& info,
                                                        Interpolation interpolation) {
  if (info.k[0] == 0) return err(CalibrationFault::Uncalibrated);
  const auto distortion = distortion_of(info);
  if (!distortion) return err(distortion.error());
  if (!all_finite(info.k) || !all_finite(info.r) || !all_finite(info.p)) return err(CalibrationFault::BadNumbers);
  if (info.width == 0 || info.height == 0 || info.width > kMostSide || info.height > kMostSide ||
      std::size_t{info.width} * info.height > kMostPixels) {
    return err(CalibrationFault::BadSize);
  }
  const auto inverse = ray_of_pixel(info);
  if (!inverse) return err(inverse.error());
  const cv::Matx33d& ray = *inverse;
  SamplingMap map{{info.width, info.height}, {info.width, info.height}};
  for (std::uint32_t v = 0; v < info.height; ++v) {
    for (std::uint32_t u = 0; u < info.width; ++u) {
      const cv::Vec3d direction = ray * cv::Vec3d(u, v, 1);
      if (!(direction[2] > 0)) continue;  // behind the camera
      const SourcePoint seen = distorted(*distortion, direction[0] / direction[2], direction[1] / direction[2]);
      // As in OpenCV's and ROS's cameras, K has no skew.
      map.set(u, v, {info.k[0] * seen.x + info.k[2], info.k[4] * seen.y + info.k[5]}, interpolation);
    }
  }
  return map;
}

}  // namespace nacelle::image_proc
