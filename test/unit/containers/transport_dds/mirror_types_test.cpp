// SPDX-License-Identifier: Apache-2.0
// A node that reads several types on one name: what the network sees of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <std_msgs/msg/header.hpp>

#include "mirrored.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::Header;
using test::say;
using test::String;
using Types = std::set<std::string>;

const std::string kString = "std_msgs/msg/String", kHeader = "std_msgs/msg/Header";

/// `here` has a base that takes two types and is a String by default, and a monitor that reads both.
class TwoTypes : public test::Mirror {
 protected:
  EndpointSpec spec(test::MirroredBroker& at, const msgs::MessageType& type, Announced announced = Announced::Always) {
    EndpointSpec made = at.spec("/commands");
    made.type = &type;
    made.announced = announced;
    return made;
  }
  std::unique_ptr<Reader> reader(const msgs::MessageType& type, Announced announced) {
    return here.broker.create_reader(spec(here, type, announced), Taking::Share, &here.bell);
  }
  std::unique_ptr<Writer> writer(test::MirroredBroker& at, const msgs::MessageType& type) {
    return at.broker.create_writer(spec(at, type));
  }
  /// As `ros2 topic echo` and `ros2 bag record` see the name, from a third participant.
  bool types_become(const Types& wanted) {
    return until([&] {
      Types seen;
      viewer.mirror->look([&](const transport_dds::RemoteGraph& graph) {
        for (const auto& end : graph.ends_of_topic("/commands")) seen.insert(end.type);
      });
      return seen == wanted;
    });
  }

  test::MirroredBroker viewer{"viewer"};
  std::unique_ptr<Reader> base_default = reader(String::message_type(), Announced::ByDefault),
                          base_other = reader(Header::message_type(), Announced::WithItsPublisher),
                          monitor_default = reader(String::message_type(), Announced::WithItsPublisher),
                          monitor_other = reader(Header::message_type(), Announced::WithItsPublisher);
};

TEST_F(TwoTypes, without_a_publisher_the_network_sees_the_default_one) {
  EXPECT_TRUE(types_become({kString}));
  EXPECT_TRUE(until([&] { return here.stats().readers == 1; })) << "a monitor names no type";
  monitor_default.reset();
  base_default.reset();
  EXPECT_TRUE(types_become({})) << "the others wait for their publisher";
}

TEST_F(TwoTypes, with_a_publisher_of_the_default_type_all_that_read_it_are_seen) {
  auto publisher = writer(there, String::message_type());
  ASSERT_TRUE(types_become({kString}));
  ASSERT_TRUE(until([&] { return publisher->reader_count() == 2 && here.stats().readers == 2; }));
  say(*publisher, "go");
  EXPECT_EQ(test::hear(here.bell, *base_default, 1), test::Texts{"go"});
  EXPECT_EQ(test::hear(here.bell, *monitor_default, 1), test::Texts{"go"});
}

TEST_F(TwoTypes, a_publisher_of_the_other_type_changes_what_is_seen_and_its_end_changes_it_back) {
  ASSERT_TRUE(types_become({kString}));
  auto publisher = writer(there, Header::message_type());
  ASSERT_TRUE(types_become({kHeader}));
  ASSERT_TRUE(until([&] { return publisher->reader_count() == 2 && base_other->writer_count() == 1; }));
  Block* const block = publisher->borrow();
  static_cast<Header*>(block->message)->frame_id = "base_link";
  publisher->publish(*block);
  Block* heard = nullptr;
  ASSERT_TRUE(until([&] { return (heard = base_other->take()) != nullptr; }));
  EXPECT_EQ(static_cast<const Header*>(heard->message)->frame_id, "base_link");
  drop_reference(*heard);
  publisher.reset();
  EXPECT_TRUE(types_become({kString}));
}

TEST_F(TwoTypes, a_publisher_of_this_side_counts_as_one_of_the_network) {
  ASSERT_TRUE(types_become({kString}));
  auto publisher = writer(here, Header::message_type());
  EXPECT_TRUE(types_become({kHeader}));
  publisher.reset();
  EXPECT_TRUE(types_become({kString}));
}

TEST_F(TwoTypes, two_publishers_of_two_types_are_both_served) {
  auto one = writer(there, String::message_type()), other = writer(there, Header::message_type());
  ASSERT_TRUE(types_become({kString, kHeader}));
  EXPECT_TRUE(until([&] { return one->reader_count() == 2 && other->reader_count() == 2; }));
}

TEST_F(TwoTypes, a_participant_that_leaves_takes_its_publishers_along) {
  auto publisher = writer(there, Header::message_type());
  ASSERT_TRUE(types_become({kHeader}));
  there.mirror.reset();
  EXPECT_TRUE(types_become({kString}));
}

}  // namespace
}  // namespace nacelle
