// SPDX-License-Identifier: Apache-2.0
#include "record/component/kept_messages.hpp"

#include <algorithm>

namespace nacelle::record {
namespace {

constexpr std::size_t kMostKeptOfOne = 100;

}  // namespace

bool is_latched(const std::vector<QoS>& offered) {
  return !offered.empty() && std::all_of(offered.begin(), offered.end(), [](const QoS& one) {
    return one.resolved().durability() == Durability::TransientLocal;
  });
}

std::size_t kept_depth(const std::vector<QoS>& offered) {
  std::size_t depth = 1;
  for (const QoS& one : offered) depth = std::max(depth, one.resolved().queue_capacity());
  return std::min(depth, kMostKeptOfOne);
}

void KeptMessages::forget(const std::deque<Message>::iterator& which) {
  bytes_ -= which->bytes.size();
  messages_.erase(which);
}

void KeptMessages::keep(std::size_t topic, std::uint64_t writer, ByteView bytes, std::size_t depth) {
  if (bytes.size() > most_bytes_) return;
  const auto is_of_same = [&](const Message& other) { return other.topic == topic && other.writer == writer; };
  const auto others = static_cast<std::size_t>(std::count_if(messages_.begin(), messages_.end(), is_of_same));
  if (others >= depth) forget(std::find_if(messages_.begin(), messages_.end(), is_of_same));
  bytes_ += bytes.size();
  messages_.push_back({topic, writer, Bytes(bytes.begin(), bytes.end())});
  while (bytes_ > most_bytes_) forget(messages_.begin());
}

}  // namespace nacelle::record
