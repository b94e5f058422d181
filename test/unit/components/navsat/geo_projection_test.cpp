// SPDX-License-Identifier: Apache-2.0
#include "navsat/model/geo_projection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/allocation_guard.hpp"

namespace nacelle::navsat {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// Of the origin's latitude, sphere enough for a tolerance.
double metres_between(const GeoPoint& a, const GeoPoint& b) {
  constexpr double kMetresPerDegree = 111'320.0;
  const double north_m = (a.latitude_deg - b.latitude_deg) * kMetresPerDegree;
  const double turn_deg = std::remainder(a.longitude_deg - b.longitude_deg, 360.0);
  const double east_m = turn_deg * kMetresPerDegree * std::cos(a.latitude_deg / kDegPerRad);
  return std::hypot(north_m, east_m, a.altitude_m - b.altitude_m);
}

struct Published {
  GeoPoint point;
  double x_m, y_m;
  UtmZone zone;
  double convergence_deg, tolerance_m;
};

// Source: robot_localization, test/test_navsat_conversions.cpp (eastings, northings, zones, convergences).
constexpr std::array kRobotLocalization{
    Published{{51.423964, 5.494271, 0.0}, 673409.989, 5699924.709, {31, true}, 1.950, 0.01},
    Published{{-43.530955, 172.636645, 0.0}, 632246.802, 5178919.718, {59, false}, -1.127, 0.01}};

TEST(GeoProjection, utm_gives_robot_localizations_published_values) {
  for (const Published& published : kRobotLocalization) {
    const auto utm = GeoProjection::utm(published.point);
    ASSERT_TRUE(utm);
    const auto p = utm->forward(published.point);
    ASSERT_TRUE(p);
    EXPECT_NEAR(p->x(), published.x_m, published.tolerance_m);
    EXPECT_NEAR(p->y(), published.y_m, published.tolerance_m);
    EXPECT_EQ(*utm->zone(), published.zone);
    EXPECT_NEAR(utm->convergence_rad() * kDegPerRad, published.convergence_deg, 0.001);
  }
}

// Source: GeographicLib, GeoConvert(1), EXAMPLES: 38SMB4488 is 33.33424 44.40363, and 38n 444500 3688500.
TEST(GeoProjection, utm_gives_the_example_of_geo_convert) {
  const GeoPoint point{33.33424, 44.40363, 0.0};
  const auto utm = GeoProjection::utm(point);
  ASSERT_TRUE(utm);
  EXPECT_EQ(to_text(*utm->zone()), "38 north");
  const auto p = utm->forward(point);
  ASSERT_TRUE(p);
  EXPECT_NEAR(p->x(), 444500.0, 0.6) << "the example has five decimals of a degree";
  EXPECT_NEAR(p->y(), 3688500.0, 0.6);
}

// Source: GeographicLib, CartConvert(1), EXAMPLES: 33.3 44.4 6000 from the origin 33 44 20 is 37288.97 33374.29 5783.64.
TEST(GeoProjection, a_local_plane_gives_the_example_of_cart_convert) {
  const auto local = GeoProjection::local({33.0, 44.0, 20.0});
  ASSERT_TRUE(local);
  const auto p = local->forward({33.3, 44.4, 6000.0});
  ASSERT_TRUE(p);
  EXPECT_NEAR(p->x(), 37288.97, 0.005);
  EXPECT_NEAR(p->y(), 33374.29, 0.005);
  EXPECT_EQ(p->z(), 6000.0) << "z is the altitude";
  EXPECT_EQ(local->convergence_rad(), 0.0);
  EXPECT_FALSE(local->zone());
}

// Source: Snyder, Map Projections - A Working Manual (1987), eq. 8-9 for small distances from the central meridian.
TEST(GeoProjection, the_convergence_is_the_longitudes_difference_times_the_sine_of_the_latitude) {
  for (const double longitude_deg : {6.5, 8.9, 9.0, 9.1, 11.5}) {
    for (const double latitude_deg : {-60.0, -1.0, 0.0, 30.0, 60.0}) {
      const auto utm = GeoProjection::utm({latitude_deg, longitude_deg, 0.0});
      ASSERT_TRUE(utm);
      const double expected_deg = (longitude_deg - 9.0) * std::sin(latitude_deg / kDegPerRad);
      EXPECT_NEAR(utm->convergence_rad() * kDegPerRad, expected_deg, 0.002) << latitude_deg << " " << longitude_deg;
    }
  }
}

TEST(GeoProjection, what_goes_forward_comes_back_everywhere) {
  const unsigned seed = 19;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> latitude{-89.9, 89.9}, longitude{-180.0, 180.0}, offset_deg{-0.2, 0.2},
      altitude_m{-400.0, 9000.0};
  for (int i = 0; i < 2000; ++i) {
    const GeoPoint datum{latitude(random), longitude(random), altitude_m(random)};
    const GeoPoint point{std::clamp(datum.latitude_deg + offset_deg(random), -90.0, 90.0),
                         datum.longitude_deg + offset_deg(random), altitude_m(random)};
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", " << datum.latitude_deg << " " << datum.longitude_deg);
    for (const auto& projection : {GeoProjection::utm(datum), GeoProjection::local(datum)}) {
      ASSERT_TRUE(projection);
      const auto p = projection->forward(point);
      ASSERT_TRUE(p);
      const auto back = projection->reverse(*p);
      ASSERT_TRUE(back);
      EXPECT_LT(metres_between(*back, point), 1e-6);
    }
  }
}

TEST(GeoProjection, a_local_plane_keeps_altitudes_a_thousand_kilometres_away) {
  const auto local = GeoProjection::local({48.0, 11.0, 500.0});
  ASSERT_TRUE(local);
  const GeoPoint far{40.0, 3.0, 1234.5};
  const auto back = local->reverse(*local->forward(far));
  ASSERT_TRUE(back);
  EXPECT_LT(metres_between(*back, far), 1e-6);
}

