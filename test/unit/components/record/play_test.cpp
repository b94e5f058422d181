// SPDX-License-Identifier: Apache-2.0
// The player alone, and as a component in a container.
#include <fstream>
#include <std_msgs/msg/int32.hpp>

#include "nacelle/runtime/test_container.hpp"
#include "record/component/player.hpp"
#include "record/component/recording.hpp"
#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using std_msgs::msg::Int32;

constexpr std::uint64_t kStart = 1'800'000'000'000'000'000, kMillisecond = 1'000'000;

class PlayTest : public TemporaryFolder {
 protected:
  PlayTest() {
    auto made = Recording::begin({.folder = path("bag"), .keep_free = 0});
    EXPECT_TRUE(made);
    Recording& recording = **made;
    const auto kept = recording.add_topic("/kept", Int32::message_type(), {QoS(1).transient_local()});
    const auto numbers = recording.add_topic("/numbers", Int32::message_type(), {QoS(100).deadline(500ms)});
    Int32 message;
    message.data = 1000;
    recording.write(kept, &message, {kStart, kStart});
    for (int i = 1; i <= 5; ++i) {
      message.data = i;
      const auto at = kStart + static_cast<std::uint64_t>(i) * 20 * kMillisecond;
      recording.write(numbers, &message, {at, at});
    }
    EXPECT_FALSE(recording.finish());
  }
  [[nodiscard]] std::unique_ptr<Player> play(Player::Options options = {}) {
    auto recording = OpenRecording::open(path("bag"));
    EXPECT_TRUE(recording) << recording.error().text();
    options.from = recording->messages->first();
    options.to = recording->messages->last();
    writer_ =
        container_.container().transport().create_writer({"/numbers", &Int32::message_type(), QoS(100), "/player"});
    std::vector<Player::Topic> topics(2);
    for (std::size_t i = 0; i < 2; ++i) {
      if (recording->messages->topics()[i].name == "/numbers")
        topics[i] = {&Int32::message_type(), writer_.get(), false};
    }
    return std::make_unique<Player>(std::move(*recording), std::move(topics), std::move(options), clock_);
  }
  void wait_for_end(const Player& player) {
    while (!player.figures().has_ended) std::this_thread::yield();
  }

  runtime::TestContainer container_;

 private:
  const SystemClock clock_;
  std::unique_ptr<Writer> writer_;
};

TEST_F(PlayTest, keeps_the_time_between_messages) {
  auto numbers = container_.subscribe<Int32>("/numbers", QoS(100));
  const SystemClock clock;
  const MonotonicTime begin = clock.now();
  const auto player = play({.rate = 0.5});
  for (int i = 1; i <= 5; ++i) EXPECT_EQ(numbers.next().data, i);
  EXPECT_GE(clock.now() - begin, 200ms);
  wait_for_end(*player);
  EXPECT_EQ(player->figures().messages, 5U);
  EXPECT_DOUBLE_EQ(player->figures().seconds, 0.1);
  EXPECT_FALSE(player->play_next()) << "it has ended";
  EXPECT_FALSE(player->seek(kStart));
}

