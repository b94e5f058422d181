// SPDX-License-Identifier: Apache-2.0
#include <ctime>
#include <deque>
#include <queue>

#include "topology/run.hpp"

namespace nacelle::bench {
namespace {

struct BareSource {
  std::unique_ptr<BareMessage> message;
  std::vector<ReaderState*> readers;
  Duration period{};
  std::uint64_t sent = 0;
};

struct Due {
  Duration at{};  // on the monotonic clock
  BareSource* source = nullptr;
};
struct Later {
  bool operator()(const Due& a, const Due& b) const { return b.at < a.at; }
};

void sleep_until(Duration t) {
  const auto ns = t.count();
  const timespec until{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) {}
}

}  // namespace

Run run_bare(const Graph& graph, Duration measured) {
  const SystemClock clock;
  Tally tally;
  std::deque<BareSource> sources;
  std::deque<ReaderState> readers;
  std::map<std::string, BareSource*> by_topic;
  std::priority_queue<Due, std::vector<Due>, Later> due;
  const Duration start = clock.now().since_origin;
  for (const auto& node : graph.nodes) {
    for (const auto& source : node.sources) {
      auto& made = sources.emplace_back();
      made.message = stream_type(source.type).make_bare(source);
      made.period = source.period;
      by_topic[source.topic] = &made;
      due.push({start + source.period, &made});
    }
  }
  for (const auto& node : graph.nodes) {
    for (const auto& sink : node.sinks) {
      const auto found = by_topic.find(sink.topic);
      if (found == by_topic.end()) continue;
      readers.push_back({&tally, &clock, found->second->period});
      found->second->readers.push_back(&readers.back());
    }
  }
  Run run;
  Tally::Look before;
  const Duration begin = start + 1s, end = begin + measured;
  bool measuring = false;
  for (Duration now = start; now < end;) {
    if (!measuring && now >= begin) {
      measuring = true;
      before = tally.look();
      run.used = Usage::now();
    }
    const auto [when, source] = due.top();
    if (when > now) {
      sleep_until(when);
      now = clock.now().since_origin;
      continue;
    }
    due.pop();
    due.push({when + source->period, source});
    source->message->fill();
    tally.published();
    const MonotonicTime stamp = clock.now();
    ++source->sent;
    for (ReaderState* reader : source->readers) reader->on_message(stamp, source->sent);
    now = stamp.since_origin;
  }
  run.used = Usage::now() - run.used;
  const Tally::Look after = tally.look();
  run.seen = {after.published - before.published, after.delivered - before.delivered, after.late - before.late,
              after.too_late - before.too_late, after.lost - before.lost};
  run.memory = Memory::now();
  return run;
}

}  // namespace nacelle::bench
