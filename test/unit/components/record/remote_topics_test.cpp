// SPDX-License-Identifier: Apache-2.0
// Topics that only other programs publish: what their nodes say of the types, and how the recorder takes them.
#include "record/component/remote_topics.hpp"

#include <std_msgs/msg/string.hpp>

#include "nacelle/msgs/byte_message.hpp"
#include "nacelle/runtime/test_container.hpp"
#include "record/model/recording_summary.hpp"
#include "record/port/recording_file.hpp"
#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using Response = type_description_interfaces::srv::GetTypeDescription::Response;
using std_msgs::msg::String;

void add_source(Response& response, const char* name, const char* text, const char* encoding = "msg") {
  auto& source = response.type_sources.emplace_back();
  source.type_name = name;
  source.raw_file_contents = text;
  source.encoding = encoding;
}

Response two_sources() {
  Response response;
  response.successful = true;
  add_source(response, "acme_msgs/msg/Part", "int32 x\n");
  add_source(response, "acme_msgs/msg/Secret", "Part[] parts\n");
  return response;
}

TEST(RemoteDefinition, is_the_type_followed_by_those_in_it) {
  EXPECT_EQ(definition_in(two_sources(), "acme_msgs/msg/Secret"),
            "Part[] parts\n\n" + std::string(80, '=') + "\nMSG: acme_msgs/Part\nint32 x\n");
}

TEST(RemoteDefinition, is_empty_for_an_answer_that_is_none) {
  Response refused = two_sources();
  refused.successful = false;
  Response other = two_sources();
  add_source(other, "acme_msgs/msg/Idl", "module acme_msgs {}", "idl");
  Response untold = two_sources();
  add_source(untold, "acme_msgs/msg/Empty", "");
  Response long_one = two_sources();
  add_source(long_one, "acme_msgs/msg/Long", std::string(std::size_t{2} << 20U, 'x').c_str());
  for (const Response& wrong : {refused, other, untold, long_one, Response{}})
    EXPECT_EQ(definition_in(wrong, "acme_msgs/msg/Secret"), "");
  EXPECT_EQ(definition_in(two_sources(), "acme_msgs/msg/Third"), "");
}

/// Another program's publisher, as the network shows it: its reader's type is found by its name.
class RemoteTopicsTest : public TemporaryFolder {
 protected:
  RemoteTopicsTest() {
    facts_->read_remote_by([this](std::uint64_t& version) {
      auto topics = topics_.lock();
      return std::exchange(version, topics->size()) == topics->size() ? std::vector<RemoteTopic>{} : *topics;
    });
  }
  void announce(RemoteTopic topic) { topics_.lock()->push_back(std::move(topic)); }
  runtime::ComponentInfo record(std::vector<std::string> topics) {
    return container_.start(
        "nacelle::record::RecordComponent",
        {{"storage.uri", path("bag")}, {"storage.keep_free", std::int64_t{1}}, {"record.topics", std::move(topics)}});
  }
  std::unique_ptr<Writer> publisher(const std::string& topic, const msgs::MessageType& type) {
    EndpointSpec spec;
    spec.topic = topic;
    spec.type = &type;
    spec.node = "/acme";
    spec.via = 7;
    return container_.container().transport().create_writer(spec);
  }
  static void await_readers(const Writer& writer, std::size_t count) {
    while (writer.reader_count() != count) std::this_thread::yield();
  }
  void end(const runtime::ComponentInfo& recorder) {
    EXPECT_EQ(container_.container().trigger(recorder.id, Transition::Deactivate).reason, "");
  }
  /// The topics of the recording.
  std::vector<RecordedTopic> recorded() {
    RecordingSummary summary;
    auto source = FileSource::open(path("bag/bag_0.mcap"));
    EXPECT_TRUE(source && walk_mcap(**source, summary));
    std::vector<RecordedTopic> all;
    for (const auto& [id, topic] : summary.topics()) all.push_back(topic);
    return all;
  }

  Guarded<std::vector<RemoteTopic>> topics_;
  runtime::TestContainer container_;
  const std::shared_ptr<NetworkFacts> facts_ =
      std::static_pointer_cast<NetworkFacts>(container_.container().shared_object(kNetworkFactsName));
};

constexpr const char* kSecret = "acme_msgs/msg/Secret";
constexpr const char* kDdsSecret = "acme_msgs::msg::dds_::Secret_";

TEST_F(RemoteTopicsTest, of_unknown_types_are_recorded_by_their_bytes) {
  const Bytes message{0, 1, 0, 0, 7, 0, 0, 0};
  announce({"/secret", kSecret, kDdsSecret, "", {QoS(10)}, {}});
  const auto recorder = record({"/secret"});
  const msgs::MessageType* const type = msgs::lasting_byte_type(kSecret, kDdsSecret, "", "");
  const auto writer = publisher("/secret", *type);
  await_readers(*writer, 1);
  Block* const block = writer->borrow();
  ASSERT_TRUE(type->decode(message, block->message));
  writer->publish(*block);
  end(recorder);
  const auto all = recorded();
  ASSERT_EQ(all.size(), 1U);
  const RecordedTopic& topic = all.front();
  EXPECT_EQ(topic.name, "/secret");
  EXPECT_EQ(topic.type, kSecret);
  EXPECT_EQ(topic.messages, 1U);
  EXPECT_EQ(topic.bytes, message.size());
  EXPECT_FALSE(topic.has_definition);
}

TEST_F(RemoteTopicsTest, of_installed_types_are_recorded_as_those) {
  announce(
      {"/said", "std_msgs/msg/String", "std_msgs::msg::dds_::String_", String::message_type().hash, {QoS(10)}, {}});
  const auto recorder = record({"/said"});
  const auto writer = publisher("/said", String::message_type());
  await_readers(*writer, 1);
  writer->publish(*writer->borrow());
  end(recorder);
  const auto all = recorded();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_TRUE(all.front().has_definition);
}

TEST_F(RemoteTopicsTest, are_left_to_a_type_that_somebody_here_uses) {
  announce({"/secret", kSecret, kDdsSecret, "", {QoS(10)}, {}});
  const auto recorder = record({"/secret"});
  const auto writer = publisher("/secret", *msgs::lasting_byte_type(kSecret, kDdsSecret, "", ""));
  await_readers(*writer, 1);
  {
    auto reader = container_.subscribe<String>("/secret", QoS(10));
    await_readers(*writer, 0);
  }
  end(recorder);
}

TEST_F(RemoteTopicsTest, are_left_to_a_type_that_comes_at_the_same_time) {
  announce({"/secret", kSecret, kDdsSecret, "", {QoS(10)}, {}});
  const auto recorder = record({"/secret", "/later"});
  const auto writer = publisher("/secret", *msgs::lasting_byte_type(kSecret, kDdsSecret, "", ""));
  const auto reader = container_.subscribe<String>("/secret", QoS(10));
  // The recorder takes what was made in the order in which it was made.
  const auto later = publisher("/later", String::message_type());
  await_readers(*later, 1);
  EXPECT_EQ(writer->reader_count(), 0U);
  end(recorder);
}

}  // namespace
}  // namespace nacelle::record
