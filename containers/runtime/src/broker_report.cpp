// SPDX-License-Identifier: Apache-2.0
// The broker's reports about its streams: counters, and incompatible pairs.
#include <algorithm>

#include "broker_writer.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/runtime/broker.hpp"
#include "qos_clash.hpp"

namespace nacelle::runtime {
namespace {

// Not reported only for a node that reads both types, like a base that takes Twist and TwistStamped on one name.
bool reads_also(const Topic& topic, const EndpointSpec& reader) NACELLE_REQUIRES(topic.mutex_) {
  return std::ranges::any_of(topic.readers_, [&](const auto& other) { return other->spec().node == reader.node; });
}

// A remote reader whose QoS no publisher here satisfies gets nothing. The second subscription of a node
// (unless_offered) gets only what its first one does not.
bool counts_as_reader(const Topic& topic, const ReaderQueue& reader) NACELLE_REQUIRES(topic.mutex_) {
  if (is_tool(reader.spec())) return false;
  if (!reader.is_witness() && !reader.spec().unless_offered) return true;
  return std::ranges::any_of(topic.writers_, [&](const BrokerWriter* writer) { return writer->is_read_by(reader); });
}

// A node may request more in a second subscription (liveliness), and still receive publishers that do not offer it
// through its first.
bool hears(const Topic& topic, const std::string& node, const EndpointSpec& writer) NACELLE_REQUIRES(topic.mutex_) {
  return std::ranges::any_of(topic.readers_, [&](const auto& reader) {
    return reader->spec().node == node && matches(writer, reader->spec());
  });
}

}  // namespace

const char* words_of(HandedOver way) {
  switch (way) {
    case HandedOver::Never: return "";
    case HandedOver::Inline: return "inline";
    case HandedOver::AcrossThreads: return "across threads";
    case HandedOver::Both: return "both";
  }
  return "";
}

HandedOver handed_over(const Topic& topic) {
  auto ways = static_cast<unsigned>(topic.gone_.handed_over);
  for (const BrokerWriter* writer : topic.writers_) {
    for (const auto& reader : topic.readers_) {
      if (writer->thread() == 0 || reader->thread() == 0 || !matches(writer->spec(), reader->spec())) continue;
      ways |=
          static_cast<unsigned>(writer->thread() == reader->thread() ? HandedOver::Inline : HandedOver::AcrossThreads);
    }
  }
  return static_cast<HandedOver>(ways);
}

void add(ReaderCounters& to, const ReaderCounters& more) {
  to.received += more.received;
  to.delivered += more.delivered;
  to.overwritten += more.overwritten;
  to.full += more.full;
  to.inactive += more.inactive;
  to.expired += more.expired;
  to.discarded += more.discarded;
  to.rehomed += more.rehomed;
}

// Under the broker's lock. Topics of one name are adjacent in the map, and only two locks are ever held, in the map's
// order.
template <typename F>
void Broker::for_each_type_clash(F&& found) const {
  for (auto first = topics_.begin(); first != topics_.end(); ++first) {
    for (auto second = std::next(first); second != topics_.end() && second->first.first == first->first.first;
         ++second) {
      const LockGuard first_lock(first->second->mutex_);
      const LockGuard second_lock(second->second->mutex_);
      for (const auto& [from, to] : {std::pair{first->second.get(), second->second.get()},
                                     std::pair{second->second.get(), first->second.get()}}) {
        for (BrokerWriter* writer : from->writers_) {
          if (is_tool(writer->spec())) continue;
          for (const auto& reader : to->readers_) {
            if (!is_tool(reader->spec()) && !reads_also(*from, reader->spec())) found(*writer, *reader);
          }
        }
      }
    }
  }
}

void Broker::tell_type_clashes() {
  // Built anew, so that pairs that no longer exist are not kept.
  std::set<std::pair<std::uint64_t, std::uint64_t>> told;
  for_each_type_clash([&](BrokerWriter& writer, ReaderQueue& reader) NACELLE_REQUIRES(mutex_) {
    const std::pair pair{writer.id(), reader.id()};
    told.insert(pair);
    if (!told_types_.contains(pair)) introduce(writer, reader);
  });
  told_types_ = std::move(told);
}

std::vector<ClashReport> Broker::clashes() const {
  std::vector<ClashReport> found;
  const LockGuard lock(mutex_);
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    for (const auto& reader : topic->readers_) {
      if (is_tool(reader->spec())) continue;
      const auto serving = static_cast<std::size_t>(std::ranges::count_if(
          topic->writers_, [&](const BrokerWriter* w) { return matches(w->spec(), reader->spec()); }));
      for (const BrokerWriter* writer : topic->writers_) {
        if (is_tool(writer->spec()) || hears(*topic, reader->spec().node, writer->spec())) continue;
        for (auto& clash : clashes_between(writer->spec(), reader->spec())) {
          clash.other_writers = serving;
          found.push_back(std::move(clash));
        }
      }
    }
  }
  for_each_type_clash([&](const BrokerWriter& writer, const ReaderQueue& reader) {
    for (auto& clash : clashes_between(writer.spec(), reader.spec())) found.push_back(std::move(clash));
  });
  return found;
}

