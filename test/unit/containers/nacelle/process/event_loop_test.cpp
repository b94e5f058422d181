// SPDX-License-Identifier: Apache-2.0
#include "process/event_loop.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <new>
#include <stdexcept>

#include "nacelle/base/bell.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::process {
namespace {

/// A descriptor that other code has closed: no file has this number.
constexpr int kClosed = 1'000'000;

constexpr std::size_t kLimit = 256;

/// The limit of open files, which is that of poll(), for as long as it lives.
class LowLimit {
 public:
  LowLimit() {
    EXPECT_EQ(getrlimit(RLIMIT_NOFILE, &before_), 0);
    const rlimit low{kLimit, before_.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  }
  LowLimit(const LowLimit&) = delete;
  LowLimit& operator=(const LowLimit&) = delete;
  ~LowLimit() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

class EventLoopTest : public ::testing::Test {
 protected:
  void turn() { loop_.turn(Duration::zero()); }
  /// A task without a descriptor that is due at `due_`.
  void add_due(std::string name) {
    loop_.add({.name = std::move(name),
               .watch = {},
               .next_due = [this] { return due_; },
               .serve =
                   [this](auto) {
                     ++served_;
                     due_.reset();
                   },
               .shed = {}});
  }
  test::ManualClock clock_;
  EventLoop loop_{clock_};
  Bell bell_;
  std::optional<MonotonicTime> due_;
  int served_ = 0;
};

TEST_F(EventLoopTest, a_task_is_served_when_its_descriptor_is_ready_and_only_then) {
  loop_.add(on_readable("a", bell_.descriptor(), [this] {
    ++served_;
    bell_.silence();
  }));
  turn();
  EXPECT_EQ(served_, 0);
  bell_.ring();
  turn();
  turn();
  EXPECT_EQ(served_, 1);
}

TEST_F(EventLoopTest, a_task_is_served_when_it_is_due_and_only_then) {
  add_due("a");
  turn();
  due_ = clock_.now() + 1s;
  turn();
  EXPECT_EQ(served_, 0);
  clock_.advance(1s);
  loop_.turn(std::nullopt);  // it does not wait: a deadline is due now
  EXPECT_EQ(served_, 1);
  turn();
  EXPECT_EQ(served_, 1);
}

TEST_F(EventLoopTest, tasks_that_are_ready_together_are_served_in_their_order) {
  std::string order;
  for (const char* name : {"a", "b", "c"}) {
    loop_.add(on_readable(name, bell_.descriptor(), [&order, name] { order += name; }));
  }
  bell_.ring();
  turn();
  EXPECT_EQ(order, "abc");
}

TEST_F(EventLoopTest, a_task_sees_its_own_descriptors_only) {
  Bell other;
  std::vector<int> seen;
  const auto look = [&](std::span<const pollfd> waits) {
    for (const pollfd& wait : waits) seen.push_back(wait.fd);
  };
  loop_.add(on_readable("first", bell_.descriptor(), [] {}));
  loop_.add({.name = "second",
             .watch =
                 [&](std::vector<pollfd>& waits) {
                   waits.push_back({-1, POLLIN, 0});
                   waits.push_back({other.descriptor(), POLLIN, 0});
                 },
             .next_due = {},
             .serve = look,
             .shed = {}});
  other.ring();
  turn();
  EXPECT_EQ(seen, (std::vector<int>{-1, other.descriptor()}));
}

TEST_F(EventLoopTest, a_task_that_throws_is_served_again_and_does_not_hold_up_the_others) {
  int tried = 0;
  loop_.add(on_readable("a", bell_.descriptor(), [&] {
    bell_.silence();
    if (++tried == 1) throw std::runtime_error{"no memory"};
  }));
  due_ = clock_.now();
  add_due("b");
  bell_.ring();
  testing::internal::CaptureStderr();
  turn();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "nacelle: container: a: no memory\n");
  EXPECT_EQ(served_, 1);
  loop_.turn(std::nullopt);  // 100 ms at most, though nothing is ready
  EXPECT_EQ(tried, 2);
  turn();
  EXPECT_EQ(tried, 2);
}

TEST_F(EventLoopTest, a_task_that_cannot_list_what_it_waits_for_is_left_out_for_one_turn) {
  bool has_memory = false;
  loop_.add({.name = "a",
             .watch =
                 [&](std::vector<pollfd>& waits) {
                   waits.push_back({bell_.descriptor(), POLLIN, 0});
                   if (!has_memory) throw std::bad_alloc{};
                 },
             .next_due = {},
             .serve = [this](auto) { ++served_; },
             .shed = {}});
  bell_.ring();
  testing::internal::CaptureStderr();
  const auto begin = std::chrono::steady_clock::now();
  loop_.turn(std::nullopt);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 100ms)
      << "descriptors appended before the exception do not wake the loop";
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "nacelle: container: a: std::bad_alloc\n");
  EXPECT_EQ(served_, 0);
  has_memory = true;
  turn();
  EXPECT_EQ(served_, 1);
}

