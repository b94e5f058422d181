// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_diff.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nacelle::record {
namespace {

/// Where two messages differ that cannot be decoded.
ValueDifference byte_difference(ByteView a, ByteView b) {
  if (a.size() != b.size()) return {"", fmt::format("{} bytes", a.size()), fmt::format("{} bytes", b.size())};
  const auto at = static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin()).first - a.begin());
  return {fmt::format("byte {}", at), fmt::format("{:#04x}", a[at]), fmt::format("{:#04x}", b[at])};
}

}  // namespace

Result<void, Problem> RecordingDiff::add_topic(const std::string& name, const Topic& in_a, const Topic& in_b) {
  Pairing& pairing = topics_[name];
  TopicDiff& result = pairing.result;
  result.name = name;
  result.type_a = in_a.type;
  result.type_b = in_b.type;
  result.in_a = in_a.messages;
  result.in_b = in_b.messages;
  pairing.pairs = std::min(in_a.messages, in_b.messages);
  if (in_a.type != in_b.type) return {};
  const msgs::MessageType* const type = find_type_(in_a.type);
  const auto other = [&](const std::string& hash) { return !hash.empty() && hash != type->hash; };
  if (type == nullptr) {
    result.remark = "compared by bytes: the type is not installed";
  } else if (other(in_a.hash) || other(in_b.hash)) {
    result.remark = "compared by bytes: recorded with another definition of the type";
  } else {
    if (auto checked = tolerances_.check(name, *type); !checked) return checked;
    pairing.diff = std::make_unique<MessageDiff>(*type, tolerances_.of_topic(name));
    pairing.a = std::make_unique<msgs::AnyMessage>(*type);
    pairing.b = std::make_unique<msgs::AnyMessage>(*type);
  }
  return {};
}

void RecordingDiff::run(OrderedMessages& a, OrderedMessages& b) {
  // Both go on by the time since their first message, so that few messages wait for the other recording's.
  const std::uint64_t first[] = {a.first(), b.first()};
  OrderedMessages* const recordings[] = {&a, &b};
  const OrderedMessages::Message* next[] = {a.next(), b.next()};
  while (next[0] != nullptr || next[1] != nullptr) {
    const bool is_b =
        next[0] == nullptr || (next[1] != nullptr && next[1]->log_time - first[1] < next[0]->log_time - first[0]);
    const std::size_t side = is_b ? 1 : 0;
    take(side, recordings[side]->topics()[next[side]->topic].name, *next[side]);
    next[side] = recordings[side]->next();
  }
  for (auto& [name, pairing] : topics_) {
    pairing.result.in_a = pairing.seen[0];
    pairing.result.in_b = pairing.seen[1];
    if (pairing.diff) pairing.result.fields = pairing.diff->fields();
  }
}

void RecordingDiff::take(std::size_t side, const std::string& topic, const OrderedMessages::Message& message) {
  const auto found = topics_.find(topic);
  if (found == topics_.end()) return;
  Pairing& pairing = found->second;
  if (++pairing.seen[side] > pairing.pairs) return;  // the other has none for it
  auto& others = pairing.waiting[1 - side];
  if (others.empty()) {
    pairing.waiting[side].push_back({message.log_time, Bytes(message.data.begin(), message.data.end())});
    return;
  }
  const Waiting other = std::move(others.front());
  others.pop_front();
  if (side == 1)
    compare(pairing, other.time, other.bytes, message.log_time, message.data);
  else
    compare(pairing, message.log_time, message.data, other.time, other.bytes);
}

void RecordingDiff::compare(Pairing& pairing, std::uint64_t time_a, ByteView a, std::uint64_t time_b, ByteView b) {
  TopicDiff& result = pairing.result;
  const std::uint64_t number = pairing.done++;
  const bool same_bytes = a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
  std::optional<ValueDifference> found;
  if (result.type_a != result.type_b) {
    found = {"", result.type_a, result.type_b};
  } else if (same_bytes) {
    if (pairing.diff) pairing.diff->skip();
  } else if (pairing.diff && pairing.diff->type().decode(a, pairing.a->get()) &&
             pairing.diff->type().decode(b, pairing.b->get())) {
    found = pairing.diff->compare(pairing.a->get(), pairing.b->get());
  } else {
    if (pairing.diff) pairing.diff->skip();
    if (result.remark.empty()) result.remark = "compared by bytes where a message's bytes are none of its type";
    found = byte_difference(a, b);
  }
  ++(found ? result.different : result.equal);
  if (found && !result.first) result.first = {number, time_a, time_b, std::move(*found)};
}

std::vector<TopicDiff> RecordingDiff::topics() const {
  std::vector<TopicDiff> all;
  for (const auto& [name, pairing] : topics_) all.push_back(pairing.result);
  return all;
}

}  // namespace nacelle::record
