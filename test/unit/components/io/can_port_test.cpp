// SPDX-License-Identifier: Apache-2.0
// The port on a pair of sockets whose messages are frames, as a CAN socket's are. What needs a CAN interface is in test/vm.
#include "nacelle/io/can_port.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>

#include <cstring>

namespace nacelle::io::can_test {
namespace {

constexpr Duration kPatience = 20s;  // ends a broken build only

Bytes frame(std::uint32_t id, Bytes data = {}) {
  can_frame raw{};
  raw.can_id = id;
  raw.can_dlc = static_cast<__u8>(data.size());
  std::copy(data.begin(), data.end(), raw.data);
  Bytes bytes(sizeof raw);
  std::memcpy(bytes.data(), &raw, sizeof raw);
  return bytes;
}
Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class CanPortTest : public ::testing::Test {
 protected:
  void SetUp() override {
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends), 0);
    bus_ = Descriptor{ends[0]};
    port_ = CanPort::adopt(Descriptor{ends[1]}, {"test-can", {}, 1ms}, clock_);
  }
  void send(const Bytes& bytes) {
    ASSERT_EQ(::send(bus_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
  }
  /// The next message at the other end; empty if there is none.
  Bytes received() {
    Bytes bytes(64);
    const ssize_t count = ::recv(bus_.number(), bytes.data(), bytes.size(), 0);
    bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return bytes;
  }
  Result<Bytes, StreamFault> read() {
    const auto bytes = port_->read_until(clock_.now() + kPatience);
    if (!bytes) return err(bytes.error());
    return Bytes(bytes->begin(), bytes->end());
  }

  SystemClock clock_;
  Descriptor bus_;
  std::unique_ptr<CanPort> port_;
};

TEST_F(CanPortTest, sends_each_frame_by_itself) {
  const Bytes left = frame(0x00D, {1, 2, 3}), right = frame(0x00000307 | kCanExtended, {4});
  ASSERT_TRUE(port_->write(left + right));
  EXPECT_EQ(received(), left);
  EXPECT_EQ(received(), right);
  EXPECT_EQ(received(), Bytes{});
  EXPECT_EQ(port_->stats().frames_out, 2U);
  EXPECT_TRUE(port_->write({})) << "nothing is no frame";
}

TEST_F(CanPortTest, hands_out_all_frames_that_wait_in_their_order) {
  send(frame(1, {7}));
  send(frame(2 | kCanRemote));
  EXPECT_EQ(read().value(), frame(1, {7}) + frame(2 | kCanRemote));
  EXPECT_EQ(port_->stats().frames_in, 2U);
  EXPECT_TRUE(port_->read_until({})->empty()) << "a deadline in the past does not wait";
}

TEST_F(CanPortTest, reads_more_frames_than_one_chunk_holds) {
  for (std::uint8_t i = 0; i < 100; ++i) send(frame(i, {i}));
  Bytes all;
  while (all.size() < 100 * kCanFrameBytes) {
    const auto bytes = read();
    ASSERT_TRUE(bytes);
    all = all + bytes.value();
  }
  for (std::uint8_t i = 0; i < 100; ++i) ASSERT_EQ(all[i * kCanFrameBytes + 8], i);
}

TEST_F(CanPortTest, bus_off_is_a_fault_behind_the_frames_before_it) {
  send(frame(1, {7}));
  send(frame(CAN_ERR_FLAG | CAN_ERR_BUSOFF, Bytes(8)));
  send(frame(2, {8}));
  EXPECT_EQ(read().value(), frame(1, {7}));
  EXPECT_EQ(read().error(), StreamFault::BusOff);
  EXPECT_EQ(read().value(), frame(2, {8})) << "reported once";
  EXPECT_EQ(port_->stats().bus_offs, 1U);
  EXPECT_EQ(port_->stats().error_frames, 1U);
}

TEST_F(CanPortTest, other_reports_of_the_controller_are_counted_and_not_handed_out) {
  send(frame(CAN_ERR_FLAG | CAN_ERR_CRTL | CAN_ERR_ACK, Bytes(8)));
  send(frame(1, {7}));
  EXPECT_EQ(read().value(), frame(1, {7}));
  EXPECT_EQ(port_->stats().error_frames, 1U);
  EXPECT_EQ(port_->stats().bus_offs, 0U);
}

TEST_F(CanPortTest, a_read_of_another_length_is_dropped_and_counted) {
  send({1, 2, 3});
  send(frame(1) + frame(2));
  send(frame(3));
  EXPECT_EQ(read().value(), frame(3));
  EXPECT_EQ(port_->stats().odd_reads, 2U);
}

TEST_F(CanPortTest, a_bus_that_takes_nothing_would_block_until_it_takes_frames_again) {
  Result<void, StreamFault> sent;
  for (int frames = 0; sent && frames < 100000; ++frames) sent = port_->write(frame(1, {7}));
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error(), StreamFault::WouldBlock);
  while (!received().empty()) {}
  EXPECT_TRUE(port_->write(frame(1, {7})));
}

TEST_F(CanPortTest, tells_whether_frames_wait) {
  EXPECT_EQ(port_->unsent(), 0U);
  ASSERT_TRUE(port_->write(frame(1, {7})));
  EXPECT_GT(port_->unsent(), 0U);
  EXPECT_FALSE(received().empty());
  EXPECT_EQ(port_->unsent(), 0U);
}

TEST_F(CanPortTest, an_interrupt_ends_a_read_that_waits) {
  port_->interrupt();
  EXPECT_TRUE(read().value().empty());
}

TEST_F(CanPortTest, a_closed_other_end_hung_up) {
  bus_ = Descriptor{};
  EXPECT_EQ(read().error(), StreamFault::HungUp);
  EXPECT_EQ(port_->write(frame(1)).error(), StreamFault::HungUp);
}

TEST_F(CanPortTest, keeps_its_number_while_its_interface_is_not_there) {
  const int before = port_->descriptor();
  EXPECT_EQ(port_->reopen().error(), StreamFault::NotFound);
  EXPECT_TRUE(port_->is_away());
  EXPECT_EQ(read().error(), StreamFault::NotFound);
  EXPECT_EQ(port_->write(frame(1)).error(), StreamFault::NotFound);
  EXPECT_EQ(port_->descriptor(), before);
}

TEST(CanPortOpen, names_the_interface_and_the_way_out) {
  const SystemClock clock;
  const auto what = [&](const std::string& interface) {
    const auto port = CanPort::open({.interface = interface}, clock);
    EXPECT_FALSE(port);
    return port ? Problem{} : port.error();
  };
  EXPECT_EQ(what("no-such-can").where.words, "no-such-can");
  EXPECT_EQ(what("no-such-can").what, "no such CAN interface");
  EXPECT_EQ(what("lo").what, "not a CAN interface");
  EXPECT_EQ(what("").what, "'' is no name of an interface");
  EXPECT_EQ(what("a-name-of-16-chr").what, "'a-name-of-16-chr' is no name of an interface");
  EXPECT_FALSE(CanPort::open_or_await({.interface = "lo"}, clock)) << "no time mends that";
}

}  // namespace
}  // namespace nacelle::io::can_test
