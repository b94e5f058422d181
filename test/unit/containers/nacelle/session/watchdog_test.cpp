// SPDX-License-Identifier: Apache-2.0
#include "session/watchdog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "support/manual_clock.hpp"
#include "unit/containers/nacelle/notify_socket.hpp"

namespace nacelle::session {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class WatchdogTest : public ::testing::Test {
 protected:
  [[nodiscard]] static process::ServiceManager with(const test::NotifySocket& socket, const char* period) {
    ::setenv("NOTIFY_SOCKET", socket.name().c_str(), 1);
    if (period != nullptr) ::setenv("WATCHDOG_USEC", period, 1);
    return process::ServiceManager::take_from_environment();
  }
  /// Lets so much time pass, and serves the watchdog when it is due. Returns how often it was fed.
  int feeds_within(Duration time) {
    int fed = count_feeds();
    for (const MonotonicTime end = clock_.now() + time; watchdog_.next_due() && *watchdog_.next_due() <= end;) {
      clock_.advance(std::max(Duration::zero(), *watchdog_.next_due() - clock_.now()));
      watchdog_.work();
      fed += count_feeds();  // the socket holds about ten
    }
    return fed;
  }
  int count_feeds() const {
    int fed = 0;
    for (std::string told = socket_.receive(); !told.empty(); told = socket_.receive()) {
      EXPECT_EQ(told, "WATCHDOG=1");
      ++fed;
    }
    return fed;
  }

  test::NotifySocket socket_;
  test::ManualClock clock_;
  process::ServiceManager manager_ = with(socket_, "10000000");
  std::string why_not_;
  std::vector<std::string> said_;
  Watchdog watchdog_{manager_, [this] { return why_not_; }, clock_,
                     [this](const std::string& line) { said_.push_back(line); }};
};

TEST_F(WatchdogTest, is_fed_four_times_in_its_period_from_the_beginning_on) {
  EXPECT_EQ(feeds_within(100s), 0) << "the robot is not up";
  watchdog_.begin();
  EXPECT_EQ(feeds_within(99s), 40);
}

TEST_F(WatchdogTest, is_not_fed_while_something_has_stalled) {
  watchdog_.begin();
  EXPECT_EQ(feeds_within(5s), 3);
  why_not_ = "executor 'ekf' has made no progress";
  EXPECT_EQ(feeds_within(20s), 0);
  why_not_.clear();
  EXPECT_EQ(feeds_within(5s), 2);
  EXPECT_THAT(said_,
              ElementsAre(HasSubstr("is not fed: executor 'ekf' has made no progress"), HasSubstr("is fed again")));
}

TEST_F(WatchdogTest, is_not_fed_more_often_by_a_thread_that_asks_all_the_time) {
  watchdog_.begin();
  for (int turn = 0; turn < 100; ++turn) watchdog_.work();
  EXPECT_EQ(feeds_within(0s), 1);
}

TEST_F(WatchdogTest, does_nothing_if_the_service_has_none) {
  const auto manager = with(socket_, nullptr);
  Watchdog none{manager, [] { return std::string{}; }, clock_, [](const std::string&) {}};
  none.begin();
  EXPECT_FALSE(none.next_due());
}

}  // namespace
}  // namespace nacelle::session
