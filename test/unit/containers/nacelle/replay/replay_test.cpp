// SPDX-License-Identifier: Apache-2.0
#include "replay/replay.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <map>
#include <memory>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>
#include <vector>

#include "benchmark/support/recipe.hpp"
#include "record/model/bag_metadata.hpp"
#include "record/protocol/mcap_writer.hpp"
#include "support/places.hpp"
#include "unit/components/record/seen_file.hpp"

namespace nacelle::replay {
namespace {

using record::MemoryFile;
using std_msgs::msg::String;
using tf2_msgs::msg::TFMessage;

constexpr std::uint64_t kBegin = 1'700'000'000'000'000'000, kMilli = 1'000'000;

/// Publishes on /said what it hears on /heard and when its timer ticks, each with the node's time.
class Parrot final : public bench::Recipe {
 public:
  explicit Parrot(Duration period, std::string out = "/said") : period_(period), out_(std::move(out)) {}
  std::shared_ptr<void> build(LifecycleNode& node) override {
    struct Parts {
      std::shared_ptr<Publisher<String>> out;
      std::shared_ptr<Subscription<String>> in;
      std::shared_ptr<Timer> timer;
    };
    auto parts = std::make_shared<Parts>();
    parts->out = node.create_publisher<String>(out_, QoS(10));
    const auto say = [&node, out = parts->out](const std::string& what) {
      String message;
      message.data =
          fmt::format("{} {}", (node.now().nanoseconds() - static_cast<std::int64_t>(kBegin)) / 1'000'000, what);
      out->publish(message);
    };
    parts->in = node.create_subscription<String>("/heard", QoS(10), [say](const String& in) { say(in.data); });
    parts->timer = node.create_timer(period_, [say] { say("tick"); });
    return parts;
  }

 private:
  const Duration period_;
  const std::string out_;
};

/// Broadcasts odom -> base, and says whose transforms it hears.
class Broadcaster final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    struct Parts {
      std::shared_ptr<Publisher<TFMessage>> transforms;
      std::shared_ptr<Publisher<String>> out;
      std::shared_ptr<Subscription<TFMessage>> in;
      std::unique_ptr<FrameClaim> claim;
    };
    auto parts = std::make_shared<Parts>();
    parts->transforms = node.create_publisher<TFMessage>("/tf", QoS(100));
    parts->claim = node.claim_frame("odom", "base", FrameClaimKind::Primary, {});
    parts->out = node.create_publisher<String>("/children", QoS(10));
    parts->in = node.create_subscription<TFMessage>("/tf", QoS(100), [out = parts->out](const TFMessage& in) {
      String message;
      for (const auto& one : in.transforms) message.data += one.child_frame_id + " ";
      out->publish(message);
    });
    return parts;
  }
};

struct Said {
  std::uint64_t at_ms;
  std::string topic, text;
};

struct ReplayTest : ::testing::Test {
  MemoryFile recorded;
  std::vector<std::pair<std::string, std::string>> published;  // of a replay: topic, "time text"

  /// A recording of texts, which were said so many milliseconds after its beginning.
  void record(const std::vector<Said>& all, const QoS& offered = QoS(100)) {
    record::McapWriter writer{recorded, {}};
    ASSERT_TRUE(writer.start());
    for (const auto& [at_ms, topic, text] : all) {
      String message;
      message.data = text;
      write(writer, topic, message, at_ms, offered);
    }
    ASSERT_TRUE(writer.finish());
  }
  template <typename T>
  static void write(record::McapWriter& writer, const std::string& topic, const T& message, std::uint64_t at_ms,
                    const QoS& offered = QoS(100)) {
    const auto& type = T::message_type();
    const auto schema = writer.add_schema(type.name, "ros2msg", type.definition);
    const auto channel = writer.add_channel(
        *schema, topic, "cdr",
        {{"topic_type_hash", type.hash}, {"offered_qos_profiles", record::offered_qos_profiles({offered})}});
    const Bytes bytes = msgs::to_cdr(message);
    const std::uint64_t time = kBegin + at_ms * kMilli;
    ASSERT_TRUE(writer.write({*channel, 0, time, time, {bytes}}));
  }

