// SPDX-License-Identifier: Apache-2.0
#include "simulation/component/run_world.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utmp.h>

#include <csignal>
#include <filesystem>
#include <thread>
#include <utility>

#include "imu/protocol/wt901_decoder.hpp"
#include "lidar/protocol/ld06_decoder.hpp"
#include "nacelle/io/serial_port.hpp"
#include "simulation/port/truth_file.hpp"
#include "support/manual_clock.hpp"
#include "unit/components/simulation/running_world.hpp"

namespace nacelle::simulation {
namespace {

constexpr Duration kPatience = 30s;  // only a broken world takes so long

class RunWorld : public ::testing::Test {
 protected:
  std::unique_ptr<io::SerialPort> open(const char* device, unsigned baud) {
    auto port = io::SerialPort::open({world_.path(device), baud}, clock_);
    EXPECT_TRUE(port) << port.error().text();
    return port ? std::move(port).value() : nullptr;
  }
  RunningWorld world_{::testing::UnitTest::GetInstance()->current_test_info()->name(), {.seed = 5}};
  const SystemClock& clock_ = world_.clock();
};

TEST_F(RunWorld, the_lidar_sends_to_each_program_that_opens_its_line) {
  const auto port = open("lidar", 230400);
  lidar::Ld06Decoder decoder;
  while (decoder.stats().frames < 50) {
    const auto bytes = port->read_until(clock_.now() + kPatience);
    ASSERT_TRUE(bytes);
    ASSERT_FALSE(bytes->empty());
    decoder.feed(*bytes, [](const lidar::Ld06Frame&, std::size_t) {});
  }
  EXPECT_LT(decoder.stats().skipped_bytes, 47U) << "at most the frame that was under way";
}

TEST_F(RunWorld, the_imu_sends_to_each_program_that_opens_its_line) {
  const auto port = open("imu", 115200);
  imu::Wt901Decoder decoder;
  while (decoder.stats().frames < 25) {
    const auto bytes = port->read_until(clock_.now() + kPatience);
    ASSERT_TRUE(bytes);
    ASSERT_FALSE(bytes->empty());
    decoder.feed(*bytes, [](const imu::Wt901Frame&, std::size_t) {});
  }
  EXPECT_LT(decoder.stats().skipped_bytes, 11U);
}

TEST_F(RunWorld, a_command_on_the_base_line_moves_the_true_robot) {
  const auto port = open("base", 115200);
  ASSERT_TRUE(port->write(as_bytes("{\"T\":1,\"L\":0.5,\"R\":0.5}\n")));
  double x_m = 0.0;
  const MonotonicTime deadline = clock_.now() + kPatience;
  while (x_m < 0.05 && clock_.now() < deadline) {
    const auto bytes = port->read_until(deadline);  // the board's feedback paces this loop
    ASSERT_TRUE(bytes);
    const auto truth = read_truth(world_.path("truth"));
    ASSERT_TRUE(truth);
    x_m = truth->x_m;
    EXPECT_EQ(truth->seed, 5U);
  }
  EXPECT_GE(x_m, 0.05);
  const auto truth = read_truth(world_.path("truth"));
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->left_command_mps, 0.5);
  EXPECT_EQ(truth->motion_commands, 1U);
  EXPECT_GT(truth->last_motion_command_ns, 0);
}

TEST_F(RunWorld, a_pulled_cable_hangs_up_and_its_board_stops_by_itself_until_it_is_put_back) {
  const auto port = open("base", 115200);
  ASSERT_TRUE(port->write(as_bytes("{\"T\":136,\"cmd\":50}\n{\"T\":1,\"L\":0.5,\"R\":0.5}\n")));
  const auto truth_when = [this](auto&& condition) {
    const MonotonicTime deadline = clock_.now() + kPatience;
    auto truth = read_truth(world_.path("truth"));
    while (truth && !condition(*truth) && clock_.now() < deadline) {
      std::this_thread::yield();
      truth = read_truth(world_.path("truth"));
    }
    return truth.value();
  };
  ASSERT_EQ(truth_when([](const Truth& t) { return t.starts == 1; }).starts, 1U);
  ASSERT_TRUE(plug_device(world_.directory(), "base", false));
  const Truth stopped = truth_when([](const Truth& t) { return t.stops == 1; });
  EXPECT_EQ(stopped.watchdog_stops, 1U);
  EXPECT_EQ(stopped.left_command_mps, 0.0);
  EXPECT_GT(stopped.last_stop_ns, stopped.last_start_ns);

  auto bytes = port->read_until(clock_.now() + kPatience);
  while (bytes && !bytes->empty()) bytes = port->read_until(clock_.now() + kPatience);
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error(), io::StreamFault::HungUp);
  EXPECT_FALSE(port->reopen());

