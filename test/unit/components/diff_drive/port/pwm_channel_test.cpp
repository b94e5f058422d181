// SPDX-License-Identifier: Apache-2.0
// On a tree of plain files: they take every value, so what the kernel refuses is not tested here.
#include "diff_drive/port/pwm_channel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cerrno>
#include <thread>

#include "pwm_tree.hpp"

namespace nacelle::diff_drive {
namespace {

using ::testing::HasSubstr;

class PwmChannelTest : public ::testing::Test {
 protected:
  [[nodiscard]] PwmSettings settings(unsigned channel = 0) const {
    return {.chip = tree_.chip(), .channel = channel, .period_ns = 50'000, .patience = 0ms};
  }
  PwmTree tree_;
};

TEST_F(PwmChannelTest, is_off_when_it_is_opened_and_on_for_a_share_of_its_period) {
  const auto channel = PwmChannel::open(settings(1)).value();
  EXPECT_EQ(tree_.of_channel(1, "period"), "50000");
  EXPECT_EQ(tree_.of_channel(1, "polarity"), "normal");
  EXPECT_EQ(tree_.of_channel(1, "enable"), "1");
  EXPECT_EQ(tree_.of_channel(1, "duty_cycle"), "0");
  ASSERT_TRUE(channel->set(0.25));
  EXPECT_EQ(tree_.of_channel(1, "duty_cycle"), "12500");
  ASSERT_TRUE(channel->set(1.0));
  EXPECT_EQ(tree_.of_channel(1, "duty_cycle"), "50000");
  ASSERT_TRUE(channel->set(0.0));
  EXPECT_EQ(tree_.of_channel(1, "duty_cycle"), "0");
  EXPECT_EQ(tree_.of_channel(0, "enable"), "0") << "the other one";
}

TEST_F(PwmChannelTest, the_stop_frame_switches_it_off_from_any_writer) {
  const auto channel = PwmChannel::open(settings()).value();
  ASSERT_TRUE(channel->set(0.8));
  ASSERT_EQ(::write(channel->descriptor(), PwmChannel::kStop, sizeof PwmChannel::kStop), 2);
  EXPECT_EQ(tree_.of_channel(0, "duty_cycle"), "0");
}

TEST_F(PwmChannelTest, switches_off_what_a_killed_program_left_on) {
  tree_.put("pwmchip0/pwm0/period", "100000\n");
  tree_.put("pwmchip0/pwm0/duty_cycle", "90000\n");
  tree_.put("pwmchip0/pwm0/enable", "1\n");
  const auto channel = PwmChannel::open(settings()).value();
  EXPECT_EQ(tree_.of_channel(0, "duty_cycle"), "0");
  EXPECT_EQ(tree_.of_channel(0, "period"), "50000");
}

TEST_F(PwmChannelTest, is_switched_off_at_its_end) {
  {
    const auto channel = PwmChannel::open(settings()).value();
    ASSERT_TRUE(channel->set(0.8));
  }
  EXPECT_EQ(tree_.of_channel(0, "duty_cycle"), "0");
  EXPECT_EQ(tree_.of_channel(0, "enable"), "0");
  EXPECT_EQ(tree_.get("pwmchip0/unexport"), "") << "it was exported before";
}

TEST_F(PwmChannelTest, inverts_by_the_polarity_of_the_chip) {
  PwmSettings inverted = settings();
  inverted.is_inverted = true;
  auto channel = PwmChannel::open(inverted).value();
  EXPECT_EQ(tree_.of_channel(0, "polarity"), "inversed");
  ASSERT_TRUE(channel->set(0.5));
  channel.reset();
  EXPECT_EQ(tree_.of_channel(0, "duty_cycle"), "0");
  EXPECT_EQ(tree_.of_channel(0, "enable"), "1") << "disabled it would be low, and the motor on";
}

/// Does what the kernel does at an export: makes the channel's files. The export is a pipe here.
TEST_F(PwmChannelTest, exports_a_channel_and_gives_it_back) {
  std::filesystem::remove_all(tree_.chip() + "/pwm1");
  const std::string exports = tree_.chip() + "/export";
  std::filesystem::remove(exports);
  ASSERT_EQ(::mkfifo(exports.c_str(), 0600), 0);
  std::string asked;
  std::thread kernel{[&] {
    std::getline(std::ifstream{exports} >> std::ws, asked);
    tree_.add_channel(1);
  }};
  PwmSettings patient = settings(1);
  patient.patience = 20s;
  auto channel = PwmChannel::open(patient);
  kernel.join();
  ASSERT_TRUE(channel) << channel.error().text();
  EXPECT_EQ(asked, "1");
  channel.value().reset();
  EXPECT_EQ(tree_.get("pwmchip0/unexport"), "1");
}

TEST_F(PwmChannelTest, names_a_chip_and_a_channel_that_are_not_there) {
  PwmSettings wrong = settings();
  wrong.chip = tree_.root() + "/pwmchip7";
  const auto no_chip = PwmChannel::open(wrong);
  ASSERT_FALSE(no_chip);
  EXPECT_THAT(no_chip.error().text(), HasSubstr("pwmchip7"));
  EXPECT_THAT(no_chip.error().text(), HasSubstr("no such chip"));
  EXPECT_THAT(no_chip.error().text(), HasSubstr("dtoverlay=pwm-2chan"));
  const auto no_channel = PwmChannel::open(settings(2));
  ASSERT_FALSE(no_channel);
  EXPECT_THAT(no_channel.error().text(), HasSubstr("channel 2"));
  EXPECT_THAT(no_channel.error().text(), HasSubstr("has no such channel"));
}

TEST_F(PwmChannelTest, names_the_program_that_drives_the_channel) {
  const auto first = PwmChannel::open(settings()).value();
  ASSERT_TRUE(first->set(0.5));
  const auto second = PwmChannel::open(settings());
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().text(), HasSubstr("in use by diff_drive_port (pid "));
  EXPECT_EQ(tree_.of_channel(0, "duty_cycle"), "25000") << "and leaves it alone";
}

TEST_F(PwmChannelTest, explains_what_the_kernel_refuses) {
  const auto text = [&](PwmFault::Step step, int os_code) { return explain_pwm(settings(), {step, os_code}).text(); };
  EXPECT_THAT(text(PwmFault::Step::Export, EBUSY), HasSubstr("in use by a driver of the kernel"));
  EXPECT_THAT(text(PwmFault::Step::Export, EACCES), HasSubstr("no permission"));
  EXPECT_THAT(text(PwmFault::Step::Open, EACCES), HasSubstr("usermod -aG gpio"));
  EXPECT_THAT(text(PwmFault::Step::Period, EINVAL), HasSubstr("does not do 20000 Hz"));
  EXPECT_THAT(text(PwmFault::Step::Polarity, EINVAL), HasSubstr("cannot invert"));
  EXPECT_THAT(text(PwmFault::Step::Enable, EIO), HasSubstr("Input/output error"));
}

TEST_F(PwmChannelTest, a_chip_that_is_gone_refuses_and_comes_back_under_the_same_descriptor) {
  const auto channel = PwmChannel::open(settings()).value();
  const int number = channel->descriptor();
  ASSERT_TRUE(channel->set(0.5));
  break_channel(number);
  std::filesystem::rename(tree_.chip(), tree_.chip() + "_gone");
  EXPECT_FALSE(channel->set(0.7));
  EXPECT_FALSE(channel->reopen());
  EXPECT_EQ(channel->descriptor(), number);
  std::filesystem::rename(tree_.chip() + "_gone", tree_.chip());
  ASSERT_TRUE(channel->reopen());
  EXPECT_EQ(channel->descriptor(), number);
  EXPECT_EQ(tree_.of_channel(0, "duty_cycle"), "0");
  ASSERT_TRUE(channel->set(0.7));
  EXPECT_EQ(tree_.of_channel(0, "duty_cycle"), "35000");
  EXPECT_TRUE(channel->reopen()) << "also one that never went away";
}

}  // namespace
}  // namespace nacelle::diff_drive
