// SPDX-License-Identifier: Apache-2.0
#include "session/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <new>
#include <string>

namespace nacelle::session {
namespace {

/// Throws std::bad_alloc on the first call, and ends the session on the second.
class Unlucky final : public ClockAlarm {
 public:
  explicit Unlucky(process::StopSignal& stop) : stop_(stop) { event_.ring(); }
  int descriptor() const override { return event_.descriptor(); }
  void take() override {
    if (++asked == 1) throw std::bad_alloc{};
    event_.silence();
    stop_.raise_by_request();
  }
  int asked = 0;

 private:
  process::StopSignal& stop_;
  Bell event_;
};

TEST(Session, goes_on_when_a_step_of_its_loop_has_no_memory) {
  std::string folder = (std::filesystem::temp_directory_path() / "nacelle-session-XXXXXX").string();
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1), 0);
  process::StopSignal stop;
  Unlucky alarm{stop};
  launch::Plan plan;
  plan.container.name = "robot";
  plan.container.declared = true;
  plan.network.mode = launch::NetworkMode::Off;
  SessionOptions options;
  options.container_name = "robot";
  options.clock_alarm = &alarm;
  const SystemClock clock;

  ::testing::internal::CaptureStderr();
  const int code = Session{std::move(plan), std::move(options), clock, stop}.run();
  const std::string said = ::testing::internal::GetCapturedStderr();

  EXPECT_EQ(code, 0) << said;
  EXPECT_EQ(alarm.asked, 2);
  EXPECT_THAT(said, testing::HasSubstr("nacelle: container: clock: std::bad_alloc\n"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace nacelle::session
