// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/serial_port.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <termios.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "nacelle/io/baud.hpp"
#include "nacelle/io/pty_pair.hpp"

namespace nacelle::io {
namespace {

// Real kernel terminals: the waits below end with an event, the deadlines are only there so that a broken build ends
// too.
constexpr Duration kPatience = 20s;

class SerialPortTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto pty = PtyPair::create();
    ASSERT_TRUE(pty) << pty.error().text();
    device_ = std::move(pty).value();
  }
  std::unique_ptr<SerialPort> open(const std::string& path) {
    auto port = SerialPort::open({path, 230400}, clock_);
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
  Bytes every_byte() {
    Bytes all(256);
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
    return all;
  }
  SystemClock clock_;
  std::unique_ptr<PtyPair> device_;
};

TEST_F(SerialPortTest, carries_every_byte_value_both_ways_unchanged) {
  const auto port = open(device_->path());
  ASSERT_EQ(device_->write_some(every_byte()), 256U);
  EXPECT_EQ(read(*port, 256), every_byte());

  ASSERT_TRUE(port->write(every_byte()));
  Bell never;
  Bytes got;
  while (got.size() < 256 &&
         wait_readable(device_->device_end(), never, clock_, clock_.now() + kPatience) == Wake::Ready) {
    const auto bytes = device_->read();
    ASSERT_TRUE(bytes);
    got.insert(got.end(), bytes->begin(), bytes->end());
  }
  EXPECT_EQ(got, every_byte());
}

TEST_F(SerialPortTest, sets_baud_rates_that_have_no_name) {
  for (const unsigned baud : {128000U, 256000U, 512000U, 115200U}) {
    const auto port = SerialPort::open({device_->path(), baud}, clock_);
    ASSERT_TRUE(port) << baud;
    EXPECT_EQ(baud_of(port.value()->descriptor()), baud);
  }
}

TEST_F(SerialPortTest, sets_the_asked_baud_rate_and_raw_mode) {
  const auto port = open(device_->path());
  termios options{};
  ASSERT_EQ(tcgetattr(port->descriptor(), &options), 0);
  EXPECT_EQ(cfgetospeed(&options), static_cast<speed_t>(B230400));
  EXPECT_EQ(options.c_lflag & static_cast<tcflag_t>(ECHO | ICANON | ISIG), 0U);
  EXPECT_EQ(options.c_cflag & static_cast<tcflag_t>(CSIZE | PARENB | CSTOPB | HUPCL), static_cast<tcflag_t>(CS8));
}

TEST_F(SerialPortTest, returns_nothing_at_the_deadline) {
  const auto port = open(device_->path());
  const auto bytes = port->read_until(clock_.now());
  ASSERT_TRUE(bytes);
  EXPECT_TRUE(bytes->empty());
}

TEST_F(SerialPortTest, an_interrupt_ends_a_read_that_waits) {
  const auto port = open(device_->path());
  bool empty = false;
  std::thread reader{[&] {
    const auto bytes = port->read_until(clock_.now() + std::chrono::hours{1});
    empty = bytes && bytes->empty();
  }};
  port->interrupt();
  reader.join();
  EXPECT_TRUE(empty);
}

TEST_F(SerialPortTest, a_pulled_cable_is_a_fault_and_not_the_end) {
  const auto port = open(device_->path());
  device_->hang_up();
  EXPECT_EQ(port->read_until(clock_.now() + kPatience).error(), StreamFault::HungUp);
  EXPECT_FALSE(port->write(Bytes{1}));
}

TEST_F(SerialPortTest, comes_back_on_the_same_path_with_the_same_descriptor) {
  const std::string link = ::testing::TempDir() + "serial_port_test_" + std::to_string(getpid());
  ASSERT_TRUE(device_->link_as(link));
  const auto port = open(link);
  const int before = port->descriptor();
  device_->hang_up();
  ASSERT_EQ(port->read_until(clock_.now() + kPatience).error(), StreamFault::HungUp);
  EXPECT_FALSE(port->reopen());
  EXPECT_TRUE(port->is_away()) << "an open line would keep its number";

  auto fresh = PtyPair::create();
  ASSERT_TRUE(fresh);
  ASSERT_TRUE(fresh.value()->link_as(link));
  ASSERT_TRUE(port->reopen());

  EXPECT_EQ(port->descriptor(), before);
  ASSERT_EQ(fresh.value()->write_some(Bytes{42}), 1U);
  EXPECT_EQ(read(*port, 1), Bytes{42});
}

TEST_F(SerialPortTest, drops_what_was_sent_before_it_was_opened) {
  ASSERT_EQ(device_->write_some(Bytes{1, 2, 3}), 3U);
  Bell never;
  const Descriptor other{::open(device_->path().c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK)};
  ASSERT_EQ(wait_readable(other.number(), never, clock_, clock_.now() + kPatience), Wake::Ready);

  const auto port = open(device_->path());
  ASSERT_EQ(device_->write_some(Bytes{9}), 1U);
  EXPECT_EQ(read(*port, 1), Bytes{9});
}

TEST_F(SerialPortTest, is_for_one_program_at_a_time) {
  const auto first = open(device_->path());
  const auto second = SerialPort::open({device_->path(), 230400}, clock_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().what.rfind("in use by ", 0), 0U) << second.error().text();
}

TEST_F(SerialPortTest, can_be_opened_again_after_it_was_closed) {
  open(device_->path()).reset();
  EXPECT_NE(open(device_->path()), nullptr);
}

TEST(SerialPortProblems, a_missing_device_is_named_with_the_way_out) {
  const SystemClock clock;
  const auto port = SerialPort::open({"/dev/no_such_line", 115200}, clock);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().where.text(), "/dev/no_such_line");
  EXPECT_NE(port.error().text().find("no such device"), std::string::npos);
  EXPECT_NE(port.error().text().find("plugged in"), std::string::npos);
}

TEST(SerialPortProblems, a_file_is_not_a_serial_line) {
  const SystemClock clock;
  const auto port = SerialPort::open({"/dev/null", 115200}, clock);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().what, "not a serial line");
}

TEST(SerialPortProblems, an_odd_baud_rate_is_refused_before_anything_is_opened) {
  const SystemClock clock;
  const auto port = SerialPort::open({"/dev/no_such_line", 123456}, clock);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().what, "123456 is not a standard baud rate");
}

TEST_F(SerialPortTest, waits_for_a_path_that_appears_later) {
  const std::string link = ::testing::TempDir() + "serial_port_late_" + std::to_string(getpid());
  std::unique_ptr<SerialPort> port;
  std::thread opener{[&] {
    auto opened = SerialPort::open({link, 115200}, clock_, kPatience);
    if (opened) port = std::move(opened).value();
  }};
  EXPECT_TRUE(device_->link_as(link));
  opener.join();
  EXPECT_NE(port, nullptr);
}

TEST(ByteTime, is_ten_bits_of_the_line) {
  EXPECT_EQ(byte_time(115200), Duration{86805});
  EXPECT_EQ(byte_time(230400), Duration{43402});
}

}  // namespace
}  // namespace nacelle::io
