// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/register_stream.hpp"

#include <gtest/gtest.h>

#include <deque>

#include "nacelle/io/i2c_bus.hpp"
#include "nacelle/io/scripted_bus.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::io {
namespace {

/// A chip with a FIFO at register 0x20, whose level stands in 0x10 and 0x11, and a register 0x30.
struct Chip {
  std::deque<std::uint8_t> fifo;
  std::uint8_t value = 0x55;
  std::uint8_t pointer = 0;

  bool transfer(ByteView out, ByteSpan in) {
    if (!out.empty()) pointer = out[0];
    for (auto& byte : in) {
      if (pointer == 0x10) byte = static_cast<std::uint8_t>(fifo.size() >> 8U);
      if (pointer == 0x11) byte = static_cast<std::uint8_t>(fifo.size());
      if (pointer == 0x30) byte = value;
      if (pointer == 0x20) {
        byte = fifo.front();
        fifo.pop_front();
      } else {
        ++pointer;
      }
    }
    return true;
  }
};

class RegisterStreamTest : public ::testing::Test {
 protected:
  RegisterStreamTest() {
    auto bus = std::make_unique<ScriptedBus>([this](MonotonicTime until) {
      if (until > clock_.now()) clock_.advance(until - clock_.now());
    });
    bus_ = bus.get();
    bus_->attach(0x42, [this](ByteView out, ByteSpan in) { return chip_.transfer(out, in); });
    bus_->allow_until(clock_.now() + 1000s);
    std::vector<PollBlock> blocks{{.tag = 1, .address = 0x42, .reg = 0x30, .length = 1},
                                  {.tag = 2,
                                   .address = 0x42,
                                   .reg = 0x20,
                                   .length = 4,
                                   .fill = PollBlock::Fill{.reg = 0x10},
                                   .most = 8,
                                   .full = 16}};
    stream_ = std::make_unique<RegisterStream>(std::move(bus), std::move(blocks), 10ms, clock_);
  }
  std::string read() {
    const auto bytes = stream_->read_until(clock_.now() + 100ms);
    return bytes ? to_hex(*bytes) : std::string{explain(bytes.error())}.substr(0, 12);
  }

  test::ManualClock clock_;
  Chip chip_;
  ScriptedBus* bus_ = nullptr;
  std::unique_ptr<RegisterStream> stream_;
};

TEST_F(RegisterStreamTest, each_poll_gives_a_block_for_each_answer) {
  chip_.fifo = {1, 2, 3, 4};
  EXPECT_EQ(read(),
            "01010055"
            "02040001020304");
  EXPECT_EQ(read(), "01010055") << "an empty FIFO gives no block";
}

TEST_F(RegisterStreamTest, reads_whole_records_of_a_fifo_and_at_most_so_many) {
  chip_.fifo = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(read(),
            "01010055"
            "02040001020304");
  chip_.fifo = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  EXPECT_EQ(read(),
            "01010055"
            "0208000102030405060708");
}

TEST_F(RegisterStreamTest, polls_at_its_period) {
  const MonotonicTime start = clock_.now();
  for (int i = 0; i < 5; ++i) read();
  EXPECT_EQ(clock_.now() - start, 50ms);
}

TEST_F(RegisterStreamTest, does_not_make_up_for_polls_that_a_delay_has_missed) {
  read();
  clock_.advance(1s);
  const auto before = bus_->transfers();
  const MonotonicTime late = clock_.now();
  read();
  read();
  EXPECT_LE(clock_.now() - late, 20ms);
  EXPECT_EQ(bus_->transfers() - before, 4U);
}

TEST_F(RegisterStreamTest, a_full_fifo_is_told_and_then_a_fault_so_that_the_device_is_set_up_anew) {
  chip_.fifo.assign(16, 7);
  EXPECT_EQ(read(),
            "01010055"
            "820000");
  EXPECT_EQ(stream_->read_until(clock_.now() + 100ms).error(), StreamFault::ReadFailed);
}

TEST_F(RegisterStreamTest, one_nak_is_tried_again_and_counted) {
  bus_->lose_every(3);  // level, value, level, value ...: each third transfer
  for (int i = 0; i < 6; ++i) EXPECT_EQ(read(), "01010055");
  EXPECT_GT(stream_->retries(), 0U);
}

TEST_F(RegisterStreamTest, a_device_that_answers_no_more_is_a_nak) {
  bus_->attach(0x42, {});
  EXPECT_EQ(stream_->read_until(clock_.now() + 100ms).error(), StreamFault::NoAnswer);
}

TEST_F(RegisterStreamTest, a_stuck_bus_is_not_tried_again) {
  bus_->fail(StreamFault::BusStuck);
  const auto before = bus_->transfers();
  EXPECT_EQ(stream_->read_until(clock_.now() + 100ms).error(), StreamFault::BusStuck);
  EXPECT_EQ(bus_->transfers() - before, 1U);
}

TEST_F(RegisterStreamTest, what_was_read_before_a_fault_comes_first) {
  int answers = 0;
  bus_->attach(0x42, [&](ByteView out, ByteSpan in) { return ++answers <= 1 && chip_.transfer(out, in); });
  EXPECT_EQ(read(), "01010055");
  EXPECT_EQ(stream_->read_until(clock_.now() + 100ms).error(), StreamFault::NoAnswer);
}

TEST_F(RegisterStreamTest, is_away_until_it_is_opened_again) {
  stream_->start_away();
  EXPECT_EQ(stream_->read_until(clock_.now() + 100ms).error(), StreamFault::NotFound);
  ASSERT_TRUE(stream_->reopen());
  EXPECT_EQ(read(), "01010055");
}

TEST_F(RegisterStreamTest, an_interrupt_ends_a_read_with_no_bytes) {
  stream_->interrupt();
  EXPECT_EQ(read(), "");
  EXPECT_EQ(read(), "01010055");
}

std::string refusal_of(const std::string& path) {
  const test::ManualClock clock;
  const auto bus = I2cBus::open({path, 0x68}, clock);
  return bus ? "opened" : bus.error().text();
}

TEST(I2cBus, says_what_is_wrong_with_a_path_and_what_helps) {
  const std::string missing = refusal_of("/dev/i2c-no-such-bus");
  EXPECT_NE(missing.find("/dev/i2c-no-such-bus: no such bus"), std::string::npos) << missing;
  EXPECT_NE(missing.find("raspi-config"), std::string::npos) << missing;
  const std::string other = refusal_of("/dev/null");
  EXPECT_NE(other.find("not an I2C bus"), std::string::npos) << other;
}

TEST(I2cBus, an_absent_bus_is_awaited_and_its_transfers_say_that_it_is_not_there) {
  const test::ManualClock clock;
  const auto bus = I2cBus::open_or_await({"/dev/i2c-no-such-bus", 0x68}, clock);
  ASSERT_TRUE(bus);
  EXPECT_TRUE((*bus)->is_away());
  std::uint8_t byte = 0;
  EXPECT_EQ(read_registers(**bus, 0x68, 0x75, {&byte, 1}).error(), StreamFault::NotFound);
  EXPECT_EQ((*bus)->reopen().error(), StreamFault::NotFound);
}

}  // namespace
}  // namespace nacelle::io
