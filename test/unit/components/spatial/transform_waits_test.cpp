// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/transform_waits.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "nacelle/spatial/transform_buffer.hpp"
#include "support/recording_host.hpp"

namespace nacelle::spatial {
namespace {

class Waits : public ::testing::Test {
 protected:
  using Found = Result<StampedTransform, LookupFault>;

  void put(double seconds, double x) {
    EXPECT_TRUE(buffer_->insert("odom", "base", WallTime{from_seconds(seconds)}, RigidTransform::planar(x, 0, 0),
                                Permanence::Dynamic));
  }
  auto into(std::optional<Found>& answer) {
    return [&answer](const Found& found) { answer = found; };
  }
  test::RecordingContext context_;
  Node node_{"waits", NodeOptions{context_}};
  TransformBufferPtr buffer_ = make_transform_buffer();
  TransformWaits<TransformBuffer> waits_{node_, buffer_};
};

TEST_F(Waits, answer_at_once_what_is_there) {
  put(1.0, 10.0);
  std::optional<Found> answer;
  EXPECT_EQ(waits_.when("odom", "base", WallTime{1s}, 100ms, into(answer)), 0U);
  ASSERT_TRUE(answer && *answer);
  EXPECT_EQ((*answer)->X_TS.translation_m.x(), 10.0);
}

TEST_F(Waits, answer_when_the_transform_comes) {
  put(1.0, 10.0);
  std::optional<Found> answer, through;
  EXPECT_NE(waits_.when("odom", "base", WallTime{1500ms}, 100ms, into(answer)), 0U);
  EXPECT_NE(waits_.when("odom", WallTime{2s}, "base", WallTime{1500ms}, "odom", 100ms, into(through)), 0U);
  context_.advance(50ms);
  EXPECT_FALSE(answer || through);
  put(2.0, 20.0);
  context_.spin();
  ASSERT_TRUE(answer && *answer);
  EXPECT_EQ((*answer)->X_TS.translation_m.x(), 15.0);
  ASSERT_TRUE(through && *through);
  EXPECT_EQ((*through)->X_TS.translation_m.x(), 15.0);
  EXPECT_EQ(waits_.size(), 0U);
}

TEST_F(Waits, say_what_is_missing_when_the_time_is_up) {
  put(1.0, 10.0);
  put(1.1, 11.0);
  std::optional<Found> answer;
  EXPECT_NE(waits_.when("odom", "base", WallTime{2s}, 100ms, into(answer)), 0U);
  context_.advance(80ms);
  EXPECT_FALSE(answer);
  context_.advance(40ms);
  ASSERT_TRUE(answer && !*answer);
  EXPECT_EQ(answer->error().error, TransformError::ForwardExtrapolation);
}

TEST_F(Waits, do_not_answer_what_was_cancelled_and_may_be_added_from_an_answer) {
  std::optional<Found> cancelled, second;
  const auto number = waits_.when("odom", "base", WallTime{}, 100ms, into(cancelled));
  static_cast<void>(waits_.when("odom", "base", WallTime{}, 100ms, [&](const Found&) {
    static_cast<void>(waits_.when("odom", "base", WallTime{5s}, 100ms, into(second)));
  }));
  waits_.cancel(number);
  put(1.0, 10.0);
  put(5.0, 50.0);
  context_.spin();
  EXPECT_FALSE(cancelled);
  ASSERT_TRUE(second && *second);
  EXPECT_EQ((*second)->X_TS.translation_m.x(), 50.0);
}

TEST_F(Waits, nothing_is_answered_after_they_are_gone) {
  std::optional<Found> answer;
  {
    TransformWaits<TransformBuffer> short_lived{node_, buffer_};
    static_cast<void>(short_lived.when("odom", "base", WallTime{}, 100ms, into(answer)));
  }
  put(1.0, 10.0);
  context_.advance(200ms);
  EXPECT_FALSE(answer);
}

}  // namespace
}  // namespace nacelle::spatial
