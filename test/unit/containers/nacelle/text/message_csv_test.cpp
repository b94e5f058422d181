// SPDX-License-Identifier: Apache-2.0
#include "text/message_csv.hpp"

#include <gtest/gtest.h>

namespace nacelle::text {
namespace {

TEST(MessageCsv, is_every_value_in_order_whatever_it_is_nested_in) {
  EXPECT_EQ(csv_of_json(R"({"header":{"stamp":{"sec":3,"nanosec":5},"frame_id":"base"},"on":true,"x":[1.0,"NaN"]})", 0),
            "3,5,base,True,1.0,NaN");
  EXPECT_EQ(csv_of_json(R"({"z":1,"a":{"y":2,"b":-0.5}})", 0), "1,2,-0.5") << "the definition's order";
  EXPECT_EQ(csv_of_json("18446744073709551615", 0), "18446744073709551615") << "one field alone";
  EXPECT_EQ(csv_of_json("{}", 0), "");
}

TEST(MessageCsv, cuts_what_is_long_unless_it_is_not_to) {
  EXPECT_EQ(csv_of_json(R"({"r":[1,2,3],"t":"abcd"})", 2), "1,2,...,ab...");
  EXPECT_EQ(csv_of_json(R"({"r":[1,2,3],"t":"abcd"})", 4), "1,2,3,abcd");
  EXPECT_EQ(csv_of_json(R"({"r":[1,2,3],"t":"abcd"})", 0), "1,2,3,abcd");
}

}  // namespace
}  // namespace nacelle::text
