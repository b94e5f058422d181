// SPDX-License-Identifier: Apache-2.0
#include "look/model/outbox.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::look {

bool Outbox::answer(bool is_binary, Bytes bytes) {
  if (!answers_.empty() && answer_bytes_ + bytes.size() > kMostAnswers) return false;
  answer_bytes_ += bytes.size();
  answers_.push_back({is_binary, std::move(bytes), 0, nullptr});
  return true;
}

void Outbox::message(std::uint32_t subscription, std::shared_ptr<const Encoded> message) {
  std::size_t waiting = message->bytes.size();
  for (const Item& item : messages_) {
    if (item.subscription == subscription) waiting += item.message->bytes.size();
  }
  // The oldest ones make room; a message that is larger than all the room waits alone.
  for (auto item = messages_.begin(); waiting > kSmallBytes && item != messages_.end();) {
    if (item->subscription != subscription) {
      ++item;
      continue;
    }
    waiting -= item->message->bytes.size();
    item = messages_.erase(item);
    ++dropped_;
  }
  messages_.push_back({true, {}, subscription, std::move(message)});
}

void Outbox::forget(std::uint32_t subscription) {
  std::erase_if(messages_, [&](const Item& item) { return item.subscription == subscription; });
}

void Outbox::refill(MonotonicTime now) {
  constexpr double kMostSeconds = 0.25;  // what was not used is not saved up
  const double most = static_cast<double>(rate_) * kMostSeconds;
  if (filled_ == MonotonicTime{}) {
    allowance_ = most;
  } else {
    allowance_ = std::min(most, allowance_ + static_cast<double>(rate_) * to_seconds(now - filled_));
  }
  filled_ = now;
}

bool Outbox::has_next(MonotonicTime now) {
  if (!answers_.empty()) return true;
  if (messages_.empty()) return false;
  if (rate_ == 0) return true;
  refill(now);
  return allowance_ > 0.0;
}

std::optional<Outbox::Item> Outbox::next(MonotonicTime now) {
  if (!has_next(now)) return std::nullopt;
  auto& from = answers_.empty() ? messages_ : answers_;
  Item item = std::move(from.front());
  from.pop_front();
  if (item.message == nullptr) {
    answer_bytes_ -= item.answer.size();
  } else if (rate_ != 0) {
    allowance_ -= static_cast<double>(item.message->bytes.size());
  }
  return item;
}

}  // namespace nacelle::look
