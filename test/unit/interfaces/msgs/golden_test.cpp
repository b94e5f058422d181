// SPDX-License-Identifier: Apache-2.0
#include "msgs_test_support.hpp"
#include "support/places.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <map>

namespace nacelle {
namespace {

/// Returns whether the values are equal. A float32 may be written as the intended decimal (0.05) or as its exact value.
bool same(const nlohmann::json& a, const nlohmann::json& b) {
  if (a.is_number_float() && b.is_number_float()) return a == b || a.get<float>() == b.get<float>();
  if (a.size() != b.size() || a.is_structured() != b.is_structured()) return false;
  if (!a.is_structured()) return a == b;
  if (a.is_object()) {
    for (const auto& [name, value] : a.items()) {
      if (!b.contains(name) || !same(value, b.at(name))) return false;
    }
    return true;
  }
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

class GoldenVector : public testing::TestWithParam<test::Vector> {};

TEST_P(GoldenVector, its_values_become_exactly_these_bytes) {
  const auto& vector = GetParam();
  const auto& type = test::message_type(vector.type);
  msgs::AnyMessage message{type};

  const auto read = msgs::from_json(vector.values.dump(), type, message.get());

  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(to_hex(message.encoded()), to_hex(vector.bytes));
}

TEST_P(GoldenVector, its_bytes_become_exactly_these_values) {
  const auto& vector = GetParam();
  const auto& type = test::message_type(vector.type);
  msgs::AnyMessage message{type};
  type.poison(message.get());

  const auto decoded = type.decode(vector.bytes, message.get());

  ASSERT_TRUE(decoded) << msgs::explain(decoded.error());
  EXPECT_TRUE(same(nlohmann::json::parse(test::to_json(message)), vector.values)) << test::to_json(message) << "\n"
                                                                                  << vector.values;
}

TEST_P(GoldenVector, its_type_has_this_hash) { EXPECT_EQ(test::message_type(GetParam().type).hash, GetParam().hash); }

std::string name_of(const testing::TestParamInfo<test::Vector>& info) {
  std::string name = info.param.type + "_" + info.param.sample;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Ros2Jazzy, GoldenVector, testing::ValuesIn(test::golden_vectors()), name_of);

TEST(GoldenVectors, are_all_there) { EXPECT_EQ(test::golden_vectors().size(), 188U); }

std::map<std::string, std::string> golden_hashes() {
  std::ifstream file{test::data("vectors/type-hashes.tsv")};
  std::map<std::string, std::string> hashes;
  std::string type;
  std::string hash;
  while (file >> type >> hash) hashes[type] = hash;
  return hashes;
}

TEST(TypeHashes, of_every_type_are_the_golden_ones) {
  const auto hashes = golden_hashes();
  ASSERT_EQ(hashes.size(), 954U);
  for (const auto& [type, hash] : hashes) {
    const auto found = test::type_library().find(type);
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(found->hash(), hash) << type;
    EXPECT_EQ(found->name(), type);
  }
}

TEST(TypeHashes, cover_every_type_of_the_libraries) {
  const auto hashes = golden_hashes();
  for (const auto& package : test::type_library().packages()) {
    // ROS 2 has neither the tests' own package nor Nacelle's.
    if (package == "my_robot_msgs" || package == "nacelle_interfaces") continue;
    const auto names = test::type_library().names(package, true);
    ASSERT_TRUE(names) << names.error().text();
    for (const auto& name : *names) EXPECT_TRUE(hashes.contains(name)) << name;
  }
}

}  // namespace
}  // namespace nacelle
