// SPDX-License-Identifier: Apache-2.0
#include "detector/model/lens.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::detector {
namespace {

constexpr int kSteps = 20;  // at 1e-9 for lenses up to 120 degrees; most need five

}  // namespace

std::optional<Lens> Lens::from(const sensor_msgs::msg::CameraInfo& info) {
  Lens lens;
  lens.fx_px_ = info.k[0];
  lens.fy_px_ = info.k[4];
  lens.cu_px_ = info.k[2];
  lens.cv_px_ = info.k[5];
  const auto sound = [](double focal) { return std::isfinite(focal) && focal > 0; };
  if (!sound(lens.fx_px_) || !sound(lens.fy_px_) || !std::isfinite(lens.cu_px_) || !std::isfinite(lens.cv_px_))
    return std::nullopt;
  lens.model_ = info.distortion_model == "equidistant" ? Model::Equidistant : Model::Brown;
  for (std::size_t i = 0; i < std::min(info.d.size(), lens.d_.size()); ++i) {
    if (!std::isfinite(info.d[i])) return std::nullopt;
    lens.d_[i] = info.d[i];
    lens.distorts_ = lens.distorts_ || info.d[i] != 0;
  }
  if (lens.model_ == Model::Equidistant) lens.distorts_ = true;  // also without coefficients it is no pinhole
  return lens;
}

Lens Lens::assumed(std::uint32_t width, std::uint32_t height, double horizontal_view_rad) {
  Lens lens;
  lens.fx_px_ = lens.fy_px_ = 0.5 * width / std::tan(0.5 * horizontal_view_rad);
  lens.cu_px_ = 0.5 * (width - 1.0);
  lens.cv_px_ = 0.5 * (height - 1.0);
  return lens;
}

double Lens::focal_px() const { return std::sqrt(fx_px_ * fy_px_); }

Direction Lens::direction_of(double u_px, double v_px) const {
  const Direction seen{(u_px - cu_px_) / fx_px_, (v_px - cv_px_) / fy_px_};
  if (!distorts_) return seen;
  if (model_ == Model::Equidistant) {
    const double seen_rad = std::hypot(seen.x, seen.y);
    if (seen_rad < 1e-9) return seen;
    double angle_rad = seen_rad;
    for (int step = 0; step < kSteps; ++step) {
      const double a2 = angle_rad * angle_rad;
      angle_rad = seen_rad / (1 + a2 * (d_[0] + a2 * (d_[1] + a2 * (d_[2] + a2 * d_[3]))));
    }
    const double scale = std::tan(std::min(angle_rad, 1.5)) / seen_rad;
    return {seen.x * scale, seen.y * scale};
  }
  Direction ideal = seen;
  for (int step = 0; step < kSteps; ++step) {
    const double r2 = ideal.x * ideal.x + ideal.y * ideal.y;
    const double radial =
        (1 + r2 * (d_[0] + r2 * (d_[1] + r2 * d_[4]))) / (1 + r2 * (d_[5] + r2 * (d_[6] + r2 * d_[7])));
    const double dx = 2 * d_[2] * ideal.x * ideal.y + d_[3] * (r2 + 2 * ideal.x * ideal.x);
    const double dy = d_[2] * (r2 + 2 * ideal.y * ideal.y) + 2 * d_[3] * ideal.x * ideal.y;
    if (!(radial > 0.01)) break;  // beyond the lens's edge the model folds back
    ideal = {(seen.x - dx) / radial, (seen.y - dy) / radial};
  }
  return ideal;
}

}  // namespace nacelle::detector