  ASSERT_TRUE(plug_device(world_.directory(), "base", true));
  const MonotonicTime deadline = clock_.now() + kPatience;
  while (!port->reopen() && clock_.now() < deadline) std::this_thread::yield();
  bytes = port->read_until(clock_.now() + kPatience);
  ASSERT_TRUE(bytes);
  EXPECT_FALSE(bytes->empty()) << "the board went on and speaks again";
}

TEST_F(RunWorld, a_cable_of_no_device_or_no_world_is_named) {
  const auto no_device = plug_device(world_.directory(), "bse", false);
  ASSERT_FALSE(no_device);
  EXPECT_NE(no_device.error().way_out.find("base"), std::string::npos);
  EXPECT_FALSE(plug_device("/no/such/world", "base", false));
}

TEST_F(RunWorld, a_line_without_a_reader_drops_bytes_and_does_not_block) {
  const auto port = open("base", 115200);
  // The lidar fills its line in a sixth of a second; the base must go on all the same.
  for (const MonotonicTime end = clock_.now() + 400ms; clock_.now() < end;) {
    const auto bytes = port->read_until(clock_.now() + kPatience);
    ASSERT_TRUE(bytes);
    ASSERT_FALSE(bytes->empty());
  }
  world_.stop();
  EXPECT_GT(world_.report().lines[0].dropped_bytes, 0U);
  EXPECT_EQ(world_.report().lines[2].dropped_bytes, 0U);
}

TEST_F(RunWorld, a_second_world_in_the_same_directory_is_refused) {
  WorldOptions options;
  options.directory = world_.directory();
  const auto second = run_world(options, clock_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().what, "another world runs here");
  EXPECT_TRUE(std::filesystem::exists(world_.path("ready"))) << "the first one keeps its files";
  EXPECT_TRUE(std::filesystem::exists(world_.path("base")));
}

TEST_F(RunWorld, takes_everything_away_when_it_ends) {
  world_.stop();
  EXPECT_TRUE(std::filesystem::is_empty(world_.directory()));
  EXPECT_EQ(world_.problem(), Problem{});
}

TEST(RunWorldPause, is_made_up_for_at_a_pace_that_the_reader_of_a_line_keeps) {
  const SystemClock real;
  test::ManualClock clock;
  Bell stop;
  WorldOptions options;
  options.directory = ::testing::TempDir() + "world_pause_" + std::to_string(getpid());
  options.stop_descriptor = stop.descriptor();
  std::uint64_t skipped = 1;
  std::thread world{[&] {
    const auto report = run_world(options, clock);
    if (report) skipped = report.value().skipped_steps;
  }};
  const MonotonicTime deadline = real.now() + kPatience;
  while (!std::filesystem::exists(options.directory + "/ready") && real.now() < deadline) std::this_thread::yield();
  const MonotonicTime begin = real.now();
  clock.advance(900ms);
  for (double world_s = 0.0; world_s < 0.899 && real.now() < deadline; std::this_thread::yield()) {
    if (const auto truth = read_truth(options.directory + "/truth")) world_s = truth->time_s;
  }
  EXPECT_GE(real.now() - begin, 200ms) << "all at once, and a line holds 4 KB";
  stop.ring();
  world.join();
  EXPECT_EQ(skipped, 0U);
  std::filesystem::remove_all(options.directory);
}

