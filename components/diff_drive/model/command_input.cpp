// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/command_input.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::diff_drive {

CommandInput::CommandInput(Settings settings) : settings_(std::move(settings)), channels_(settings_.sources.size()) {}

void CommandInput::disarm_all() {
  for (Channel& channel : channels_) channel.armed = channel.in_force = false;
  selected_ = kNobody;
}

void CommandInput::arm(MonotonicTime now) {
  armed_at_ = now;
  // No command was read until now: an input may have been anything but neutral.
  for (Channel& channel : channels_) channel = Channel{.restless_at = now};
  selected_ = kNobody;
  state_ = holds_ != 0 ? State::Held : State::Waiting;
}

void CommandInput::forget(MonotonicTime now) {
  const bool was_driving = selected_ != kNobody && channels_[selected_].armed;
  arm(now);
  // Unlike at an activation, the senders may have been there before.
  for (Channel& channel : channels_) channel.heard = true;
  if (!was_driving || holds_ != 0) return;
  state_ = State::TimedOut;
  ++stats_.timeouts;
}

void CommandInput::hold(Hold why) {
  holds_ |= static_cast<std::uint8_t>(why);
  disarm_all();
  state_ = State::Held;
}

void CommandInput::release(Hold why, MonotonicTime now) {
  if (!is_held(why)) return;
  holds_ &= static_cast<std::uint8_t>(~static_cast<std::uint8_t>(why));
  armed_at_ = std::max(armed_at_, now);
  if (holds_ == 0) state_ = State::Waiting;
}

Duration CommandInput::neutral_period(std::size_t index) const {
  const Duration timeout = settings_.sources[index].timeout;
  return timeout > Duration::zero() ? timeout : kNeutralWithoutTimeout;
}

bool CommandInput::take(std::size_t index, const DriveCommand& command) {
  Channel& channel = channels_[index];
  const bool of_motion = command.wanted != BodyTwist{};
  if (!std::exchange(channel.heard, true) && command.first_of_sender && command.received_at >= armed_at_) {
    // This sender began after us, so its silence before is known.
    channel.restless_at = MonotonicTime{armed_at_ - neutral_period(index)};
  }
  const bool early = command.received_at < armed_at_;
  const bool blocked = holds_ != 0 || settings_.sources[index].priority < lock_priority_;
  const bool neutral_before = command.received_at - channel.restless_at >= neutral_period(index);
  if (of_motion) channel.restless_at = std::max(channel.restless_at, command.received_at);
  if (early) {
    ++stats_.early;
    return false;
  }
  if (!channel.armed) {
    const bool may_arm = !blocked && (settings_.rearm == RearmRule::Fresh || (of_motion && neutral_before));
    if (!may_arm) {
      if (!of_motion) {
        // A zero command takes effect without a neutral phase: it overrides inputs of a lower priority (an operator only stops
        // the robot).
        channel.command = command;
        channel.in_force = !blocked && settings_.sources.size() > 1;
        return false;
      }
      ++stats_.disarmed;
      channel.disarmed_at = command.received_at;
      channel.was_disarmed = true;
      return false;
    }
    channel.armed = true;
    channel.was_disarmed = false;
  }
  channel.command = command;
  channel.in_force = true;
  ++stats_.taken;
  return true;
}

bool CommandInput::take_holds(const CommandInbox& inbox) {
  bool any = false;
  const auto follow = [&](const CommandInbox::HoldFlag& flag, Hold why) {
    if (!flag.is_set.load(std::memory_order_acquire))
      return release(why, MonotonicTime{Duration{flag.released_at_ns.load()}});
    if (is_held(why)) return;
    hold(why);
    any = true;
  };
  follow(inbox.emergency_stop, Hold::EmergencyStop);
  follow(inbox.unguarded, Hold::Unguarded);
  follow(inbox.inactive, Hold::Inactive);
  return any;
}

bool CommandInput::take(CommandInbox& inbox, MonotonicTime now, DriveCommand& newest) {
  take_holds(inbox);

  lock_priority_ = lock_priority(inbox, now);
  bool any = false;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Channel& channel = channels_[i];
    if (settings_.sources[i].priority < lock_priority_) channel.armed = channel.in_force = false;
    CommandInbox::Source& source = inbox.sources[i];
    const MonotonicTime refused_at{Duration{source.refused_at_ns.load(std::memory_order_acquire)}};
    // A sender whose commands are refused is not at rest.
    channel.restless_at = std::max(channel.restless_at, refused_at);
    if (const auto command = source.commands.take(); command && take(i, *command)) {
      newest = *command;
      any = true;
    }
  }
  return any;
}

int CommandInput::lock_priority(const CommandInbox& inbox, MonotonicTime now) const {
  int highest = -1;
  for (std::size_t i = 0; i < settings_.locks.size(); ++i) {
    const Lock& lock = settings_.locks[i];
    const CommandInbox::Lock& said = inbox.locks[i];
    const std::int64_t heard_ns = said.heard_at_ns.load(std::memory_order_acquire);
    const bool silent = lock.timeout > Duration::zero() &&
                        (heard_ns == CommandInbox::kNever || now.nanoseconds() - heard_ns > lock.timeout.count());
    if (silent || said.locked.load(std::memory_order_acquire)) highest = std::max<int>(highest, lock.priority);
  }
  return highest;
}

BodyTwist CommandInput::wanted(MonotonicTime now) {
  const std::size_t before = selected_;
  const bool was_followed = before != kNobody && channels_[before].armed;  // and not only at zero
  std::size_t best = kNobody;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Channel& channel = channels_[i];
    const Source& source = settings_.sources[i];
    if (channel.in_force && source.timeout > Duration::zero() && now - channel.command.received_at > source.timeout)
      channel.in_force = channel.armed = false;
    if (!channel.in_force) continue;
    if (best == kNobody || source.priority > settings_.sources[best].priority) best = i;
  }
  selected_ = best;
  if (best != kNobody) {
    if (before != kNobody && before != best) ++stats_.handovers;
    state_ = channels_[best].armed ? State::Driving : State::Waiting;
    return channels_[best].command.wanted;
  }
  if (holds_ != 0) {
    state_ = State::Held;
  } else if (before != kNobody) {
    const bool locked = settings_.sources[before].priority < lock_priority_;
    state_ = locked ? State::Locked : was_followed ? State::TimedOut : State::Waiting;
    if (!locked && was_followed) ++stats_.timeouts;
  } else if (state_ == State::Locked && lock_priority_ < 0) {
    state_ = State::Waiting;
  }
  return {};
}

bool CommandInput::waits_for_neutral(MonotonicTime now) const {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Channel& channel = channels_[i];
    if (!channel.armed && channel.was_disarmed && now - channel.disarmed_at <= neutral_period(i)) return true;
  }
  return false;
}

}  // namespace nacelle::diff_drive
