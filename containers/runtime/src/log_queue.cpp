// SPDX-License-Identifier: Apache-2.0
#include "log_queue.hpp"

#include <array>
#include <cstring>
#include <utility>

namespace nacelle::runtime {
namespace {

// The header in front of a line's texts.
struct LineHead {
  std::int64_t wall_ns = 0;
  std::uint32_t number = 0;
  std::uint16_t text = 0, name = 0, file = 0, function = 0;  // bytes
  LogLevel level = LogLevel::Info;
};

// Does not cut inside a UTF-8 character.
std::string_view cut(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return text;
  while (longest > 0 && (static_cast<unsigned char>(text[longest]) & 0xC0U) == 0x80U) --longest;
  return text.substr(0, longest);
}

constexpr std::size_t kLongestName = 255;

}  // namespace

LogQueue::LogQueue() {
  filling_.reserve(kBytes);
  showing_.reserve(kBytes);
}

bool LogQueue::push(LogLevel level, WallTime when, std::string_view name, std::string_view text,
                    const LogPlace& place) noexcept {
  const std::array<std::string_view, 4> texts{cut(text, kLongestText), cut(name, kLongestName),
                                              cut(place.file, kLongestName), cut(place.function, kLongestName)};
  LineHead head;
  head.wall_ns = when.nanoseconds();
  head.number = place.line;
  head.level = level;
  head.text = static_cast<std::uint16_t>(texts[0].size());
  head.name = static_cast<std::uint16_t>(texts[1].size());
  head.file = static_cast<std::uint16_t>(texts[2].size());
  head.function = static_cast<std::uint16_t>(texts[3].size());
  std::size_t size = sizeof head;
  for (const auto part : texts) size += part.size();
  const LockGuard lock(mutex_);
  if (filling_.size() + size > kBytes) {
    ++dropped_;
    return false;
  }
  filling_.append(reinterpret_cast<const char*>(&head), sizeof head);
  for (const auto part : texts) filling_.append(part);
  return true;
}

std::uint64_t LogQueue::take(const std::function<void(const Line&)>& show) {
  std::uint64_t dropped = 0;
  {
    const LockGuard lock(mutex_);
    filling_.swap(showing_);
    dropped = std::exchange(dropped_, 0);
  }
  for (std::string_view left = showing_; !left.empty();) {
    LineHead head;
    std::memcpy(&head, left.data(), sizeof head);
    left.remove_prefix(sizeof head);
    const auto next = [&](std::size_t size) {
      const std::string_view part = left.substr(0, size);
      left.remove_prefix(size);
      return part;
    };
    Line line;
    line.level = head.level;
    line.when = WallTime{Duration{head.wall_ns}};
    line.number = head.number;
    line.text = next(head.text);
    line.name = next(head.name);
    line.file = next(head.file);
    line.function = next(head.function);
    show(line);
  }
  showing_.clear();
  return dropped;
}

}  // namespace nacelle::runtime
