// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/late_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nacelle::ekf {
namespace {

constexpr int kLateLooks = 5;  // checks in a row with late measurements before a report

double megabytes(std::size_t entries) { return static_cast<double>(entries * sizeof(History::Entry)) * 1e-6; }

// Half as much again, in tenths of a second.
double suggested_s(Duration most_late) { return std::ceil(15.0 * to_seconds(most_late)) / 10.0; }

}  // namespace

std::string in_words(const History& history) {
  return fmt::format(
      "late measurements go back up to {:g} s: room for {} measurements ({:.1f} MB), at most for {} ({:.1f} MB)",
      to_seconds(history.length()), history.places(), megabytes(history.places()), history.limit(),
      megabytes(history.limit()));
}

LateWatch::LateWatch(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter) {
  for (const auto& input : inputs) {
    for (const auto& part : input->parts()) seen_.push_back({.stats = filter.stats(part.number)});
  }
}

void LateWatch::look(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter, const Logger& logger) {
  const History* const history = filter.history();
  std::size_t at = 0;
  for (const auto& input : inputs) {
    for (const auto& part : input->parts()) {
      Seen& seen = seen_[at++];
      const PartStats& now = filter.stats(part.number);
      if (history != nullptr) {
        look_at_too_old(part, now, seen, *history, logger);
      } else {
        look_at_late(part, now, seen, filter.period(), logger);
      }
      seen.stats = now;
    }
  }
  if (history == nullptr || history->cut_short() == 0 || told_short_) return;
  told_short_ = true;
  logger.warn(
      "the history holds {} measurements, which are {:.2f} s, instead of history_length ({:g} s): raise "
      "measurement_queue_limit",
      history->kept(), to_seconds(history->reach()), to_seconds(history->length()));
}

// If none of it is fused, Watch has reported it.
void LateWatch::look_at_too_old(const Input::Part& part, const PartStats& now, Seen& seen, const History& history,
                                const Logger& logger) const {
  const std::uint64_t old = now.of(Rejection::BeforeHistory) - seen.stats.of(Rejection::BeforeHistory);
  if (old == 0 || seen.told_old || now.fused == seen.stats.fused) return;
  seen.told_old = true;
  logger.warn(
      "{}: {} of its last {} measurements were older than the history ({:g} s), the last late one by {:.3f} s; they "
      "are not "
      "fused: raise history_length",
      part.name, old, now.received - seen.stats.received, to_seconds(history.length()), to_seconds(now.late_by));
}

void LateWatch::look_at_late(const Input::Part& part, const PartStats& now, Seen& seen, Duration period,
                             const Logger& logger) const {
  const std::uint64_t late = now.late - seen.stats.late;
  const std::uint64_t fused = now.fused - seen.stats.fused;
  if (fused == 0) return;
  const bool often = 2 * late > fused && now.late_by > period;
  seen.late_looks = often ? seen.late_looks + 1 : 0;
  seen.most_late = often ? std::max(seen.most_late, now.late_by) : Duration{};
  if (seen.late_looks < kLateLooks || seen.told_late) return;
  seen.told_late = true;
  logger.warn(
      "{}: its measurements come {:.3f} s after newer ones and correct a state that they do not belong to; "
      "smooth_lagged_data: "
      "true with history_length: {:.1f} puts them into their place",
      part.name, to_seconds(seen.most_late), suggested_s(seen.most_late));
}

void write_history_diagnostics(const Filter& filter, const std::string& node,
                               diagnostic_msgs::msg::DiagnosticArray& out) {
  using diagnostic_msgs::msg::DiagnosticStatus;
  const History* const history = filter.history();
  if (history == nullptr) return;
  DiagnosticStatus& status = out.status.emplace_back();
  status.level = history->cut_short() > 0 ? DiagnosticStatus::WARN : DiagnosticStatus::OK;
  status.name = fmt::format("{}: history", node);
  status.message = fmt::format("{} measurements, {:.2f} s", history->kept(), to_seconds(history->reach()));
  status.hardware_id = "none";
  const auto add = [&status](std::string_view key, std::uint64_t value) {
    auto& pair = status.values.emplace_back();
    pair.key = key;
    pair.value = fmt::format("{}", value);
  };
  add("kept", history->kept());
  add("places", history->places());
  add("cut_short", history->cut_short());
  add("replays", filter.replays().passes);
  add("replayed", filter.replays().measurements);
  add("continued", filter.replays().continued);
}

}  // namespace nacelle::ekf
