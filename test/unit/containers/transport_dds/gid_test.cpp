// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/gid.hpp"

#include <gtest/gtest.h>

#include <unordered_set>

namespace nacelle::transport_dds {
namespace {

Gid gid_of(std::string_view hex) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(hex, bytes) && bytes.size() == Gid::kBytes) << hex;
  Gid gid;
  std::copy(bytes.begin(), bytes.end(), gid.bytes.begin());
  return gid;
}

TEST(Gid, knows_the_participant_of_an_endpoint) {
  const Gid writer = gid_of("01105ab411f4eda37efc601600000603");

  EXPECT_EQ(writer.participant().text(), "01105ab411f4eda37efc6016000001c1");
  EXPECT_TRUE(writer.participant().is_participant());
  EXPECT_FALSE(writer.is_participant());
  EXPECT_TRUE(writer.same_participant(writer.participant()));
  EXPECT_FALSE(writer.same_participant(gid_of("01105ab411f4eda37efc601700000603")));
}

TEST(Gid, is_a_key_of_ordered_and_of_hashed_containers) {
  const Gid a = gid_of("01105ab411f4eda37efc601600000603"), b = gid_of("01105ab411f4eda37efc601600000604");

  EXPECT_LT(a, b);
  EXPECT_EQ((std::unordered_set<Gid>{a, b, a}.size()), 2U);
}

}  // namespace
}  // namespace nacelle::transport_dds
