// SPDX-License-Identifier: Apache-2.0
#include "gps/model/error_model.hpp"

namespace nacelle::gps {
namespace {

double square(double value) { return value * value; }

/// A receiver with one decimal says 0.0 of centimetres: that is no estimate.
bool is_estimate(const std::optional<double>& stddev_m) { return stddev_m && *stddev_m > 0.0; }

}  // namespace

void ErrorModel::add(const Gst& gst, MonotonicTime now) {
  gst_ = gst;
  gst_at_ = now;
}

void ErrorModel::add(const Gsa& gsa, MonotonicTime now) {
  vdop_ = gsa.vdop;
  vdop_at_ = now;
}

void ErrorModel::restart() {
  gst_.reset();
  vdop_.reset();
}

ErrorModel::Variances ErrorModel::of(const Gga& gga, MonotonicTime now) const {
  const bool has_gst = gst_ && now - gst_at_ <= kFresh && is_estimate(gst_->latitude_stddev_m) &&
                       is_estimate(gst_->longitude_stddev_m) && is_estimate(gst_->altitude_stddev_m);
  if (has_gst) {
    return {square(*gst_->longitude_stddev_m), square(*gst_->latitude_stddev_m), square(*gst_->altitude_stddev_m),
            Source::Receiver};
  }
  if (!gga.hdop) return {};
  const double error_m = errors_m_[gga.quality];
  const double horizontal_m2 = square(*gga.hdop * error_m);
  const bool has_vdop = vdop_ && now - vdop_at_ <= kFresh;
  return {horizontal_m2, horizontal_m2, has_vdop ? square(*vdop_ * error_m) : 16.0 * horizontal_m2, Source::Dilution};
}

}  // namespace nacelle::gps
