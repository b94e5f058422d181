// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/type_description.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <example_interfaces/action/fibonacci.hpp>
#include <lifecycle_msgs/srv/get_state.hpp>
#include <map>
#include <rmw_dds_common/msg/participant_entities_info.hpp>

#include "nacelle/msgs/type_library.hpp"
#include "sha256.hpp"
#include "support/places.hpp"

namespace nacelle::msgs {
namespace {

using GetState = lifecycle_msgs::srv::GetState;
using Fibonacci = example_interfaces::action::Fibonacci;
using Info = rmw_dds_common::msg::ParticipantEntitiesInfo;
using Individual = type_description_interfaces::msg::IndividualTypeDescription;

// The text of which ROS 2's hash is the SHA-256: no default values, fixed order, json.dumps' blanks.
std::string json_of(const Individual& one) {
  std::string text = "{\"type_name\": \"" + one.type_name + "\", \"fields\": [";
  for (const auto& field : one.fields) {
    text += text.ends_with('[') ? "" : ", ";
    text += "{\"name\": \"" + field.name + "\", \"type\": {\"type_id\": " + std::to_string(field.type.type_id) +
            ", \"capacity\": " + std::to_string(field.type.capacity) +
            ", \"string_capacity\": " + std::to_string(field.type.string_capacity) + ", \"nested_type_name\": \"" +
            field.type.nested_type_name + "\"}}";
  }
  return text + "]}";
}
std::string hash_of(const TypeDescription& description) {
  std::string text =
      "{\"type_description\": " + json_of(description.type_description) + ", \"referenced_type_descriptions\": [";
  for (const auto& one : description.referenced_type_descriptions)
    text += (text.ends_with('[') ? "" : ", ") + json_of(one);
  return "RIHS01_" + test::Sha256::hex(text + "]}");
}

TEST(Sha256, has_the_digests_of_its_standard) {
  EXPECT_EQ(test::Sha256::hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(test::Sha256::hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(TypeDescription, of_every_type_is_what_its_hash_is_the_hash_of) {
  TypeLibrary library({test::message_libraries()});
  std::size_t seen = 0;
  const auto check = [&](const auto& type) {
    EXPECT_EQ(hash_of(describe(&type)), type.hash) << type.name;
    ++seen;
  };
  for (const auto& name : library.packages()) {
    const auto package = library.package(name);
    ASSERT_TRUE(package) << package.error().text();
    for (const auto message : (*package)->messages) check(message());
    for (const auto service : (*package)->services) check(service());
    for (const auto action : (*package)->actions) check(action());
  }
  EXPECT_GE(seen, 700U);
}

TEST(TypeDescription, of_an_empty_message_has_the_member_that_idl_needs) {
  const auto description = describe(&GetState::Request::message_type()).type_description;

  ASSERT_EQ(description.fields.size(), 1U);
  EXPECT_EQ(description.fields[0].name, "structure_needs_at_least_one_member");
  EXPECT_EQ(description.fields[0].type.type_id, 3);
}

TEST(TypeDescription, has_the_default_values_of_the_definition) {
  const auto description = describe(&GetTypeDescription::service_type());
  const auto request =
      std::find_if(description.referenced_type_descriptions.begin(), description.referenced_type_descriptions.end(),
                   [](const auto& one) { return one.type_name.ends_with("_Request"); });
  ASSERT_NE(request, description.referenced_type_descriptions.end());
  EXPECT_EQ(request->fields.at(2).default_value, "True");
  EXPECT_EQ(request->fields.at(0).default_value, "");
}

TEST(TypeSource, of_a_message_has_its_definition_and_those_of_its_parts) {
  const auto sources = sources_of(&Info::message_type());

  ASSERT_EQ(sources.size(), 3U);
  EXPECT_EQ(sources[0].type_name, "rmw_dds_common/msg/ParticipantEntitiesInfo");
  EXPECT_EQ(sources[0].encoding, "msg");
  EXPECT_EQ(sources[0].raw_file_contents, "Gid gid\nNodeEntitiesInfo[] node_entities_info_seq\n");
  EXPECT_EQ(sources[1].type_name, "rmw_dds_common/msg/Gid");
  EXPECT_EQ(sources[1].raw_file_contents, "char[16] data\n");
  EXPECT_EQ(sources[2].type_name, "rmw_dds_common/msg/NodeEntitiesInfo");
  EXPECT_NE(sources[2].raw_file_contents.find("string<=256 node_name"), std::string::npos);
}

TEST(TypeSource, of_a_service_has_implicit_parts) {
  const auto sources = sources_of(&GetState::service_type());

  EXPECT_EQ(sources.at(0).encoding, "srv");
  EXPECT_NE(sources.at(0).raw_file_contents.find("---"), std::string::npos);
  std::map<std::string, std::string> encodings;
  for (const auto& source : sources) encodings[source.type_name] = source.encoding;
  EXPECT_EQ(encodings.at("lifecycle_msgs/srv/GetState_Request"), "implicit");
  EXPECT_EQ(encodings.at("lifecycle_msgs/srv/GetState_Event"), "implicit");
  EXPECT_EQ(encodings.at("lifecycle_msgs/msg/State"), "msg");
}

TEST(GetTypeDescription, answers_for_a_type_in_use_by_its_hash) {
  const std::vector<UsedType> in_use{&Info::message_type(), &GetState::service_type(), &Fibonacci::action_type()};
  GetTypeDescription::Request request;
  request.type_hash = Fibonacci::action_type().hash;
  const auto response = answer(request, in_use);

  EXPECT_TRUE(response.successful);
  EXPECT_EQ(response.failure_reason, "");
  EXPECT_EQ(response.type_description, describe(&Fibonacci::action_type()));
  EXPECT_EQ(response.type_sources.size(), 1 + response.type_description.referenced_type_descriptions.size());
  request.include_type_sources = false;
  EXPECT_TRUE(answer(request, in_use).type_sources.empty());
}

TEST(GetTypeDescription, fails_with_rcls_words) {
  GetTypeDescription::Request request;
  EXPECT_EQ(answer(request, {}).failure_reason, "Failed to parse type hash");
  request.type_hash = Info::message_type().hash;
  EXPECT_EQ(answer(request, {}).failure_reason, "Type not currently in use by this node");
  EXPECT_FALSE(answer(request, {}).successful);
}

}  // namespace
}  // namespace nacelle::msgs
