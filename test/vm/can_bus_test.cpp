// SPDX-License-Identifier: Apache-2.0
// CAN interfaces of a real kernel driver: vcan, which loses frames, is set down, and disappears.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <condition_variable>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <mutex>
#include <sensor_msgs/msg/joint_state.hpp>

#include "diff_drive/component/diff_drive_component.hpp"
#include "diff_drive/component/odrive_can_board.hpp"
#include "in_machine.hpp"
#include "nacelle/io/can_port.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/runtime/crash_record.hpp"
#include "runtime/src/safe_stop.hpp"
#include "simulation/protocol/odrive_can_device.hpp"
#include "simulation/protocol/vesc_can_device.hpp"
#include "support/recording_host.hpp"
#include "virtual_can.hpp"

namespace nacelle::io {
namespace {

using test::BusPeer;
using test::kPatience;
using test::VirtualCan;
using ::testing::HasSubstr;

class CanBus : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("can");
    bus_.emplace();
  }
  std::unique_ptr<CanPort> open(const std::vector<CanFilter>& filters = {}) {
    auto port = CanPort::open({VirtualCan::kName, filters, 100ms}, clock_);
    EXPECT_TRUE(port) << port.error().text();
    return port ? std::move(port).value() : nullptr;
  }
  Result<Bytes, StreamFault> read(CanPort& port) {
    const auto bytes = port.read_until(clock_.now() + kPatience);
    if (!bytes) return err(bytes.error());
    return Bytes(bytes->begin(), bytes->end());
  }

  SystemClock clock_;
  std::optional<VirtualCan> bus_;
};

TEST_F(CanBus, carries_frames_of_every_kind_both_ways) {
  const auto port = open();
  ASSERT_TRUE(port);
  BusPeer peer;
  for (const Bytes& frame : {BusPeer::frame(0x7FF, {1, 2, 3, 4, 5, 6, 7, 8}), BusPeer::frame(0),
                             BusPeer::frame(0x1FFFFFFF | CAN_EFF_FLAG, {9}), BusPeer::frame(0x29 | CAN_RTR_FLAG)}) {
    ASSERT_TRUE(peer.send(frame));
    EXPECT_EQ(read(*port).value(), frame);
    ASSERT_TRUE(port->write(frame));
    EXPECT_EQ(peer.receive(clock_, clock_.now() + kPatience), frame);
  }
  EXPECT_TRUE(port->read_until(clock_.now()).value().empty()) << "what it sent itself does not come back";
}

TEST_F(CanBus, the_kernel_takes_one_frame_a_write_and_the_port_sends_two) {
  const auto port = open();
  ASSERT_TRUE(port);
  BusPeer peer;
  const Bytes left = BusPeer::frame(0x0D, {1}), right = BusPeer::frame(0x2D, {2});
  Bytes both = left;
  both.insert(both.end(), right.begin(), right.end());
  EXPECT_EQ(::write(port->descriptor(), both.data(), both.size()), -1) << "why a stop of two wheels is two writes";
  ASSERT_TRUE(port->write(both));
  EXPECT_EQ(peer.receive(clock_, clock_.now() + kPatience), left);
  EXPECT_EQ(peer.receive(clock_, clock_.now() + kPatience), right);
}

TEST_F(CanBus, the_kernel_leaves_out_what_no_filter_passes) {
  const auto port = open({{3U << 5, kCanExtended | kCanRemote | (0x3FU << 5)}});
  ASSERT_TRUE(port);
  BusPeer peer;
  ASSERT_TRUE(peer.send(0x021));
  ASSERT_TRUE(peer.send(0x069 | CAN_RTR_FLAG));
  ASSERT_TRUE(peer.send(0x069 | CAN_EFF_FLAG));
  ASSERT_TRUE(peer.send(0x069, {7}));
  EXPECT_EQ(read(*port).value(), BusPeer::frame(0x069, {7}));
}

