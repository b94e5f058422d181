// SPDX-License-Identifier: Apache-2.0
#include "session/clock_watch.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

namespace nacelle::session {
namespace {

class SetClock final : public Clock {
 public:
  MonotonicTime now() const override { return now_; }
  WallTime wall_now() const override { return {1'700'000'000s + now_.since_origin + offset}; }
  void pass(Duration time) { now_ += time; }
  Duration offset{};

 private:
  MonotonicTime now_{100s};
};

class CountingAlarm final : public ClockAlarm {
 public:
  int descriptor() const override { return -1; }
  void take() override { ++taken; }
  int taken = 0;
};

TEST(ClockWatch, tells_each_step_once_in_either_sense) {
  SetClock clock;
  CountingAlarm alarm;
  ClockWatch watch{clock, alarm};
  EXPECT_FALSE(watch.look());
  clock.offset -= 5s;
  EXPECT_EQ(watch.look(), std::optional<Duration>{-5s});
  EXPECT_FALSE(watch.look());
  clock.offset += 1h;
  EXPECT_EQ(watch.look(), std::optional<Duration>{1h});
  EXPECT_FALSE(watch.look());
  EXPECT_EQ(alarm.taken, 5);
}

TEST(ClockWatch, takes_slewing_and_the_passing_of_time_for_no_step) {
  SetClock clock;
  CountingAlarm alarm;
  ClockWatch watch{clock, alarm};
  for (int minute = 0; minute < 600; ++minute) {
    clock.pass(60s);
    clock.offset += 30ms;  // 500 ppm
    ASSERT_FALSE(watch.look()) << minute;
  }
}

TEST(KernelClockAlarm, is_quiet_while_the_clock_is_not_set_and_stays_armed) {
  const SystemClock clock;
  const auto alarm = make_kernel_clock_alarm();
  ClockWatch watch{clock, *alarm};
  ASSERT_GE(alarm->descriptor(), 0);
  for (int i = 0; i < 2; ++i) {
    pollfd wait{alarm->descriptor(), POLLIN, 0};
    EXPECT_EQ(::poll(&wait, 1, 0), 0);
    EXPECT_FALSE(watch.look());
  }
}

TEST(TestClock, is_set_through_its_fifo_and_ignores_what_is_no_number) {
  const std::string path = ::testing::TempDir() + "nacelle_test_clock";
  ::unlink(path.c_str());
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  auto opened = TestClock::open(path);
  ASSERT_TRUE(opened);
  TestClock& clock = *opened.value();
  ClockWatch watch{clock, clock};

  const int writer = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  const std::string_view lines = "-5\nfive\n1e300\n3600\n";
  ASSERT_EQ(::write(writer, lines.data(), lines.size()), static_cast<ssize_t>(lines.size()));
  ::close(writer);

  const auto step = watch.look();
  ASSERT_TRUE(step);
  EXPECT_NEAR(to_seconds(*step), 3595.0, 0.05);
  EXPECT_FALSE(TestClock::open("/no/such/fifo"));
  ::unlink(path.c_str());
}

}  // namespace
}  // namespace nacelle::session