  static launch::ComponentPlan part(const std::string& name, bench::Recipe& recipe) {
    launch::ComponentPlan component;
    component.plugin = "nacelle::bench::Part";
    component.name = name;
    component.namespace_ = "/";
    launch::Parameter parameter;
    parameter.name = "recipe";
    parameter.value = static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&recipe));
    component.parameters.push_back(std::move(parameter));
    return component;
  }

  /// Returns the bytes of the output.
  Bytes replay(const launch::Plan& plan, bool with_inputs = false) {
    auto messages = record::OrderedMessages::open({&recorded});
    EXPECT_TRUE(messages);
    std::vector<Role> roles;
    for (const auto& component : plan.components) roles.push_back({component.full_name(), ""});
    Replay::Options options;
    options.component_folders = {test::component_folder()};
    options.find_type = [](const std::string& name) -> const msgs::MessageType* {
      for (const auto* const type : {&String::message_type(), &TFMessage::message_type()}) {
        if (name == type->name) return type;
      }
      return nullptr;
    };
    options.writes_inputs = with_inputs;
    MemoryFile out;
    {
      Replay replay{**messages, plan, roles, out, std::move(options)};
      const auto up = replay.bring_up();
      EXPECT_TRUE(up) << up.error().text();
      EXPECT_TRUE(replay.run([](double) { return true; }));
      figures = replay.figures();
    }
    published.clear();
    auto written = record::OrderedMessages::open({&out});
    EXPECT_TRUE(written);
    while (const auto* message = (*written)->next()) {
      String text;
      EXPECT_TRUE(msgs::from_cdr(message->data, text));
      published.emplace_back((*written)->topics()[message->topic].name,
                             fmt::format("{}: {}", (message->log_time - kBegin) / kMilli, text.data));
    }
    return out.bytes;
  }
  ReplayFigures figures;
};

using Published = std::vector<std::pair<std::string, std::string>>;

TEST_F(ReplayTest, messages_and_timers_come_at_their_recorded_time) {
  record({{0, "/heard", "first"}, {150, "/heard", "second"}, {420, "/other", "x"}});
  Parrot parrot{100ms};
  launch::Plan plan;
  plan.components = {part("parrot", parrot)};
  replay(plan);
  EXPECT_EQ(published, (Published{{"/said", "0: 0 first"},
                                  {"/said", "100: 100 tick"},
                                  {"/said", "150: 150 second"},
                                  {"/said", "200: 200 tick"},
                                  {"/said", "300: 300 tick"},
                                  {"/said", "400: 400 tick"}}));
  EXPECT_EQ(figures.inputs.played, 2U);
  EXPECT_EQ(figures.inputs.unread, 1U);
  EXPECT_EQ(figures.outputs, (std::map<std::string, std::uint64_t>{{"/said", 6}}));
  EXPECT_DOUBLE_EQ(figures.seconds, 0.42);
}

TEST_F(ReplayTest, a_timer_that_is_due_with_a_message_comes_before_it) {
  record({{0, "/other", ""}, {100, "/heard", "both"}});
  Parrot parrot{100ms};
  launch::Plan plan;
  plan.components = {part("parrot", parrot)};
  replay(plan);
  EXPECT_EQ(published, (Published{{"/said", "100: 100 tick"}, {"/said", "100: 100 both"}}));
}

TEST_F(ReplayTest, ten_runs_write_the_same_bytes) {
  std::vector<Said> all;
  for (std::uint64_t i = 0; i < 500; ++i) all.push_back({i * 7, i % 3 == 0 ? "/heard" : "/other", std::to_string(i)});
  record(all);
  Parrot first{10ms}, second{10ms, "/echoed"};
  launch::Plan plan;
  plan.components = {part("first", first), part("second", second)};
  const Bytes once = replay(plan);
  EXPECT_GT(published.size(), 900U);
  for (int i = 1; i < 10; ++i) EXPECT_EQ(replay(plan), once) << "run " << i;
}

TEST_F(ReplayTest, what_a_running_component_publishes_is_not_played) {
  record({{0, "/said", "recorded"}, {10, "/heard", "now"}});
  Parrot parrot{1s};
  launch::Plan plan;
  plan.components = {part("parrot", parrot)};
  replay(plan);
  EXPECT_EQ(published, (Published{{"/said", "10: 10 now"}}));
  EXPECT_EQ(figures.inputs.played, 1U);
}

