// SPDX-License-Identifier: Apache-2.0
#include "control/wire.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace nacelle::control {
namespace {

TEST(TransformAnswer, comes_back_as_it_was_sent) {
  const unsigned seed = 11;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any{-1e3, 1e3};
  for (int i = 0; i < 100; ++i) {
    TransformAnswer sent{i % 2 == 0,
                         WallTime{Duration{static_cast<std::int64_t>(random()) << 20}},
                         {any(random), any(random), any(random)},
                         {}};
    for (double& value : sent.rotation_xyzw) value = any(random);
    std::string bytes;
    append_transform(bytes, sent);
    ASSERT_EQ(bytes.size(), kTransformBytes);
    const auto got = read_transform(as_bytes(bytes));
    ASSERT_TRUE(got) << "seed " << seed << ", case " << i;
    EXPECT_EQ(got->known, sent.known);
    EXPECT_EQ(got->stamp, sent.stamp);
    EXPECT_EQ(got->translation_m, sent.translation_m);
    EXPECT_EQ(got->rotation_xyzw, sent.rotation_xyzw);
  }
}

TEST(TransformAnswer, is_refused_in_any_other_length_and_with_a_translation_that_is_no_number) {
  std::string bytes;
  append_transform(bytes, {});
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(read_transform(as_bytes(std::string_view{bytes}.substr(0, n)))) << n;
  EXPECT_FALSE(read_transform(as_bytes(bytes + "x")));
  std::string broken;
  append_transform(broken, {true, {}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}, {0, 0, 0, 1}});
  EXPECT_FALSE(read_transform(as_bytes(broken)));
}

TEST(NamePair, needs_exactly_two_names) {
  const auto read = [](std::string_view text) { return read_name_pair(as_bytes(text)); };
  const auto both = read({"odom\0base", 9});
  ASSERT_TRUE(both);
  EXPECT_EQ(both->first, "odom");
  EXPECT_EQ(both->second, "base");
  EXPECT_FALSE(read(""));
  EXPECT_FALSE(read("odom"));
  EXPECT_FALSE(read({"\0base", 5}));
  EXPECT_FALSE(read({"odom\0", 5}));
  EXPECT_FALSE(read({"a\0b\0c", 5}));
}

TEST(Publication, needs_its_handle) {
  EXPECT_FALSE(read_publication({}));
  EXPECT_FALSE(read_publication(as_bytes("x")));
  std::string bytes;
  append_handle(bytes, 513);
  bytes += "cdr";
  const auto publication = read_publication(as_bytes(bytes));
  ASSERT_TRUE(publication);
  EXPECT_EQ(publication->handle, 513);
  EXPECT_EQ(as_text(publication->cdr), "cdr");
}

}  // namespace
}  // namespace nacelle::control
