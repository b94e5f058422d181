// SPDX-License-Identifier: Apache-2.0
// Serial lines of a real kernel driver: cdc_acm and a USB device of the kernel's own, whose cable is pulled.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <random>
#include <thread>

#include "acm_gadget.hpp"
#include "lidar/component/lidar_component.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/io/serial_port.hpp"
#include "simulation/model/sensor_models.hpp"
#include "support/recording_host.hpp"

namespace nacelle::io {
namespace {

using test::AcmGadget;
using test::kPatience;

Bytes random_bytes(std::size_t count, unsigned seed) {
  std::mt19937 random{seed};
  Bytes all(count);
  for (auto& byte : all) byte = static_cast<std::uint8_t>(random());
  return all;
}

class SerialLine : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("serial");
    board_.emplace(clock_);
    board_->plug();
  }
  std::unique_ptr<SerialPort> open() {
    auto port = SerialPort::open({AcmGadget::kRobotEnd, 115200}, clock_);
    EXPECT_TRUE(port) << port.error().text();
    return port ? std::move(port).value() : nullptr;
  }
  Bytes read(SerialPort& port, std::size_t count) {
    Bytes all;
    while (all.size() < count) {
      const auto bytes = port.read_until(clock_.now() + kPatience);
      if (!bytes || bytes->empty()) break;
      all.insert(all.end(), bytes->begin(), bytes->end());
    }
    return all;
  }

  SystemClock clock_;
  std::optional<AcmGadget> board_;
};

TEST_F(SerialLine, carries_every_byte_both_ways_unchanged) {
  const auto port = open();
  ASSERT_TRUE(port);
  const Bytes sent = random_bytes(100'000, 1), answer = random_bytes(3'000, 2);

  std::thread device{[&] { EXPECT_TRUE(board_->write(sent)); }};
  const Bytes got = read(*port, sent.size());
  device.join();
  EXPECT_TRUE(got == sent) << got.size() << " bytes";

  ASSERT_TRUE(port->write(answer));
  EXPECT_TRUE(board_->read(answer.size()) == answer);
}

TEST_F(SerialLine, is_for_one_program_at_a_time) {
  const auto first = open();
  ASSERT_TRUE(first);
  const auto second = SerialPort::open({AcmGadget::kRobotEnd, 115200}, clock_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().what, "in use by vm_serial_test (pid " + std::to_string(::getpid()) + ")");
}

TEST_F(SerialLine, a_pulled_cable_ends_a_read_that_waits) {
  const auto port = open();
  ASSERT_TRUE(port);
  std::optional<StreamFault> fault;
  std::thread reader{[&] {
    const auto bytes = port->read_until(clock_.now() + kPatience);
    if (!bytes) fault = bytes.error();
  }};
  board_->unplug();
  reader.join();
  EXPECT_EQ(fault, StreamFault::HungUp);
  EXPECT_FALSE(port->write(Bytes{1}));
}

// A line that stays open keeps its number: the device would return as /dev/ttyACM1.
TEST_F(SerialLine, comes_back_under_the_same_number_although_it_was_open_when_the_cable_was_pulled) {
  const auto port = open();
  ASSERT_TRUE(port);
  const int before = port->descriptor();
  board_->unplug();
  ASSERT_EQ(port->read_until(clock_.now() + kPatience).error(), StreamFault::HungUp);
  ASSERT_TRUE(test::wait_for_no_node(AcmGadget::kRobotEnd, clock_));
  EXPECT_EQ(port->reopen().error(), StreamFault::NotFound);
  EXPECT_EQ(port->read_until(clock_.now()).error(), StreamFault::NotFound);

  board_->plug();
  ASSERT_TRUE(port->reopen());
  EXPECT_EQ(port->descriptor(), before);
  ASSERT_TRUE(board_->write(Bytes{42}));
  EXPECT_EQ(read(*port, 1), Bytes{42});
}

/// Counts, and lets the test wait.
class CountingSink final : public ByteSink {
 public:
  void on_bytes(ByteView bytes, MonotonicTime) override { note(bytes_, bytes.size()); }
  void on_silence(MonotonicTime) override {}
  void on_break(StreamFault, MonotonicTime) override { note(breaks_, 1); }
  void on_return(MonotonicTime) override { note(returns_, 1); }
  [[nodiscard]] bool wait_for_bytes(std::size_t count) { return wait_for(bytes_, count); }
  [[nodiscard]] bool wait_for_breaks(std::size_t count) { return wait_for(breaks_, count); }
  [[nodiscard]] bool wait_for_returns(std::size_t count) { return wait_for(returns_, count); }

