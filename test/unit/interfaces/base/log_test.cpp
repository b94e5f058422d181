// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/allocation_guard.hpp"

namespace nacelle {
namespace {

class Listener final : public LogListener {
 public:
  Listener() { add_log_listener(*this); }
  ~Listener() override { remove_log_listener(*this); }
  void on_line(LogLevel, std::string_view, std::string_view text, const LogPlace&) noexcept override {
    length_ = text.copy(last_, sizeof last_);
  }
  [[nodiscard]] std::string last() const { return {last_, length_}; }

 private:
  char last_[1000]{};
  std::size_t length_ = 0;
};

// A warning of an executor's thread must not be an allocation of the steady state.
TEST(Log, a_line_of_the_usual_length_allocates_nothing) {
  const Logger log{"ekf"};
  log.warn("{}", "the first line makes the log");
  const Listener listener;
  const std::string reason(150, 'x');
  const test::AllocationGuard guard;
  log.warn("{}: {} measurements were lost, {}", "imu0", 7, reason);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(listener.last(), "imu0: 7 measurements were lost, " + reason);
}

TEST(Log, a_throttled_line_is_written_once_in_its_period_from_each_place_and_for_each_name) {
  const Logger lidar{"lidar"}, imu{"imu"};
  struct Counter final : LogListener {
    Counter() { add_log_listener(*this); }
    ~Counter() override { remove_log_listener(*this); }
    void on_line(LogLevel, std::string_view, std::string_view, const LogPlace&) noexcept override { ++lines; }
    int lines = 0;
  } counter;
  for (int i = 0; i < 3; ++i) {
    lidar.warn_throttle(std::chrono::hours{1}, "{} bytes were no frame", i);
    lidar.error_throttle(std::chrono::hours{1}, "{} frames were late", i);
    imu.warn_throttle(std::chrono::hours{1}, "{} bytes were no frame", i);
  }
  EXPECT_EQ(counter.lines, 3);
  for (int i = 0; i < 3; ++i) lidar.info_throttle(std::chrono::nanoseconds{0}, "always");
  EXPECT_EQ(counter.lines, 6);
}

TEST(Log, a_line_of_any_length_is_whole) {
  const Logger log{"ekf"};
  const Listener listener;
  const std::string text(900, 'y');
  log.warn("{}", text);
  EXPECT_EQ(listener.last(), text);
}

TEST(Log, a_level_that_is_off_builds_no_text) {
  const Logger log{"ekf"};
  const Listener listener;
  log.debug("{}", "not for now");
  EXPECT_EQ(listener.last(), "");
}

// What the program's stderr gets of a message.
std::string logged(std::string_view message) {
  ::testing::internal::CaptureStderr();
  Logger{"transforms"}.warn("transform '{}' was refused", message);
  return ::testing::internal::GetCapturedStderr();
}

TEST(Log, text_from_outside_moves_no_cursor) {
  EXPECT_THAT(logged("a\x1b[2J\rb"), testing::EndsWith("[transforms] transform 'a\\x1b[2J\\x0db' was refused\n"));
}

TEST(Log, text_from_outside_forges_no_entry) {
  const std::string text = logged("a\n12:00:00.000 info [base] released");
  EXPECT_THAT(text, testing::EndsWith("transform 'a\n  | 12:00:00.000 info [base] released' was refused\n"));
}

TEST(Log, listeners_get_the_text_as_it_was_written) {
  const Listener listener;
  logged("a\x1b\n");
  EXPECT_EQ(listener.last(), "transform 'a\x1b\n' was refused");
}

}  // namespace
}  // namespace nacelle
