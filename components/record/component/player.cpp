// SPDX-License-Identifier: Apache-2.0
#include "record/component/player.hpp"

#include <pthread.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::record {
namespace {

constexpr Duration kLongestWait = 1s;  // a gap of the recording may be longer than a clock can wait for

}  // namespace

Player::Player(OpenRecording recording, std::vector<Topic> topics, Options options, const Clock& clock)
    : recording_(std::move(recording)),
      topics_(std::move(topics)),
      options_(std::move(options)),
      clock_(clock),
      rate_(options_.rate),
      is_paused_(options_.starts_paused),
      base_(clock.now()),
      base_time_(options_.from),
      thread_([this] { run(); }) {}

Player::~Player() {
  {
    const LockGuard lock{mutex_};
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Player::rebase(std::uint64_t time) {
  base_ = clock_.now();
  base_time_ = time;
}

std::uint64_t Player::position() const {
  if (is_paused_) return base_time_;
  const double passed = std::max(0.0, static_cast<double>((clock_.now() - base_).count()) * rate_);
  const std::uint64_t left = options_.to - std::min(options_.to, base_time_);
  return passed >= static_cast<double>(left) ? options_.to : base_time_ + static_cast<std::uint64_t>(passed);
}

void Player::pause(bool is_paused) {
  {
    const LockGuard lock{mutex_};
    rebase(position());
    is_paused_ = is_paused;
  }
  changed_.notify_all();
}

bool Player::is_paused() const {
  const LockGuard lock{mutex_};
  return is_paused_;
}

bool Player::set_rate(double rate) {
  if (!(rate > 0.0) || !std::isfinite(rate)) return false;
  {
    const LockGuard lock{mutex_};
    rebase(position());
    rate_ = rate;
  }
  changed_.notify_all();
  return true;
}

double Player::rate() const {
  const LockGuard lock{mutex_};
  return rate_;
}

bool Player::play_next() {
  {
    const LockGuard lock{mutex_};
    if (!is_paused_ || figures_.has_ended) return false;
    ++steps_;
  }
  changed_.notify_all();
  return true;
}

bool Player::seek(std::uint64_t time) {
  {
    const LockGuard lock{mutex_};
    if (time < options_.from || time > options_.to || figures_.has_ended) return false;
    seeks_ = time;
  }
  changed_.notify_all();
  return true;
}

PlayerFigures Player::figures() const {
  const LockGuard lock{mutex_};
  PlayerFigures copy = figures_;
  copy.seconds = static_cast<double>(position() - options_.from) * 1e-9;
  return copy;
}

void Player::run() {
  ::pthread_setname_np(::pthread_self(), "play");
  std::uint64_t from = options_.from;
  for (;;) {
    recording_.messages->seek(from);
    {
      const LockGuard lock{mutex_};
      rebase(from);
    }
    Turn turn = Turn::Play;
    for (const auto* message = recording_.messages->next(); message != nullptr && message->log_time <= options_.to;
         message = recording_.messages->next()) {
      turn = wait_for(message->log_time);
      if (turn != Turn::Play) break;
      publish(*message);
    }
    // A round lasts as long as what is played, whatever messages are in it: one after the other would take all of a processor.
    const bool loops = options_.loops && options_.to > options_.from;
    if (turn == Turn::Play && loops) turn = wait_for(options_.to);
    if (turn == Turn::Stop) return;
    const LockGuard lock{mutex_};
    from = options_.from;
    if (turn == Turn::Seek) {
      from = seeks_.value_or(from);
      seeks_.reset();
    } else if (!loops) {
      figures_.has_ended = true;
      rebase(options_.to);
      is_paused_ = true;
      return;
    }
  }
}

/// Waits until it is the turn of what was recorded at this time.
Player::Turn Player::wait_for(std::uint64_t time) {
  UniqueLock lock{mutex_};
  for (;;) {
    if (is_ending_) return Turn::Stop;
    if (seeks_) return Turn::Seek;
    if (steps_ > 0) {
      --steps_;
      rebase(std::max(time, base_time_));
      return Turn::Play;
    }
    Duration wait = kLongestWait;
    if (!is_paused_) {
      const MonotonicTime now = clock_.now();
      const std::uint64_t at = position();
      if (options_.clock_period > Duration::zero() && now >= clock_due_) {
        clock_due_ = now + options_.clock_period;
        lock.unlock();
        options_.publish_clock(WallTime{Duration{static_cast<std::int64_t>(std::min(at, time))}});
        lock.lock();
        continue;
      }
      if (at >= time) return Turn::Play;
      const double left = std::ceil(static_cast<double>(time - at) / rate_);
      if (left < static_cast<double>(wait.count())) wait = Duration{static_cast<std::int64_t>(left)};
      if (options_.clock_period > Duration::zero()) wait = std::min(wait, clock_due_ - now);
    }
    changed_.wait_for(lock.raw(), wait);
  }
}

void Player::publish(const OrderedMessages::Message& message) {
  const Topic& topic = topics_[message.topic];
  if (topic.writer == nullptr) return;
  bool is_read = topic.keeps || topic.writer->reader_count() > 0, is_decoded = true;
  if (is_read) {
    Block* const block = topic.writer->borrow();
    if (block == nullptr) {
      is_read = false;
    } else if (is_decoded = topic.type->decode(message.data, block->message).has_value(); is_decoded) {
      static_cast<void>(topic.writer->publish(*block));
    } else {
      drop_reference(*block);
    }
  }
  const LockGuard lock{mutex_};
  ++(!is_read ? figures_.unread : is_decoded ? figures_.messages : figures_.undecoded);
}

}  // namespace nacelle::record