TEST_F(EventLoopTest, ends_after_the_task_that_ends_it_with_its_reason) {
  loop_.add(on_readable("a", bell_.descriptor(), [this] { loop_.end(Problem{"program", "it ended", ""}); }));
  due_ = clock_.now();
  add_due("b");
  bell_.ring();
  const auto why = loop_.run();
  ASSERT_TRUE(why);
  EXPECT_EQ(why->what, "it ended");
  EXPECT_EQ(served_, 0);
  EXPECT_FALSE(loop_.has_lost_a_descriptor());
}

TEST_F(EventLoopTest, a_closed_descriptor_ends_it) {
  loop_.add(on_readable("a", kClosed, [this] { ++served_; }));
  const auto why = loop_.run();
  ASSERT_TRUE(why);
  EXPECT_TRUE(loop_.has_lost_a_descriptor());
  EXPECT_EQ(served_, 0);
}

TEST_F(EventLoopTest, a_descriptor_of_others_that_is_closed_is_their_tasks_affair) {
  short events = 0;
  loop_.add({.name = "guests",
             .watch =
                 [&](std::vector<pollfd>& waits) {
                   waits.push_back({kClosed, POLLIN, 0});
                 },
             .next_due = {},
             .serve = [&](std::span<const pollfd> waits) { events = waits.front().revents; },
             .shed = [] {}});
  turn();
  EXPECT_EQ(events, POLLNVAL);
  EXPECT_FALSE(loop_.has_lost_a_descriptor());
}

TEST_F(EventLoopTest, gives_up_descriptors_of_others_when_there_are_more_than_poll_takes) {
  const LowLimit limit;
  std::size_t guests = 4 * kLimit;
  int shed = 0;
  loop_.add({.name = "guests",
             .watch =
                 [&](std::vector<pollfd>& waits) {
                   waits.insert(waits.end(), guests, pollfd{-1, POLLIN, 0});
                 },
             .next_due = {},
             .serve = [](auto) {},
             .shed =
                 [&] {
                   ++shed;
                   guests /= 8;
                 }});
  loop_.add(on_readable("own", bell_.descriptor(), [this] {
    ++served_;
    bell_.silence();
  }));
  bell_.ring();
  turn();
  EXPECT_EQ(shed, 1);
  EXPECT_EQ(served_, 1) << "the robot's own go on";
  bell_.ring();
  turn();
  EXPECT_EQ(shed, 1);
  EXPECT_EQ(served_, 2);
}

TEST_F(EventLoopTest, ends_when_no_task_can_shed_descriptors) {
  const LowLimit limit;
  loop_.add({.name = "own",
             .watch =
                 [&](std::vector<pollfd>& waits) {
                   waits.insert(waits.end(), 4 * kLimit, pollfd{-1, POLLIN, 0});
                 },
             .next_due = {},
             .serve = [](auto) {},
             .shed = {}});
  const auto why = loop_.run();
  ASSERT_TRUE(why);
  EXPECT_EQ(why->what, "poll failed: Invalid argument");
}

}  // namespace
}  // namespace nacelle::process
