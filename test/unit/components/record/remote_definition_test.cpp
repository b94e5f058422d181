// SPDX-License-Identifier: Apache-2.0
// Two participants: one publishes a type that the other has never heard of, and its node says what it is.
#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "nacelle/msgs/byte_message.hpp"
#include "networking/remote_topics.hpp"
#include "record/component/remote_topics.hpp"
#include "unit/containers/transport_dds/mirrored_container.hpp"

namespace nacelle::record {
namespace {

using type_description_interfaces::srv::GetTypeDescription;

constexpr const char* kSecret = "acme_msgs/msg/Secret";
constexpr const char* kDdsSecret = "acme_msgs::msg::dds_::Secret_";
const std::string kHash = "RIHS01_" + std::string(64, 'a');
constexpr const char* kText = "uint8[] bytes\n";

struct Secret {
  Bytes bytes;
  static const msgs::MessageType& message_type() { return *msgs::lasting_byte_type(kSecret, kDdsSecret, kHash, kText); }
};

/// The other robot's node.
class Acme final : public bench::Recipe {
 public:
  explicit Acme(bool has_sources) : has_sources_(has_sources) {}
  std::shared_ptr<void> build(LifecycleNode& node) override {
    struct Parts {
      std::shared_ptr<Publisher<Secret>> publisher;
      std::shared_ptr<Service<GetTypeDescription>> service;
    };
    auto parts = std::make_shared<Parts>();
    publisher = parts->publisher = node.create_publisher<Secret>("/secret", QoS(1).transient_local());
    parts->service = node.create_service<GetTypeDescription>(
        "~/get_type_description",
        [this](const GetTypeDescription::Request& request, GetTypeDescription::Response& out) {
          out.successful = request.type_hash == kHash && has_sources_;
          auto& source = out.type_sources.emplace_back();
          source.type_name = kSecret;
          source.encoding = "msg";
          source.raw_file_contents = kText;
        });
    return parts;
  }
  std::weak_ptr<Publisher<Secret>> publisher;  // the node's: it ends before its container

 private:
  const bool has_sources_;
};

/// The recorder's node.
class Looking final : public bench::Recipe {
 public:
  Looking(const Clock& clock, std::shared_ptr<const NetworkFacts> facts, test::Bell& bell)
      : clock_(clock), facts_(std::move(facts)), bell_(bell) {}
  std::shared_ptr<void> build(LifecycleNode& node) override {
    struct Parts {
      std::unique_ptr<RemoteTopics> topics;
      std::shared_ptr<Timer> timer;
    };
    auto parts = std::make_shared<Parts>();
    RemoteTopics::Options options;
    options.takes = [](const std::string& topic) { return topic == "/secret"; };
    options.add = [this](const std::string&, const msgs::MessageType& type, const std::vector<QoS>& offered) {
      *found.lock() = std::pair{&type, offered};
      bell_.ring();
    };
    parts->topics = std::make_unique<RemoteTopics>(node, clock_, facts_, std::move(options));
    parts->timer = node.create_wall_timer(20ms, [topics = parts->topics.get()] { topics->look(); });
    return parts;
  }
  Guarded<std::optional<std::pair<const msgs::MessageType*, std::vector<QoS>>>> found;

 private:
  const Clock& clock_;
  const std::shared_ptr<const NetworkFacts> facts_;
  test::Bell& bell_;
};

struct RemoteDefinitionTest : ::testing::Test {
  void look() {
    facts->read_remote_by([this](std::uint64_t& version) {
      std::vector<RemoteTopic> topics;
      here.mirror->look([&](const transport_dds::RemoteGraph& graph) {
        if (std::exchange(version, graph.version()) != graph.version()) topics = networking::remote_topics_of(graph);
      });
      return topics;
    });
    here.load(looking, "looking");
  }
  ~RemoteDefinitionTest() override { facts->read_remote_by({}); }

  const std::shared_ptr<NetworkFacts> facts = std::make_shared<NetworkFacts>();
  SystemClock clock;
  test::Bell bell;
  Looking looking{clock, facts, bell};
  test::MirroredContainer here{"here"};
};

TEST_F(RemoteDefinitionTest, is_what_the_publishers_node_says_and_messages_are_its_bytes) {
  Acme acme{true};
  test::MirroredContainer there{"there"};
  there.load(acme, "acme");
  look();
  ASSERT_TRUE(bell.until([&] { return looking.found.lock()->has_value(); }));
  const auto [type, offered] = **looking.found.lock();
  EXPECT_EQ(type, &Secret::message_type()) << type->definition;
  ASSERT_EQ(offered.size(), 1U);
  EXPECT_EQ(offered.front().durability(), Durability::TransientLocal);

  struct Ready final : ReadyListener {
    explicit Ready(test::Bell& rings) : bell(rings) {}
    void on_ready() noexcept override { bell.ring(); }
    test::Bell& bell;
  } ready{bell};
  const auto reader = here.container().transport().create_reader(
      {"/secret", type, QoS(1).transient_local(), "/recorder"}, Taking::Share, &ready);
  const Bytes sent{0, 1, 0, 0, 1, 0, 0, 0, 42};
  {
    const auto publisher = acme.publisher.lock();
    ASSERT_TRUE(publisher);
    auto message = publisher->borrow();
    message->bytes = sent;
    publisher->publish(std::move(message));
  }
  ASSERT_TRUE(bell.until([&] { return reader->has_waiting(); }));
  Block* const block = reader->take();
  Bytes came(type->encoded_size(block->message));
  type->encode(block->message, came.data());
  EXPECT_EQ(Bytes(came.begin(), came.begin() + 9), sent) << "and perhaps padding";
  drop_reference(*block);
}

TEST_F(RemoteDefinitionTest, is_empty_where_the_node_does_not_say_it) {
  Acme acme{false};
  test::MirroredContainer there{"there"};
  there.load(acme, "acme");
  look();
  ASSERT_TRUE(bell.until([&] { return looking.found.lock()->has_value(); }));
  EXPECT_STREQ((*looking.found.lock())->first->definition, "");
}

}  // namespace
}  // namespace nacelle::record