TEST(GeoProjection, a_robot_that_crosses_the_border_of_a_zone_does_not_jump) {
  // The border between zones 31 and 32 is at 6 degrees east.
  const GeoPoint west{50.0, 5.99999, 100.0}, east{50.0, 6.00001, 100.0};
  const auto utm = GeoProjection::utm(west);
  ASSERT_TRUE(utm);
  const auto a = utm->forward(west), b = utm->forward(east);
  ASSERT_TRUE(a);
  ASSERT_TRUE(b);
  EXPECT_NEAR((*b - *a).norm(), 1.43, 0.02) << "0.00002 degrees at 50 degrees north";
  EXPECT_FALSE(utm->is_in_another_zone(west));
  EXPECT_TRUE(utm->is_in_another_zone(east));
  EXPECT_NEAR(utm->reverse(*b)->longitude_deg, east.longitude_deg, 1e-11);
}

TEST(GeoProjection, a_robot_that_crosses_the_equator_does_not_jump) {
  const GeoPoint north{0.00001, 9.0, 0.0}, south{-0.00001, 9.0, 0.0};
  for (const auto& [datum, other] : {std::pair{north, south}, {south, north}}) {
    const auto utm = GeoProjection::utm(datum);
    ASSERT_TRUE(utm);
    const auto a = utm->forward(datum), b = utm->forward(other);
    ASSERT_TRUE(b);
    EXPECT_NEAR((*b - *a).norm(), 2.21, 0.01);
    EXPECT_NEAR(utm->reverse(*b)->latitude_deg, other.latitude_deg, 1e-11);
  }
}

TEST(GeoProjection, the_poles_have_a_grid_too) {
  const auto polar = GeoProjection::utm({89.99, 30.0, 0.0});
  ASSERT_TRUE(polar);
  EXPECT_EQ(polar->zone()->number, 0);
  const auto p = polar->forward({89.999, -120.0, 3.0});
  ASSERT_TRUE(p);
  EXPECT_LT(metres_between(*polar->reverse(*p), {89.999, -120.0, 3.0}), 1e-6);
}

TEST(GeoProjection, a_zone_that_the_user_chose_holds) {
  const auto zone = read_utm_zone("32U");
  ASSERT_TRUE(zone);
  EXPECT_EQ(*zone, (UtmZone{32, true}));
  const auto utm = GeoProjection::utm({51.423964, 5.494271, 0.0}, zone);
  ASSERT_TRUE(utm);
  EXPECT_EQ(utm->zone()->number, 32);
  EXPECT_LT(utm->forward({51.423964, 5.494271, 0.0})->x(), 500'000.0) << "west of zone 32's meridian";
  EXPECT_LT(utm->convergence_rad(), 0.0);
}

TEST(GeoProjection, a_zone_is_read_from_grid_references) {
  EXPECT_EQ(read_utm_zone("38SMB4488"), (UtmZone{38, true}));
  EXPECT_EQ(read_utm_zone("59G"), (UtmZone{59, false}));
  EXPECT_EQ(read_utm_zone("Z"), (UtmZone{0, true})) << "around the north pole";
  for (const char* const text : {"", "31", "U31", "61U", "0U", "31I", "INV", "31UXX", "31u\n", "north"})
    EXPECT_FALSE(read_utm_zone(text)) << text;
}

TEST(GeoProjection, takes_nothing_from_the_heap_per_point) {
  const GeoPoint datum{50.0, 9.0, 100.0};
  for (const auto& projection : {GeoProjection::utm(datum), GeoProjection::local(datum)}) {
    const test::AllocationGuard guard;
    for (int i = 0; i < 100; ++i) {
      const auto p = projection->forward({50.0 + 1e-5 * i, 9.0, 100.0});
      EXPECT_TRUE(projection->reverse(*p));
      EXPECT_FALSE(projection->is_in_another_zone({50.0, 9.0, 0.0}));
    }
    EXPECT_EQ(guard.count(), 0U);
  }
}

TEST(GeoProjection, refuses_what_is_no_place_and_what_it_does_not_reach) {
  const double nan = std::nan("");
  EXPECT_EQ(GeoProjection::utm({nan, 0.0, 0.0}).error(), GeoFault::NotFinite);
  EXPECT_EQ(GeoProjection::local({90.1, 0.0, 0.0}).error(), GeoFault::OutOfRange);
  EXPECT_EQ(GeoProjection::local({0.0, 1e9, 0.0}).error(), GeoFault::OutOfRange);
  EXPECT_EQ(GeoProjection::utm({51.0, 5.0, 0.0}, UtmZone{59, false}).error(), GeoFault::TooFar);
  for (const auto& projection : {GeoProjection::utm({50.0, 9.0, 0.0}), GeoProjection::local({50.0, 9.0, 0.0})}) {
    ASSERT_TRUE(projection);
    EXPECT_EQ(projection->forward({-50.0, -171.0, 0.0}).error(), GeoFault::TooFar) << "the other side of the Earth";
    EXPECT_EQ(projection->forward({50.0, 9.0, nan}).error(), GeoFault::NotFinite);
    EXPECT_EQ(projection->forward({-91.0, 9.0, 0.0}).error(), GeoFault::OutOfRange);
    EXPECT_EQ(projection->reverse({1e9, 0.0, 0.0}).error(), GeoFault::TooFar);
    EXPECT_EQ(projection->reverse({nan, 0.0, 0.0}).error(), GeoFault::NotFinite);
  }
}

}  // namespace
}  // namespace nacelle::navsat
