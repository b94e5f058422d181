// SPDX-License-Identifier: Apache-2.0
#include "joy/component/joy_stream.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::joy {
namespace {

// A kernel's time that is older, or not from this clock, is not believed.
constexpr Duration kOldestEvent = 1s;

}  // namespace

JoyStream::JoyStream(const JoyOptions& options, const Clock& clock, PadPort& pad,
                     std::shared_ptr<Publisher<sensor_msgs::msg::Joy>> publisher, const Logger& logger,
                     DeviceWatch& watch)
    : options_(options),
      clock_(clock),
      pad_(pad),
      publisher_(std::move(publisher)),
      logger_(logger),
      watch_(watch),
      state_(options.pad),
      pacer_(options.pace) {}

void JoyStream::begin(MonotonicTime now) {
  const LockGuard lock{mutex_};
  load(now);
}

void JoyStream::load(MonotonicTime now) {
  const auto pad = pad_.inspect();
  if (!pad) return;  // the next read says so
  state_.load(*pad);
  change_ = PadState::Change::None;
  if (!std::exchange(is_there_, true))
    logger_.info("{}: '{}' with {} buttons and {} axes", pad->path, pad->name, state_.buttons().size(),
                 state_.axes().size());
  watch_.heard(now);
}

void JoyStream::on_bytes(ByteView bytes, MonotonicTime received) {
  const LockGuard lock{mutex_};
  while (const auto event = decoder_.next(bytes)) take(*event, received);
  counters_.line = decoder_.stats();
  watch_.heard(received);
}

void JoyStream::take(const InputEvent& event, MonotonicTime received) {
  if (event.is_syn(input_layout::kSynDropped)) {
    drops_ = true;
    ++counters_.overruns;
  } else if (!event.is_syn(input_layout::kSynReport)) {
    if (!drops_) change_ = std::max(change_, state_.take(event));
  } else {
    ++counters_.groups;
    if (std::exchange(drops_, false)) {
      load(received);
      change_ = PadState::Change::Button;
    }
    const auto change = std::exchange(change_, PadState::Change::None);
    const Duration age = received - event.at;
    changed_at_ = age >= Duration::zero() && age <= kOldestEvent ? event.at : received;
    if (pacer_.on_change(change, received)) publish(changed_at_, received);
  }
}

void JoyStream::on_silence(MonotonicTime now) {
  const LockGuard lock{mutex_};
  if (!is_there_) return watch_.look(now, [] { return std::string("the gamepad is not there"); });
  watch_.heard(now);  // a pad that lies on the table is not lost
  if (pacer_.is_due(now)) publish(pacer_.waits() ? changed_at_ : now, now);
}

MonotonicTime JoyStream::look_at(MonotonicTime latest) const {
  const LockGuard lock{mutex_};
  return may_publish() ? pacer_.next(latest) : latest;
}

void JoyStream::on_break(io::StreamFault fault, MonotonicTime now) {
  const LockGuard lock{mutex_};
  if (may_publish()) publish_neutral(now);
  is_there_ = drops_ = false;
  decoder_.restart();
  pacer_.restart();
  watch_.lose(std::string(io::explain(fault)));
}

void JoyStream::on_return(MonotonicTime now) {
  const LockGuard lock{mutex_};
  load(now);
}

void JoyStream::set_active(bool active) {
  const LockGuard lock{mutex_};
  if (!active && may_publish()) publish_neutral(clock_.now());
  active_ = active;
}

void JoyStream::publish(MonotonicTime at, MonotonicTime now) {
  pacer_.on_published(now);
  if (!may_publish()) return;
  auto message = publisher_->borrow();
  if (!message) return;  // every pooled message is still being read; the publisher counted it
  // Both clocks are read here, so that a step of the wall clock cannot come between the event and its stamp.
  message->header.stamp = clock_.wall_now() - (clock_.now() - at);
  message->header.frame_id = "joy";
  message->axes.assign(state_.axes().begin(), state_.axes().end());
  message->buttons.assign(state_.buttons().begin(), state_.buttons().end());
  publisher_->publish(std::move(message));
  ++counters_.published;
}

void JoyStream::publish_neutral(MonotonicTime now) {
  auto message = publisher_->borrow();
  if (!message) return;
  message->header.stamp = clock_.wall_now() - (clock_.now() - now);
  message->header.frame_id = "joy";
  message->axes.resize_uninitialized(state_.axes().size());
  message->buttons.resize_uninitialized(state_.buttons().size());
  std::fill(message->axes.begin(), message->axes.end(), 0.0F);
  std::fill(message->buttons.begin(), message->buttons.end(), 0);
  publisher_->publish(std::move(message));
  ++counters_.published;
  ++counters_.neutral;
}

JoyCounters JoyStream::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::joy
