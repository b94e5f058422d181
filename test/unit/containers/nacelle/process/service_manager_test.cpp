// SPDX-License-Identifier: Apache-2.0
#include "process/service_manager.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>

#include "unit/containers/nacelle/notify_socket.hpp"

namespace nacelle::process {
namespace {

class ServiceManagerTest : public ::testing::Test {
 protected:
  /// Sets the environment as a service manager does, and takes it.
  [[nodiscard]] ServiceManager take(const std::string& socket, const char* period = nullptr,
                                    const char* process = nullptr) {
    ::setenv("NOTIFY_SOCKET", socket.c_str(), 1);
    if (period != nullptr) ::setenv("WATCHDOG_USEC", period, 1);
    if (process != nullptr) ::setenv("WATCHDOG_PID", process, 1);
    return ServiceManager::take_from_environment();
  }
};

TEST_F(ServiceManagerTest, sends_states_to_a_path_and_to_an_abstract_name) {
  for (const bool is_abstract : {false, true}) {
    const test::NotifySocket socket{is_abstract};
    take(socket.name()).tell("READY=1\nSTATUS=two components");
    EXPECT_EQ(socket.receive(), "READY=1\nSTATUS=two components") << socket.name();
  }
}

TEST_F(ServiceManagerTest, takes_the_variables_away_from_programs_that_it_starts) {
  const test::NotifySocket socket;
  const auto manager = take(socket.name(), "10000000", std::to_string(::getpid()).c_str());
  EXPECT_EQ(manager.watchdog(), 10s);
  for (const char* const name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"})
    EXPECT_EQ(std::getenv(name), nullptr) << name;
}

TEST_F(ServiceManagerTest, has_no_watchdog_for_another_process_or_without_a_period) {
  const test::NotifySocket socket;
  EXPECT_FALSE(take(socket.name(), "10000000", "1").watchdog());
  for (const char* const period : {"", "0", "-5", "ten", "99999999999999999999", "9223372036854775807"})
    EXPECT_FALSE(take(socket.name(), period).watchdog()) << period;
  EXPECT_EQ(take(socket.name(), "500000").watchdog(), 500ms);
}

TEST_F(ServiceManagerTest, without_a_usable_name_there_is_none) {
  for (const std::string& name :
       {std::string{}, std::string{"@"}, std::string{"relative"}, std::string(200, '/'), std::string{"vsock:2:1"}}) {
    const auto manager = take(name);
    EXPECT_FALSE(manager.is_there()) << name;
    manager.tell("READY=1");
  }
  EXPECT_FALSE(ServiceManager{}.is_there());
}

bool is_readable(int descriptor) {
  pollfd wait{descriptor, POLLIN, 0};
  return ::poll(&wait, 1, 0) == 1;
}

TEST(Hangup, asks_for_a_reload_of_a_service_and_for_the_end_elsewhere) {
  {
    const StopSignal stop{nullptr, FullOutput::Kept, Hangup::Reload};
    EXPECT_FALSE(is_readable(stop.reload_descriptor()));
    std::raise(SIGHUP);
    std::raise(SIGHUP);
    EXPECT_TRUE(is_readable(stop.reload_descriptor()));
    stop.take_reload();
    EXPECT_FALSE(is_readable(stop.reload_descriptor())) << "both are one reload";
    EXPECT_FALSE(stop.is_raised());
    std::raise(SIGINT);
    EXPECT_TRUE(stop.is_raised());
  }
  const StopSignal stop;
  EXPECT_EQ(stop.reload_descriptor(), -1);
  std::raise(SIGHUP);
  EXPECT_EQ(stop.number(), SIGHUP);
}

}  // namespace
}  // namespace nacelle::process
