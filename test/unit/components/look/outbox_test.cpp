// SPDX-License-Identifier: Apache-2.0
#include "look/model/outbox.hpp"

#include <gtest/gtest.h>

namespace nacelle::look {
namespace {

using namespace std::chrono_literals;

std::shared_ptr<const Encoded> message(std::size_t size, std::uint8_t mark = 0) {
  return std::make_shared<const Encoded>(Encoded{0, Bytes(size, mark)});
}
constexpr MonotonicTime kNow{10s};

TEST(Outbox, answers_go_first_and_all_keep_their_order) {
  Outbox box{0};
  box.message(1, message(10, 1));
  box.message(2, message(10, 2));
  ASSERT_TRUE(box.answer(false, {'a'}));
  ASSERT_TRUE(box.answer(true, {'b'}));
  auto item = box.next(kNow);
  ASSERT_TRUE(item);
  EXPECT_EQ(item->answer, Bytes{'a'});
  EXPECT_FALSE(item->is_binary);
  EXPECT_EQ(box.next(kNow)->answer, Bytes{'b'});
  item = box.next(kNow);
  ASSERT_TRUE(item->message);
  EXPECT_EQ(item->subscription, 1U);
  EXPECT_EQ(box.next(kNow)->subscription, 2U);
  EXPECT_FALSE(box.next(kNow));
  EXPECT_EQ(box.dropped(), 0U);
}

TEST(Outbox, of_large_messages_the_newest_waits) {
  Outbox box{0};
  box.message(1, message(100'000, 1));
  box.message(2, message(100, 7));
  box.message(1, message(100'000, 2));
  EXPECT_EQ(box.next(kNow)->subscription, 2U);
  EXPECT_EQ(box.next(kNow)->message->bytes[0], 2);
  EXPECT_FALSE(box.next(kNow));
  EXPECT_EQ(box.dropped(), 1U);
}

TEST(Outbox, of_small_messages_as_many_wait_as_have_room) {
  Outbox box{0};
  constexpr std::size_t kSize = Outbox::kSmallBytes / 4;
  for (std::uint8_t i = 0; i < 6; ++i) box.message(1, message(kSize, i));
  EXPECT_EQ(box.dropped(), 2U);
  for (std::uint8_t i = 2; i < 6; ++i) EXPECT_EQ(box.next(kNow)->message->bytes[0], i);
}

TEST(Outbox, a_budget_is_kept_over_time_whatever_the_size_of_messages) {
  Outbox box{1000};
  std::size_t sent = 0;
  for (int tick = 0; tick < 1000; ++tick) {  // 40 s
    const MonotonicTime now = kNow + tick * 40ms;
    box.message(1, message(tick % 3 == 0 ? 900 : 20));
    while (const auto item = box.next(now)) sent += item->message->bytes.size();
  }
  EXPECT_LE(sent, 40'000U + 250 + 900) << "the rate, what was saved up, and one that was larger";
  EXPECT_GE(sent, 38'000U);
  EXPECT_GT(box.dropped(), 0U);
}

TEST(Outbox, answers_do_not_wait_for_the_budget) {
  Outbox box{1};
  box.message(1, message(1000));
  EXPECT_TRUE(box.has_next(kNow));
  ASSERT_TRUE(box.next(kNow));
  box.message(1, message(1000));
  EXPECT_FALSE(box.has_next(kNow + 1s));
  ASSERT_TRUE(box.answer(false, {'a'}));
  EXPECT_EQ(box.next(kNow + 1s)->answer, Bytes{'a'});
}

TEST(Outbox, gives_up_a_viewer_that_does_not_read_its_answers) {
  Outbox box{0};
  EXPECT_TRUE(box.answer(true, Bytes(Outbox::kMostAnswers + 1))) << "one may be of any size";
  EXPECT_FALSE(box.answer(true, Bytes(1)));
  ASSERT_TRUE(box.next(kNow));
  EXPECT_TRUE(box.answer(true, Bytes(1)));
}

TEST(Outbox, forgets_a_subscription_that_has_ended) {
  Outbox box{0};
  box.message(1, message(1));
  box.message(2, message(1));
  box.forget(1);
  EXPECT_EQ(box.next(kNow)->subscription, 2U);
  EXPECT_FALSE(box.next(kNow));
}

}  // namespace
}  // namespace nacelle::look