TEST_F(ReplayTest, writes_the_inputs_when_it_is_told_to) {
  record({{0, "/said", "recorded"}, {10, "/heard", "now"}, {20, "/other", "x"}});
  Parrot parrot{1s};
  launch::Plan plan;
  plan.components = {part("parrot", parrot)};
  replay(plan, true);
  EXPECT_EQ(published, (Published{{"/heard", "10: now"}, {"/said", "10: 10 now"}, {"/other", "20: x"}}));
}

TEST_F(ReplayTest, a_deadline_is_missed_at_its_time) {
  record({{0, "/heard", "x"}, {60, "/heard", "x"}, {250, "/other", "x"}}, QoS(100).deadline(100ms));
  class Waiting final : public bench::Recipe {
    std::shared_ptr<void> build(LifecycleNode& node) override {
      auto out = node.create_publisher<String>("/late", QoS(10));
      SubscriptionOptions options;
      options.event_callbacks.deadline_callback = [out](QOSDeadlineRequestedInfo& info) {
        String message;
        message.data = std::to_string(info.total_count);
        out->publish(message);
      };
      QoS qos(10);
      qos.deadline(100ms);
      return node.create_subscription<String>(
          "/heard", qos, [](const String&) {}, options);
    }
  } waiting;
  launch::Plan plan;
  plan.components = {part("waiting", waiting)};
  replay(plan);
  EXPECT_EQ(published, (Published{{"/late", "160: 1"}}));
}

TEST_F(ReplayTest, of_recorded_transforms_those_that_running_components_claim_are_left_out) {
  record::McapWriter writer{recorded, {}};
  ASSERT_TRUE(writer.start());
  TFMessage both;
  both.transforms.resize(2);
  both.transforms[0].child_frame_id = "base";
  both.transforms[1].child_frame_id = "odom";
  write(writer, "/tf", both, 5);
  both.transforms.resize(1);
  write(writer, "/tf", both, 6);
  ASSERT_TRUE(writer.finish());
  Broadcaster broadcaster;
  launch::Plan plan;
  plan.components = {part("broadcaster", broadcaster)};
  replay(plan);
  EXPECT_EQ(published, (Published{{"/children", "5: odom "}}));
  EXPECT_EQ(figures.inputs.played, 1U);
}

TEST_F(ReplayTest, a_component_that_fails_is_named) {
  record({{0, "/heard", ""}});
  class Refusing final : public bench::Recipe {
    std::shared_ptr<void> build(LifecycleNode&) override { return nullptr; }
    std::function<std::string(Transition)> on_transition() override {
      return [](Transition step) { return step == Transition::Activate ? "no coffee" : ""; };
    }
  } refusing;
  auto messages = record::OrderedMessages::open({&recorded});
  ASSERT_TRUE(messages);
  launch::Plan plan;
  plan.components = {part("refusing", refusing)};
  for (const bool required : {true, false}) {
    plan.components[0].required = required;
    MemoryFile out;
    Replay replay{**messages,
                  plan,
                  {{"/refusing", ""}},
                  out,
                  {{test::component_folder()}, [](const auto&) -> const msgs::MessageType* { return nullptr; }}};
    const auto up = replay.bring_up();
    ASSERT_EQ(up.has_value(), !required);
    const std::string text = required ? up.error().text() : up->at(0).text();
    EXPECT_NE(text.find("/refusing could not activate: "), std::string::npos) << text;
    EXPECT_NE(text.find("no coffee"), std::string::npos) << text;
  }
}

TEST_F(ReplayTest, says_what_cannot_be_played) {
  record({{0, "/heard", "x"}});
  auto messages = record::OrderedMessages::open({&recorded});
  ASSERT_TRUE(messages);
  MemoryFile out;
  const launch::Plan nothing;  // the replay keeps a reference
  Replay replay{**messages, nothing, {}, out, {{}, [](const auto&) -> const msgs::MessageType* { return nullptr; }}};
  ASSERT_TRUE(replay.bring_up());
  EXPECT_EQ(replay.refused(), (std::vector<std::string>{"/heard: its type std_msgs/msg/String is not installed"}));
}

}  // namespace
}  // namespace nacelle::replay