 private:
  void note(std::size_t& counter, std::size_t more) {
    const std::lock_guard lock{mutex_};
    counter += more;
    changed_.notify_all();
  }
  bool wait_for(const std::size_t& counter, std::size_t count) {
    std::unique_lock lock{mutex_};
    return changed_.wait_for(lock, kPatience, [&] { return counter >= count; });
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t bytes_ = 0, breaks_ = 0, returns_ = 0;
};

TEST_F(SerialLine, every_unplugging_is_counted_and_nothing_leaks) {
  const auto port = open();
  ASSERT_TRUE(port);
  CountingSink sink;
  ReaderThread reader{*port, clock_, sink, {.name = "vm"}};
  const auto files = test::count_entries("/proc/self/fd"), threads = test::count_entries("/proc/self/task");
  const auto count = static_cast<std::size_t>(test::cycles());
  for (std::size_t cycle = 1; cycle <= count; ++cycle) {
    ASSERT_TRUE(board_->write(Bytes{1, 2, 3}));
    ASSERT_TRUE(sink.wait_for_bytes(3 * cycle)) << "in cycle " << cycle;
    board_->unplug();
    ASSERT_TRUE(sink.wait_for_breaks(cycle)) << "in cycle " << cycle;
    board_->plug();
    ASSERT_TRUE(sink.wait_for_returns(cycle)) << "in cycle " << cycle;
  }
  EXPECT_EQ(test::count_entries("/proc/self/fd"), files);
  EXPECT_EQ(test::count_entries("/proc/self/task"), threads);
  reader.stop();
  EXPECT_EQ(reader.stats().breaks, count);
  EXPECT_EQ(reader.stats().returns, count);
  EXPECT_EQ(reader.stats().bytes, 3 * count);
}

/// The LiDAR of the simulated robot, sending into the board's end as fast as the line takes it.
class SendingLidar {
 public:
  explicit SendingLidar(AcmGadget& board) : thread_{[this, &board] { send(board); }} {}
  ~SendingLidar() {
    stop_ = true;
    thread_.join();
  }
  SendingLidar(const SendingLidar&) = delete;
  SendingLidar& operator=(const SendingLidar&) = delete;

 private:
  void send(AcmGadget& board) {
    const simulation::Room room = simulation::Room::with_two_boxes();
    simulation::LidarModel lidar{{.seed = 1}, room};
    while (!stop_) {
      static_cast<void>(lidar.next_point());
      if (const auto packet = lidar.measure({})) {
        if (!board.write(print_ld06(*packet))) return;
      }
    }
  }
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST_F(SerialLine, a_lidar_reports_the_pulled_cable_and_measures_again_when_it_is_back) {
  using sensor_msgs::msg::LaserScan;
  test::RecordingContext context{clock_};
  NodeOptions options{context};
  options.append_parameter_override("port_name", AcmGadget::kRobotEnd);
  lidar::LidarComponent lidar{options};
  std::optional<SendingLidar> device{*board_};
  const auto configured = lidar.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  ASSERT_TRUE(lidar.trigger(Transition::Activate).success);
  ASSERT_TRUE(context.wait_for("/scan", 5, kPatience));
  EXPECT_TRUE(context.open_faults().empty());

  device.reset();
  board_->unplug();
  context.wait_for_open_faults(1);
  ASSERT_EQ(context.open_faults().size(), 1U);
  EXPECT_EQ(context.open_faults().front().code, "DEVICE_LOST");
  EXPECT_TRUE(context.faults().empty());

  board_->plug();
  device.emplace(*board_);
  const std::size_t before = context.published<LaserScan>("/scan").size();
  ASSERT_TRUE(context.wait_for("/scan", before + 3, kPatience));
  EXPECT_TRUE(context.open_faults().empty());
  EXPECT_EQ(context.closed_faults(), 1U);
  device.reset();
}

}  // namespace
}  // namespace nacelle::io