TEST_F(CanBus, tells_what_is_wrong_with_an_interface) {
  bus_->set_up(false);
  const auto down = CanPort::open({.interface = VirtualCan::kName}, clock_);
  ASSERT_FALSE(down);
  EXPECT_EQ(down.error().what, "the CAN interface is down");
  EXPECT_THAT(down.error().way_out, HasSubstr("ip link set testcan up type can bitrate"));
  const auto absent = CanPort::open({.interface = "can9"}, clock_);
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().what, "no such CAN interface");
  EXPECT_THAT(absent.error().way_out, HasSubstr("CAN interfaces are testcan"));
  const auto other = CanPort::open({.interface = "lo"}, clock_);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().what, "not a CAN interface");
}

TEST_F(CanBus, an_injected_bus_off_is_a_fault_and_a_reopened_port_reads_on) {
  const auto port = open({{0x021, 0x7FF}});
  ASSERT_TRUE(port);
  BusPeer peer;
  ASSERT_TRUE(peer.send(BusPeer::bus_off()));
  EXPECT_EQ(read(*port).error(), StreamFault::BusOff) << "error frames pass no filter of frames";
  EXPECT_EQ(port->stats().bus_offs, 1U);
  ASSERT_TRUE(port->reopen());
  ASSERT_TRUE(peer.send(0x021, {1}));
  EXPECT_EQ(read(*port).value(), BusPeer::frame(0x021, {1}));
}

TEST_F(CanBus, an_interface_that_is_set_down_ends_a_read_that_waits) {
  const auto port = open();
  ASSERT_TRUE(port);
  const int before = port->descriptor();
  std::optional<StreamFault> fault;
  std::thread reader{[&] {
    const auto bytes = port->read_until(clock_.now() + kPatience);
    if (!bytes) fault = bytes.error();
  }};
  bus_->set_up(false);
  reader.join();
  EXPECT_EQ(fault, StreamFault::LineDown);
  EXPECT_EQ(port->write(BusPeer::frame(1)).error(), StreamFault::LineDown);
  EXPECT_EQ(port->reopen().error(), StreamFault::LineDown);
  EXPECT_TRUE(port->is_away());
  EXPECT_EQ(read(*port).error(), StreamFault::LineDown);

  bus_->set_up(true);
  ASSERT_TRUE(port->reopen());
  EXPECT_FALSE(port->is_away());
  EXPECT_EQ(port->descriptor(), before);
  BusPeer peer;
  ASSERT_TRUE(peer.send(5));
  EXPECT_EQ(read(*port).value(), BusPeer::frame(5));
}

TEST_F(CanBus, an_adapter_that_is_unplugged_and_returns_is_found_again) {
  const auto port = open();
  ASSERT_TRUE(port);
  const int before = port->descriptor();
  bus_->remove();
  const auto fault = read(*port);
  ASSERT_FALSE(fault);
  EXPECT_TRUE(fault.error() == StreamFault::LineDown || fault.error() == StreamFault::HungUp);
  EXPECT_EQ(port->reopen().error(), StreamFault::NotFound);
  EXPECT_EQ(::write(port->descriptor(), BusPeer::frame(1).data(), 16), -1) << "no stop counts as written";
  bus_->add();
  ASSERT_TRUE(port->reopen());
  EXPECT_EQ(port->descriptor(), before);
  BusPeer peer;
  ASSERT_TRUE(peer.send(5));
  EXPECT_EQ(read(*port).value(), BusPeer::frame(5));
}

TEST_F(CanBus, an_absent_interface_is_awaited) {
  bus_->remove();
  auto made = CanPort::open_or_await({.interface = VirtualCan::kName}, clock_);
  ASSERT_TRUE(made) << made.error().text();
  const auto port = std::move(made).value();
  EXPECT_TRUE(port->is_away());
  EXPECT_EQ(read(*port).error(), StreamFault::NotFound);
  EXPECT_EQ(::write(port->descriptor(), BusPeer::frame(1).data(), 16), -1) << "no stop counts as written";
  bus_->add();
  ASSERT_TRUE(port->reopen());
  BusPeer peer;
  ASSERT_TRUE(port->write(BusPeer::frame(6)));
  EXPECT_EQ(peer.receive(clock_, clock_.now() + kPatience), BusPeer::frame(6));
}

