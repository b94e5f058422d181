// SPDX-License-Identifier: Apache-2.0
#include "gps/model/error_model.hpp"

#include <gtest/gtest.h>

namespace nacelle::gps {
namespace {

constexpr MonotonicTime kNow{10s};

Gga fix(std::uint8_t quality, std::optional<double> hdop) {
  Gga gga;
  gga.quality = quality;
  gga.hdop = hdop;
  return gga;
}

TEST(ErrorModel, multiplies_hdop_with_the_error_of_the_quality) {
  const ErrorModel errors;
  const auto single = errors.of(fix(1, 1.5), kNow);
  EXPECT_EQ(single.source, ErrorModel::Source::Dilution);
  EXPECT_DOUBLE_EQ(single.east_m2, 36.0);
  EXPECT_DOUBLE_EQ(single.north_m2, 36.0);
  EXPECT_DOUBLE_EQ(single.up_m2, 16.0 * 36.0);
  EXPECT_NEAR(errors.of(fix(4, 1.0), kNow).east_m2, 0.0004, 1e-12);
}

TEST(ErrorModel, takes_the_height_from_vdop) {
  ErrorModel errors;
  errors.add(Gsa{.fix = 3, .pdop = 2.0, .hdop = 1.0, .vdop = 1.75}, kNow);
  EXPECT_DOUBLE_EQ(errors.of(fix(1, 1.0), kNow).up_m2, 49.0);
  EXPECT_DOUBLE_EQ(errors.of(fix(1, 1.0), kNow + 4s).up_m2, 256.0) << "an old VDOP is another sky's";
}

TEST(ErrorModel, prefers_the_receivers_own_estimate_while_it_is_fresh) {
  ErrorModel errors;
  errors.add(Gst{.latitude_stddev_m = 2.0, .longitude_stddev_m = 3.0, .altitude_stddev_m = 5.0}, kNow);
  const auto known = errors.of(fix(1, 1.0), kNow + ErrorModel::kFresh);
  EXPECT_EQ(known.source, ErrorModel::Source::Receiver);
  EXPECT_EQ(known.north_m2, 4.0);
  EXPECT_EQ(known.east_m2, 9.0);
  EXPECT_EQ(known.up_m2, 25.0);
  EXPECT_EQ(errors.of(fix(1, 1.0), kNow + ErrorModel::kFresh + 1ns).source, ErrorModel::Source::Dilution);
  errors.restart();
  EXPECT_EQ(errors.of(fix(1, 1.0), kNow).source, ErrorModel::Source::Dilution);
}

TEST(ErrorModel, does_not_believe_an_estimate_that_was_rounded_to_nothing) {
  ErrorModel errors;
  errors.add(Gst{.latitude_stddev_m = 0.0, .longitude_stddev_m = 0.1, .altitude_stddev_m = 0.1}, kNow);
  const auto rtk = errors.of(fix(4, 1.0), kNow);
  EXPECT_EQ(rtk.source, ErrorModel::Source::Dilution);
  EXPECT_DOUBLE_EQ(rtk.north_m2, 0.02 * 0.02);
}

TEST(ErrorModel, knows_nothing_without_hdop_and_estimate) {
  ErrorModel errors;
  errors.add(Gst{.latitude_stddev_m = 2.0}, kNow);
  const auto unknown = errors.of(fix(1, std::nullopt), kNow);
  EXPECT_EQ(unknown.source, ErrorModel::Source::None);
  EXPECT_EQ(unknown.east_m2, 0.0);
}

}  // namespace
}  // namespace nacelle::gps
