// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/discovery.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "support/dds.hpp"

namespace nacelle::transport_dds {
namespace {

using Kind = DiscoveryEvent::Kind;

/// A participant that observes the network, and the endpoints that it has seen so far.
class Onlooker {
 public:
  Onlooker() : discovery_(participant_->create_discovery(&told).value()) {}

  template <typename What, typename Matches>
  [[nodiscard]] std::optional<What> wait_for(Kind kind, Matches matches) {
    std::optional<What> found;
    static_cast<void>(told.until([&] {
      while (discovery_->take(seen_, 100)) {}
      for (const auto& event : seen_) {
        const What* const what = std::get_if<What>(&event.what);
        if (event.kind == kind && what != nullptr && matches(*what)) found = *what;
      }
      return found.has_value();
    }));
    return found;
  }
  [[nodiscard]] const std::vector<DiscoveryEvent>& seen() const { return seen_; }

  test::Told told;

 private:
  std::unique_ptr<Participant> participant_ = test::make_participant();
  std::vector<DiscoveryEvent> seen_;
  std::unique_ptr<Discovery> discovery_;
};

Bytes bytes_of(std::string_view text) {
  const ByteView view = as_bytes(text);
  return {view.begin(), view.end()};
}

TEST(Discovery, tells_of_a_participant_its_user_data_process_and_end) {
  Onlooker onlooker;
  auto other = test::make_participant({.user_data = bytes_of("enclave=/;")});
  const Gid gid = other->gid();
  const auto is_it = [&](const DiscoveredParticipant& found) { return found.gid == gid; };
  const auto found = onlooker.wait_for<DiscoveredParticipant>(Kind::Appeared, is_it);
  ASSERT_TRUE(found);
  EXPECT_EQ(as_text(found->user_data), "enclave=/;");
  EXPECT_EQ(found->process, "transport_dds_port_test");
  EXPECT_FALSE(found->host.empty());
  other.reset();
  EXPECT_TRUE(onlooker.wait_for<DiscoveredParticipant>(Kind::Gone, is_it));
}

TEST(Discovery, tells_of_an_endpoint_its_names_qos_user_data_and_end) {
  Onlooker onlooker;
  const auto other = test::make_participant();
  const QoS qos = QoS(7).transient_local().deadline(2s);
  auto writer = other->create_writer(test::string_topic("seen", qos), nullptr).value();
  const Gid gid = writer->gid();
  const auto is_it = [&](const DiscoveredEndpoint& found) { return found.gid == gid; };
  const auto found = onlooker.wait_for<DiscoveredEndpoint>(Kind::Appeared, is_it);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->is_writer);
  EXPECT_EQ(found->topic, "rt/seen");
  EXPECT_EQ(found->type, "std_msgs::msg::dds_::String_");
  EXPECT_EQ(found->participant, other->gid());
  EXPECT_EQ(found->qos, to_dds(qos));
  EXPECT_EQ(found->user_data, test::string_topic("seen").user_data);
  writer.reset();
  const auto gone = onlooker.wait_for<DiscoveredEndpoint>(Kind::Gone, is_it);
  ASSERT_TRUE(gone);
  EXPECT_TRUE(gone->is_writer);
  EXPECT_EQ(gone->participant, other->gid());
}

TEST(Discovery, leaves_out_user_data_that_is_too_long) {
  Onlooker onlooker;
  const auto other = test::make_participant();
  auto options = test::string_topic("long_user_data");
  options.user_data.assign(5000, 'x');
  const auto reader = other->create_reader(options, nullptr).value();
  const auto found = onlooker.wait_for<DiscoveredEndpoint>(
      Kind::Appeared, [&](const DiscoveredEndpoint& endpoint) { return endpoint.gid == reader->gid(); });
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->is_writer);
  EXPECT_TRUE(found->user_data.empty());
}

TEST(Discovery, reports_a_type_without_a_local_match) {
  Onlooker onlooker;
  const auto other = test::make_participant();
  auto options = test::string_topic("type_clash");
  options.type = "std_msgs::msg::dds_::Bool_";
  const auto writer = other->create_writer(options, nullptr).value();
  const auto found = onlooker.wait_for<DiscoveredEndpoint>(
      Kind::Appeared, [](const DiscoveredEndpoint& endpoint) { return endpoint.topic == "rt/type_clash"; });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->type, "std_msgs::msg::dds_::Bool_");
}

TEST(Discovery, does_not_pile_up_what_came_and_went) {
  Onlooker onlooker;
  const auto other = test::make_participant();
  for (int i = 0; i < 200; ++i) { ASSERT_TRUE(other->create_writer(test::string_topic("comes_and_goes"), nullptr)); }
  const auto last = other->create_writer(test::string_topic("last"), nullptr).value();
  ASSERT_TRUE(onlooker.wait_for<DiscoveredEndpoint>(
      Kind::Appeared, [&](const DiscoveredEndpoint& endpoint) { return endpoint.gid == last->gid(); }));
  std::vector<Gid> here;
  for (const auto& event : onlooker.seen()) {
    const auto* const endpoint = std::get_if<DiscoveredEndpoint>(&event.what);
    if (endpoint == nullptr || !endpoint->gid.same_participant(other->gid())) continue;
    if (event.kind == Kind::Gone) {
      std::erase(here, endpoint->gid);
    } else if (std::find(here.begin(), here.end(), endpoint->gid) == here.end()) {
      here.push_back(endpoint->gid);
    }
  }
  EXPECT_EQ(here, std::vector<Gid>{last->gid()}) << "after all events only those are left that are there";
}

}  // namespace
}  // namespace nacelle::transport_dds