/// A world in a child process, as the launcher starts it.
class WorldProcess {
 public:
  /// `terminal`: the world becomes its foreground process.
  explicit WorldProcess(bool end_with_parent, int terminal = -1) {
    const pid_t parent = getpid();
    child_ = fork();
    if (child_ == 0) {
      if (terminal >= 0 && login_tty(terminal) != 0) _exit(2);
      const SystemClock clock;
      WorldOptions options;
      options.directory = directory_;
      options.end_with_parent = end_with_parent;
      options.parent_pid = parent;
      _exit(run_world(options, clock) ? 0 : 1);
    }
    while (!std::filesystem::exists(directory_ + "/ready") && waitpid(child_, nullptr, WNOHANG) == 0) {
      std::this_thread::yield();
    }
  }
  WorldProcess(const WorldProcess&) = delete;
  WorldProcess& operator=(const WorldProcess&) = delete;
  ~WorldProcess() { std::filesystem::remove_all(directory_); }
  void send(int signal) const { ASSERT_EQ(kill(child_, signal), 0); }
  /// Returns its exit status as waitpid() reports it.
  [[nodiscard]] int wait() const {
    int status = -1;
    EXPECT_EQ(waitpid(child_, &status, 0), child_);
    return status;
  }
  [[nodiscard]] const std::string& directory() const { return directory_; }

 private:
  std::string directory_ = ::testing::TempDir() + "world_process_" + std::to_string(getpid());
  pid_t child_ = -1;
};

TEST(RunWorldProcess, ends_in_order_on_sigterm_and_sigint) {
  for (const auto& [signal, end_with_parent] :
       {std::pair{SIGTERM, false}, {SIGTERM, true}, {SIGINT, false}, {SIGINT, true}}) {
    const WorldProcess world{end_with_parent};
    ASSERT_TRUE(std::filesystem::exists(world.directory() + "/ready"));
    world.send(signal);
    const int status = world.wait();
    EXPECT_TRUE(WIFEXITED(status)) << signal;
    EXPECT_EQ(WEXITSTATUS(status), 0) << signal;
    EXPECT_TRUE(std::filesystem::is_empty(world.directory())) << signal;
  }
}

TEST(RunWorldProcess, leaves_a_terminals_ctrl_c_to_its_parent) {
  int keyboard = -1, terminal = -1;
  ASSERT_EQ(openpty(&keyboard, &terminal, nullptr, nullptr, nullptr), 0);
  const WorldProcess world{true, terminal};
  ASSERT_TRUE(std::filesystem::exists(world.directory() + "/ready"));
  ASSERT_EQ(write(keyboard, "\x03", 1), 1);
  // Bytes that are sent after the signal was: the world lives.
  const SystemClock clock;
  auto port = io::SerialPort::open({world.directory() + "/imu", 115200}, clock);
  ASSERT_TRUE(port) << port.error().text();
  for (int i = 0; i < 3; ++i) {
    const auto bytes = port.value()->read_until(clock.now() + kPatience);
    ASSERT_TRUE(bytes);
    EXPECT_FALSE(bytes->empty());
  }
  world.send(SIGTERM);
  EXPECT_EQ(world.wait(), 0);
  close(terminal);
  close(keyboard);
}

TEST(RunWorldProblems, a_directory_that_cannot_be_made_is_named) {
  const SystemClock clock;
  WorldOptions options;
  options.directory = "/dev/null/world";
  const auto world = run_world(options, clock);
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().where.text(), "/dev/null/world");
}

}  // namespace
}  // namespace nacelle::simulation