/// Counts, and lets the test wait.
class FrameCounter final : public ByteSink {
 public:
  void on_bytes(ByteView bytes, MonotonicTime) override { note(bytes_, bytes.size()); }
  void on_silence(MonotonicTime) override {}
  void on_break(StreamFault, MonotonicTime) override { note(breaks_, 1); }
  void on_return(MonotonicTime) override { note(returns_, 1); }
  [[nodiscard]] bool wait_for_frames(std::size_t count) { return wait_for(bytes_, count * kCanFrameBytes); }
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

TEST_F(CanBus, every_time_down_is_counted_and_nothing_leaks) {
  const auto port = open();
  ASSERT_TRUE(port);
  BusPeer peer;
  FrameCounter sink;
  ReaderThread reader{*port, clock_, sink, {.name = "vm"}};
  const auto files = test::count_entries("/proc/self/fd"), threads = test::count_entries("/proc/self/task");
  const auto count = static_cast<std::size_t>(test::cycles());
  for (std::size_t cycle = 1; cycle <= count; ++cycle) {
    ASSERT_TRUE(peer.send(1, {1, 2, 3}));
    ASSERT_TRUE(sink.wait_for_frames(cycle)) << "in cycle " << cycle;
    bus_->set_up(false);
    ASSERT_TRUE(sink.wait_for_breaks(cycle)) << "in cycle " << cycle;
    bus_->set_up(true);
    ASSERT_TRUE(sink.wait_for_returns(cycle)) << "in cycle " << cycle;
  }
  EXPECT_EQ(test::count_entries("/proc/self/fd"), files);
  EXPECT_EQ(test::count_entries("/proc/self/task"), threads);
  reader.stop();
  EXPECT_EQ(reader.stats().breaks, count);
  EXPECT_EQ(reader.stats().returns, count);
  EXPECT_EQ(reader.stats().bytes, kCanFrameBytes * count);
}

TEST_F(CanBus, the_watcher_of_a_killed_container_stops_both_wheels) {
  BusPeer peer;
  const pid_t container = ::fork();
  if (container == 0) {
    const runtime::CrashHandler handler{"", "box"};
    diff_drive::OdriveCanBoard board{diff_drive::OdriveCanBoard::Settings{}};
    const auto port = open();
    runtime::SafeStop base{"/base"};
    base.set(port->descriptor(), board.stop_frame());
    ::raise(SIGKILL);
  }
  const Bytes left = peer.receive(clock_, clock_.now() + kPatience);
  const Bytes right = peer.receive(clock_, clock_.now() + kPatience);
  EXPECT_EQ(left, BusPeer::frame(0x00D, Bytes(8)));
  EXPECT_EQ(right, BusPeer::frame(0x02D, Bytes(8)));
  int status = 0;
  ASSERT_EQ(::waitpid(container, &status, 0), container);
}

/// A base on the bus, and two emulated boards at its other end.
class BaseOnCan : public CanBus {
 protected:
  void drive_odrive() {
    boards_.emplace(std::make_unique<simulation::OdriveCanDevice>(simulation::OdriveCanDevice::Settings{}));
    NodeOptions options{context_};
    options.append_parameter_override("hardware", std::string{"odrive_can"});
    drive(options);
  }
  void drive_vesc() {
    constexpr int kPolePairs = 15;
    boards_.emplace(std::make_unique<simulation::VescCanDevice>(
        simulation::VescCanDevice::Settings{.pole_pairs = kPolePairs, .timeout = 20s}));
    NodeOptions options{context_};
    options.append_parameter_override("hardware", std::string{"vesc_can"});
    options.append_parameter_override("left_channel", std::int64_t{7});
    options.append_parameter_override("right_channel", std::int64_t{42});
    options.append_parameter_override("counts_per_turn", 6.0 * kPolePairs);
    drive(options);
  }
  void drive(NodeOptions& options) {
    options.append_parameter_override("can_interface", std::string{VirtualCan::kName});
    options.append_parameter_override("rearm", std::string{"fresh"});
    options.append_parameter_override("cmd_vel_timeout", 60.0);
    options.append_parameter_override("max_wheel_rate", 100.0);
    drive_.emplace(options);
    const auto configured = drive_->trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(drive_->trigger(Transition::Activate).success);
    ASSERT_TRUE(context_.wait_for("/joint_states", 5, kPatience));
  }
  template <typename Condition>
  [[nodiscard]] bool wait_until(Condition holds) {
    const MonotonicTime limit = clock_.now() + kPatience;
    while (!holds() && clock_.now() < limit) std::this_thread::yield();
    return holds();
  }
  /// Repeats the command, as a sender does, until the wheels turn.
  [[nodiscard]] bool drive_forward() {
    return wait_until([&] {
      geometry_msgs::msg::TwistStamped command;
      command.twist.linear.x = 0.2;
      context_.inject("/cmd_vel", command);
      return boards_->left_target_rps() > 0.0 && boards_->right_target_rps() > 0.0;
    });
  }
  [[nodiscard]] bool wheels_stop() {
    return wait_until([&] { return boards_->left_target_rps() == 0.0 && boards_->right_target_rps() == 0.0; });
  }