TEST_F(PlayTest, steps_seeks_and_goes_on) {
  auto numbers = container_.subscribe<Int32>("/numbers", QoS(100));
  const auto player = play({.starts_paused = true});
  EXPECT_TRUE(player->is_paused());
  EXPECT_TRUE(player->play_next());  // the first one is on a topic that is not played
  EXPECT_TRUE(player->play_next());
  EXPECT_EQ(numbers.next().data, 1);
  EXPECT_FALSE(numbers.waits(0s));
  EXPECT_FALSE(player->seek(kStart - 1));
  EXPECT_TRUE(player->seek(kStart + 50 * kMillisecond));
  EXPECT_TRUE(player->play_next());
  EXPECT_EQ(numbers.next().data, 3);
  EXPECT_FALSE(player->set_rate(0.0));
  EXPECT_FALSE(player->set_rate(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_TRUE(player->set_rate(1e300));
  player->pause(false);
  EXPECT_EQ(numbers.next().data, 4);
  EXPECT_EQ(numbers.next().data, 5);
  wait_for_end(*player);
}

TEST_F(PlayTest, begins_again_and_tells_the_time) {
  // 20 rounds fit into the reader's queue: 0.2 s at this rate, in which the test need not run.
  auto numbers = container_.subscribe<Int32>("/numbers", QoS(100));
  Guarded<std::vector<WallTime>> times;
  const auto player = play({.rate = 10.0, .loops = true, .clock_period = 1ms, .publish_clock = [&](WallTime time) {
                              times.lock()->push_back(time);
                            }});
  for (int i = 0; i < 12; ++i) EXPECT_EQ(numbers.next().data, 1 + i % 5);
  EXPECT_FALSE(player->figures().has_ended);
  const std::vector<WallTime> told = *times.lock();
  for (const WallTime& time : told) {
    EXPECT_GE(time.since_origin.count(), static_cast<std::int64_t>(kStart));
    EXPECT_LE(time.since_origin.count(), static_cast<std::int64_t>(kStart + 100 * kMillisecond));
  }
}

TEST_F(PlayTest, ends_though_it_loops_where_nothing_can_be_played_again) {
  {
    auto empty = Recording::begin({.folder = path("empty"), .keep_free = 0});
    auto single = Recording::begin({.folder = path("single"), .keep_free = 0});
    ASSERT_TRUE(empty && single);
    const Int32 message;
    (*single)->write((*single)->add_topic("/numbers", Int32::message_type(), {QoS(100)}), &message, {kStart, kStart});
  }
  for (const char* name : {"empty", "single"}) {
    auto recording = OpenRecording::open(path(name));
    ASSERT_TRUE(recording) << recording.error().text();
    const std::uint64_t from = recording->messages->first(), to = recording->messages->last();
    std::vector<Player::Topic> topics(recording->messages->topics().size());
    const SystemClock clock;
    const Player player{std::move(*recording), std::move(topics), {.from = from, .to = to, .loops = true}, clock};
    wait_for_end(player);
  }
}

// One message, at the begin of 100 ms: the next round begins when they are over.
TEST_F(PlayTest, a_round_lasts_as_long_as_the_recording) {
  auto kept = container_.container().transport().create_writer({"/kept", &Int32::message_type(), QoS(1), "/player"});
  auto reader = container_.subscribe<Int32>("/kept", QoS(10));
  auto recording = OpenRecording::open(path("bag"));
  ASSERT_TRUE(recording);
  std::vector<Player::Topic> topics(2);
  for (std::size_t i = 0; i < 2; ++i) {
    if (recording->messages->topics()[i].name == "/kept") topics[i] = {&Int32::message_type(), kept.get(), false};
  }
  const SystemClock clock;
  const MonotonicTime begin = clock.now();
  const Player player{std::move(*recording),
                      std::move(topics),
                      {.from = kStart, .to = kStart + 50 * kMillisecond, .loops = true},
                      clock};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(reader.next().data, 1000);
  EXPECT_GE(clock.now() - begin, 150ms);
}

TEST_F(PlayTest, decodes_nothing_that_nobody_reads) {
  const auto player = play({.rate = 100.0});
  wait_for_end(*player);
  EXPECT_EQ(player->figures().messages, 0U);
  EXPECT_EQ(player->figures().unread, 5U);
}

TEST_F(PlayTest, as_a_component_publishes_with_the_recorded_qos) {
  // A publisher that promises no deadline would not match it.
  auto numbers = container_.subscribe<Int32>("/other", QoS(100).deadline(1s));
  runtime::LoadRequest request;
  request.plugin = "nacelle::record::PlayComponent";
  request.parameters = {{"storage.uri", path("bag")},
                        {"play.rate", 100.0},
                        {"play.topics", std::vector<std::string>{"numbers", "/kept"}}};
  request.remaps = {make_remap_rule("/numbers", "/other").value()};
  const auto loaded = container_.container().load(request);
  ASSERT_TRUE(loaded) << loaded.error().text();
  for (const Transition step : {Transition::Configure, Transition::Activate})
    EXPECT_EQ(container_.container().trigger(loaded->id, step).reason, "");
  for (int i = 1; i <= 5; ++i) EXPECT_EQ(numbers.next().data, i);
  auto late = container_.subscribe<Int32>("/kept", QoS(1).transient_local());
  EXPECT_EQ(late.next().data, 1000) << "as its publisher offered when it was recorded";
}

TEST_F(PlayTest, as_a_component_refuses_what_it_cannot_play) {
  const auto refused = [&](std::map<std::string, ParameterValue> parameters) {
    std::string why;
    try {
      container_.start("nacelle::record::PlayComponent", std::move(parameters));
    } catch (const std::runtime_error& error) { why = error.what(); }
    EXPECT_TRUE(container_.container().unload(container_.container().find("rosbag2_player")->id));
    return why;
  };
  EXPECT_NE(refused({}).find("no recording is named"), std::string::npos);
  EXPECT_NE(refused({{"storage.uri", path("none")}}).find("No such file"), std::string::npos);
  EXPECT_NE(refused({{"storage.uri", path("bag")}, {"play.start_offset", 7.0}}).find("has only 0.1 s"),
            std::string::npos);
  EXPECT_NE(
      refused({{"storage.uri", path("bag")}, {"play.exclude_regex", std::string{"["}}}).find("play.exclude_regex"),
      std::string::npos);
  EXPECT_NE(refused({{"storage.uri", path("bag")}, {"play.topics", std::vector<std::string>{"number"}}})
                .find("has no topic /number; did you mean '/numbers'?"),
            std::string::npos);
  std::ofstream{path("old.db3")} << "SQLite format 3";
  EXPECT_NE(refused({{"storage.uri", path("old.db3")}}).find("nacelle bag convert"), std::string::npos);
  std::filesystem::resize_file(path("bag/bag_0.mcap"), 500);
  EXPECT_NE(refused({{"storage.uri", path("bag")}}).find("nacelle bag recover"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::record