WiringReport Broker::wiring(const std::string& name, Duration age) const {
  WiringReport report;
  report.topic = name;
  const LockGuard lock(mutex_);
  for (const auto& [key, topic] : topics_) {
    if (key.first != name) continue;
    const LockGuard topic_lock(topic->mutex_);
    for (const BrokerWriter* writer : topic->writers_) {
      if (is_tool(writer->spec())) continue;
      report.writer_nodes.push_back(writer->spec().node);
      std::size_t owners = 0, sharers = 0, links = 0;  // a message is copied on its way to or from another process
      if (writer->spec().via != 0) ++links;
      for (const auto& reader : topic->readers_) {
        // Remote readers are not part of the robot's wiring, and may come and go.
        if (reader->is_tap() || reader->is_witness() || !matches(writer->spec(), reader->spec())) continue;
        ++(reader->taking() == Taking::Own ? owners : sharers);
        if (reader->spec().via != 0) {
          ++links;
          report.other_processes.push_back(reader->spec().node);
        }
      }
      // As in BrokerWriter::distribute(): the last owner gets the original if no other reader shares it.
      const bool shared = sharers != 0 || writer->spec().qos.resolved().durability() == Durability::TransientLocal;
      const std::size_t copied = shared || owners == 0 ? owners : owners - 1;
      report.copies = std::max<std::uint64_t>(report.copies, copied + links);
      if (writer->spec().via != 0) report.other_processes.push_back(writer->spec().node);
    }
    if (topic->gone_.latency) report.late += topic->gone_.latency->count_above(age);
    for (const auto& reader : topic->readers_) {
      if (is_tool(reader->spec())) continue;
      if (reader->taking() == Taking::Own) report.owner_nodes.push_back(reader->spec().node);
      report.late += reader->latency().count_above(age);
    }
  }
  return report;
}

std::vector<EndpointReport> Broker::endpoints() const {
  std::vector<EndpointReport> all;
  const auto add = [&](const EndpointSpec& spec, bool is_writer, std::uint64_t id) {
    if (is_tool(spec)) return;
    all.push_back({spec.topic, spec.type->name, spec.type->hash, spec.node, is_writer, spec.via != 0, id,
                   spec.qos.resolved(), spec.command_timeout});
  };
  const LockGuard lock(mutex_);
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    for (const BrokerWriter* writer : topic->writers_) add(writer->spec(), true, writer->id());
    for (const auto& reader : topic->readers_) add(reader->spec(), false, reader->id());
  }
  return all;
}

std::vector<std::string> Broker::topics_of(const std::string& node) const {
  std::vector<std::string> names;
  const LockGuard lock(mutex_);
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    if (std::ranges::any_of(topic->writers_, [&](const BrokerWriter* writer) { return writer->spec().node == node; }))
      names.push_back(key.first);
  }
  return names;
}

std::vector<const msgs::MessageType*> Broker::types_of(const std::string& node) const {
  std::vector<const msgs::MessageType*> types;
  const LockGuard lock(mutex_);
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    if (std::ranges::any_of(topic->writers_, [&](const BrokerWriter* writer) { return writer->spec().node == node; }) ||
        std::ranges::any_of(topic->readers_, [&](const auto& reader) { return reader->spec().node == node; }))
      types.push_back(key.second);
  }
  return types;
}

void Broker::report(std::vector<StreamReport>& out) const {
  const LockGuard lock(mutex_);
  std::size_t used = 0;
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    Topic::Totals sum;
    sum.written = topic->gone_.written;
    sum.read = topic->gone_.read;
    sum.first_ns = topic->gone_.first_ns;
    sum.last_ns = topic->gone_.last_ns;
    DurationHistogram latency;
    if (topic->gone_.latency) latency.merge(*topic->gone_.latency);
    std::uint64_t deadline_missed = 0;
    for (const BrokerWriter* writer : topic->writers_) {
      writer->fold_into(sum);
      deadline_missed += writer->deadline_missed();
    }
    std::size_t readers = 0;
    for (const auto& reader : topic->readers_) {
      if (is_tool(reader->spec())) continue;
      if (counts_as_reader(*topic, *reader)) ++readers;
      add(sum.read, reader->counters());
      latency.merge(reader->latency());
    }
    if (used == out.size()) out.emplace_back();
    StreamReport& row = out[used++];
    row.name = key.first;
    row.type = key.second->name;
    row.published = sum.written.published;
    row.delivered = sum.read.delivered;
    row.writers = topic->writers_.size();
    row.readers = readers;
    row.first = {Duration{static_cast<std::int64_t>(sum.first_ns)}};
    row.last = {Duration{static_cast<std::int64_t>(sum.last_ns)}};
    row.overwritten = sum.read.overwritten;
    row.full = sum.read.full;
    row.inactive = sum.read.inactive;
    row.expired = sum.read.expired;
    row.discarded = sum.read.discarded;
    row.rehomed = sum.read.rehomed;
    row.would_block = sum.written.would_block;
    row.inactive_unpublished = sum.written.inactive;
    row.pool_dry = sum.written.pool_dry;
    row.pool_grown = sum.written.pool_grown;
    row.copies = sum.written.copies;
    row.bytes_copied = sum.written.bytes_copied;
    row.deadline_missed = deadline_missed;
    row.latency_p50 = latency.quantile(0.5);
    row.latency_p99 = latency.quantile(0.99);
    row.latency_max = latency.max();
    row.handed_over = handed_over(*topic);
  }
  out.resize(used);
}

void Broker::report(std::vector<ReaderReport>& out) const {
  const LockGuard lock(mutex_);
  std::size_t used = 0;
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    for (const auto& reader : topic->readers_) {
      if (is_tool(reader->spec())) continue;
      if (used == out.size()) out.emplace_back();
      reader->report(out[used++]);
    }
  }
  out.resize(used);
}

}  // namespace nacelle::runtime
