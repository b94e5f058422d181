// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/user_data.hpp"

#include <gtest/gtest.h>

#include "recordings.hpp"

namespace nacelle::transport_dds {
namespace {

using namespace std::string_view_literals;

UserData parsed(std::string_view text) { return parse_user_data(as_bytes(text)); }

const std::string kHash = "RIHS01_" + std::string(62, '0') + "af";

TEST(UserData, of_everything_that_ros_2_announced_is_written_back_as_it_was) {
  std::size_t services = 0, clients = 0;
  for (const auto& endpoint : recorded::announcements()) {
    const EndpointUserData data = read_endpoint_user_data(endpoint.user_data);
    EXPECT_FALSE(data.type_hash.empty()) << endpoint.topic;
    EXPECT_EQ(write_endpoint_user_data(data), as_text(endpoint.user_data));
    services += data.service_id.empty() ? 0 : 1;
    clients += data.client_id.empty() ? 0 : 1;
  }
  EXPECT_GT(services, 0U);
  EXPECT_GT(clients, 0U);
}

TEST(UserData, of_a_participant_is_its_enclave) {
  for (const std::string recording : {"lifecycle", "action"}) {
    std::size_t ros = 0, foreign = 0;
    for (const auto& participant : recorded::participants(recording)) {
      const auto enclave = read_participant_user_data(participant.user_data);
      EXPECT_EQ(write_participant_user_data(enclave.value_or("")), as_text(participant.user_data));
      (enclave ? ros : foreign) += 1;
    }
    EXPECT_EQ(ros, 1U);
    EXPECT_EQ(foreign, 1U) << "the recorder";
  }
  EXPECT_EQ(write_participant_user_data(), "enclave=/;");
  EXPECT_EQ(read_participant_user_data(as_bytes("enclave=/robot/arm;")), "/robot/arm");
}

TEST(UserData, ids_are_those_of_the_participant_that_has_them) {
  for (const auto& endpoint : recorded::announcements()) {
    const EndpointUserData data = read_endpoint_user_data(endpoint.user_data);
    const std::string& id = data.client_id.empty() ? data.service_id : data.client_id;
    if (id.empty()) continue;
    const std::string prefix = endpoint_id_text(endpoint.participant, 0);
    EXPECT_EQ(id.substr(0, id.rfind(".0.0.0.")), prefix.substr(0, prefix.rfind(".0.0.0.0")));
  }
}

TEST(UserData, an_id_has_no_leading_zeros_but_a_blank_in_front) {
  Gid participant = recorded::gid("0110fa5e8be4654810e75956000001c1");
  EXPECT_EQ(endpoint_id_text(participant, 5), " 1.10.fa.5e.8b.e4.65.48.10.e7.59.56.0.0.0.5");
  participant.bytes[0] = 0xAB;
  EXPECT_EQ(endpoint_id_text(participant, 0x01020AFF), "ab.10.fa.5e.8b.e4.65.48.10.e7.59.56.1.2.a.ff");
}

TEST(UserData, holds_pairs) {
  EXPECT_EQ(parsed("a=b;"), (UserData{{"a", "b"}}));
  EXPECT_EQ(parsed("a=b;c1=d e;"), (UserData{{"a", "b"}, {"c1", "d e"}}));
  EXPECT_EQ(parsed("a=b"), (UserData{{"a", "b"}})) << "the last ';' may be missing";
  EXPECT_EQ(parsed("a=b;a=c;"), (UserData{{"a", "c"}})) << "the last of equal keys counts";
  EXPECT_EQ(parsed("a=b=c;"), (UserData{{"a", "b=c"}}));
}

TEST(UserData, may_be_padded_with_nuls) {
  EXPECT_EQ(parsed("a=b;\0\0\0"sv), (UserData{{"a", "b"}}));
  EXPECT_EQ(parsed("a=b;\0x"sv), (UserData{{"a", "b"}})) << "nothing is read behind a NUL";
  EXPECT_EQ(parsed("a=b\0"sv), (UserData{{"a", std::string("b\0", 2)}})) << "without the ';' it belongs to the value";
  EXPECT_EQ(parsed("\0"sv), UserData{});
}

TEST(UserData, keeps_rmws_own_rule_for_two_semicolons) {
  EXPECT_EQ(parsed("a=b;;"), (UserData{{"a", "b;"}}));
  EXPECT_EQ(parsed("a=;;"), (UserData{{"a", ";"}}));
  EXPECT_EQ(parsed("a=b;;c=d;"), (UserData{{"a", "b;"}, {"c", "d"}})) << "no escape: the value ends all the same";
  EXPECT_EQ(parsed("a=b;;c"), UserData{}) << "the last key has no value";
}

TEST(UserData, passes_over_one_byte_between_two_pairs) {
  EXPECT_EQ(parsed("a=b; c=d;"), (UserData{{"a", "b"}, {"c", "d"}}));
  EXPECT_EQ(parsed("a=b;  c=d;"), UserData{});
}

TEST(UserData, that_is_malformed_anywhere_is_not_read_at_all) {
  for (const std::string_view text :
       {""sv, ";"sv, "="sv, "=b;"sv, "a"sv, "a;"sv, "a=;"sv, "a="sv, "a=b;c"sv, "a=b;c;"sv, "a=b;c=;"sv, "a=b;=d;"sv,
        "a_b=c;"sv, " a=b;"sv, "a =b;"sv, "\xff\xfe\x00\x01"sv, "a=b;c\0=d;"sv}) {
    EXPECT_EQ(parsed(text), UserData{}) << to_hex(as_bytes(text));
  }
}

TEST(UserData, that_is_too_long_is_not_read) {
  EXPECT_EQ(parsed("a=" + std::string(kMostUserDataBytes - 2, 'b')).size(), 1U);
  EXPECT_EQ(parsed("a=" + std::string(kMostUserDataBytes - 1, 'b')), UserData{});
  EXPECT_EQ(read_participant_user_data(as_bytes("enclave=" + std::string(kMostEnclaveBytes + 1, '/') + ";")),
            std::nullopt);
  EXPECT_EQ(read_endpoint_user_data(as_bytes("clientid=" + std::string(kMostIdTextBytes + 1, '1') + ";")),
            EndpointUserData{});
}

TEST(UserData, of_an_endpoint_without_a_hash_or_with_a_bad_one_is_still_read) {
  const auto hash_of = [](const std::string& value) {
    return read_endpoint_user_data(as_bytes("clientid=1;typehash=" + value + ";"));
  };
  EXPECT_EQ(hash_of(kHash), (EndpointUserData{kHash, "1", ""}));
  EXPECT_EQ(hash_of("RIHS01_" + std::string(62, '0') + "AF").type_hash, kHash) << "compared without regard to case";
  for (const std::string& bad :
       {kHash + "0", kHash.substr(1), "RIHS02_" + kHash.substr(7), "RIHS01_" + std::string(64, 'g')}) {
    EXPECT_EQ(hash_of(bad), (EndpointUserData{"", "1", ""})) << bad;
  }
  EXPECT_EQ(write_endpoint_user_data({}), "");
}

}  // namespace
}  // namespace nacelle::transport_dds
