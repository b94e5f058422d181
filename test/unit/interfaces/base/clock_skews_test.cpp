// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "nacelle/base/clock_skews.hpp"

namespace nacelle {
namespace {

TEST(ClockSkew, says_which_host_and_how_far) {
  EXPECT_EQ(ClockSkew("laptop", 150ms).text(), "host laptop is 150 ms ahead");
  EXPECT_EQ(ClockSkew("laptop", -152ms).text(), "host laptop is 152 ms behind, or its messages come that late");
  EXPECT_EQ(ClockSkew("pi", -Duration{1'790'000'000s}).text(),
            "host pi is 1790000000 s behind, or its messages come that late");
  EXPECT_EQ(ClockSkew("laptop", -30ms, ClockSkew::Sureness::Proven).text(), "host laptop is 30 ms behind");
  EXPECT_TRUE(ClockSkew("laptop", 30ms).is_certain());
  EXPECT_FALSE(ClockSkew("laptop", -150ms).is_certain());
  EXPECT_EQ(ClockSkew().text(), "");
  EXPECT_FALSE(ClockSkew());
  EXPECT_EQ(ClockSkew(std::string(100, 'a'), 1s).host(), std::string(47, 'a'));
}

TEST(ClockSkews, give_the_cause_for_the_writers_that_they_know) {
  ClockSkews skews;
  EXPECT_EQ(skews.cause(7), "");
  skews.replace({{7, ClockSkew{"laptop", 30ms}}});
  EXPECT_EQ(skews.cause(7), "; clock skew: host laptop is 30 ms ahead");
  EXPECT_EQ(skews.cause(8), "");
  EXPECT_EQ(skews.of_writer(7).ahead(), 30ms);
  skews.replace({});
  EXPECT_FALSE(skews.of_writer(7));
}

}  // namespace
}  // namespace nacelle