  test::RecordingContext context_{clock_};
  std::optional<test::BoardsOnBus> boards_;
  std::optional<diff_drive::DiffDriveComponent> drive_;
};

TEST_F(BaseOnCan, drives_and_reads_its_wheels_while_frames_are_lost) {
  drive_odrive();
  bus_->lose_percent(20);
  ASSERT_TRUE(drive_forward());
  const auto before = context_.published<sensor_msgs::msg::JointState>("/joint_states").size();
  ASSERT_TRUE(context_.wait_for("/joint_states", before + 100, kPatience));
  EXPECT_TRUE(context_.open_faults().empty());
  EXPECT_EQ(context_.closed_faults(), 0U);
  EXPECT_GT(bus_->lost_frames(), 10);
  ASSERT_TRUE(drive_->trigger(Transition::Deactivate).success);
}

TEST_F(BaseOnCan, drives_two_vescs_while_frames_are_lost) {
  drive_vesc();
  bus_->lose_percent(20);
  ASSERT_TRUE(drive_forward());
  const auto before = context_.published<sensor_msgs::msg::JointState>("/joint_states").size();
  ASSERT_TRUE(context_.wait_for("/joint_states", before + 50, kPatience));
  EXPECT_TRUE(context_.open_faults().empty());
  ASSERT_TRUE(drive_->trigger(Transition::Deactivate).success);
}

TEST_F(BaseOnCan, a_bus_off_stops_the_wheels_and_the_base_goes_on_when_the_bus_is_back) {
  drive_odrive();
  ASSERT_TRUE(drive_forward());
  ASSERT_TRUE(BusPeer{}.send(BusPeer::bus_off()));
  EXPECT_TRUE(wheels_stop());
  EXPECT_TRUE(wait_until([&] { return context_.closed_faults() == 1; })) << "lost, and back";
  EXPECT_TRUE(context_.faults().empty());
  EXPECT_TRUE(drive_forward());
}

TEST_F(BaseOnCan, an_interface_that_is_set_down_is_a_lost_device_until_it_is_up) {
  drive_odrive();
  ASSERT_TRUE(drive_forward());
  bus_->set_up(false);
  context_.wait_for_open_faults(1);
  ASSERT_EQ(context_.open_faults().size(), 1U);
  EXPECT_EQ(context_.open_faults().front().code, "DEVICE_LOST");
  EXPECT_THAT(context_.open_faults().front().text, HasSubstr("is down"));

  bus_->set_up(true);
  EXPECT_TRUE(wheels_stop()) << "a start stops them, and an earlier command is not resumed";
  EXPECT_TRUE(wait_until([&] { return context_.open_faults().empty(); }));
  EXPECT_TRUE(context_.faults().empty());
  EXPECT_TRUE(drive_forward());
}

}  // namespace
}  // namespace nacelle::io
