// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/budget.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "nacelle/base/names.hpp"
#include "nacelle/qos/text.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

namespace {

std::string why_copied(const WiringReport& wiring) {
  std::string why;
  if (!wiring.owner_nodes.empty()) why = join(wiring.owner_nodes) + " take(s) it as its own";
  if (wiring.other_processes.empty()) return why;
  return why + (why.empty() ? "" : " and ") + join(wiring.other_processes) + " live(s) in another process";
}

}  // namespace

std::string BudgetEvent::text() const {
  return fmt::format("{}: budget of {}: {} {}: {}", where.text(), topic, limit, broken ? "is broken" : "is kept again",
                     cause);
}

std::vector<Problem> BudgetWatch::check_wiring(const Container& container) const {
  std::vector<Problem> problems;
  for (const Entry& entry : entries_) {
    const StreamBudget& budget = entry.budget;
    if (!budget.max_copies) continue;
    const WiringReport wiring = container.wiring(budget.topic, Duration::max());
    if (wiring.copies <= *budget.max_copies) continue;
    problems.push_back(
        {budget.where,
         fmt::format("max_copies {} of {} cannot be kept: each message is copied {} time(s), since {}",
                     *budget.max_copies, budget.topic, wiring.copies, why_copied(wiring)),
         wiring.other_processes.empty()
             ? "let the callback take const T& or std::shared_ptr<const T>, or allow the copies"
             : "leave `isolate: process` out, let the callback take const T& or std::shared_ptr<const T>, or allow the "
               "copies"});
  }
  return problems;
}

std::vector<BudgetEvent> BudgetWatch::look(const Container& container, MonotonicTime now) {
  std::vector<BudgetEvent> events;
  container.report_streams(streams_);
  for (Entry& entry : entries_) {
    if (entry.budget.min_hz) {
      // Of two types on one name, the one that is published.
      const StreamReport* found = nullptr;
      for (const StreamReport& stream : streams_) {
        if (stream.name == entry.budget.topic && (found == nullptr || stream.published > found->published))
          found = &stream;
      }
      look_at_rate(entry, found, now, events);
    }
    if (entry.budget.max_age) look_at_age(entry, container, now, events);
  }
  return events;
}

void BudgetWatch::look_at_rate(Entry& entry, const StreamReport* stream, MonotonicTime now,
                               std::vector<BudgetEvent>& events) {
  const std::uint64_t published = stream == nullptr ? 0 : stream->published;
  const std::uint64_t unpublished = stream == nullptr ? 0 : stream->inactive_unpublished;
  const double min_hz = *entry.budget.min_hz;
  if (entry.rate_since) {
    const double seconds = to_seconds(now - *entry.rate_since);
    if (seconds < std::max(0.5, 2.0 / min_hz)) return;
    const auto messages = published - entry.published;
    // Tolerates one message at either end of the window.
    const bool slow = static_cast<double>(messages + 1) < min_hz * seconds;
    if (slow != std::exchange(entry.slow, slow)) {
      std::string cause = fmt::format("{} messages in {:.1f} s", messages, seconds);
      if (stream == nullptr || stream->writers == 0) {
        cause += ", no publisher is loaded";
      } else if (unpublished != entry.unpublished) {
        cause += ", its publisher is not active";
      }
      events.push_back({entry.budget.topic, fmt::format("min_hz {:g}", min_hz), slow, cause, entry.budget.where});
    }
  }
  entry.rate_since = now;
  entry.published = published;
  entry.unpublished = unpublished;
}

void BudgetWatch::look_at_age(Entry& entry, const Container& container, MonotonicTime now,
                              std::vector<BudgetEvent>& events) {
  const std::uint64_t late = container.wiring(entry.budget.topic, *entry.budget.max_age).late;
  if (entry.age_since) {
    const bool old = late > entry.late;
    if (old != std::exchange(entry.old, old)) {
      events.push_back({entry.budget.topic, "max_age " + to_text(*entry.budget.max_age), old,
                        fmt::format("{} messages were older when a callback began, in {:.1f} s", late - entry.late,
                                    to_seconds(now - *entry.age_since)),
                        entry.budget.where});
    }
  }
  entry.age_since = now;
  entry.late = late;
}

}  // namespace nacelle::runtime
