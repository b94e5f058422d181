// SPDX-License-Identifier: Apache-2.0
// How the filter goes back to the time of a late measurement.
#include <algorithm>
#include <utility>

#include "ekf/model/filter.hpp"

namespace nacelle::ekf {
namespace {

// At configure there is room for so many measurements of a part per second; more is made when they come.
constexpr double kExpectedHz = 100.0;

// A gap that is longer than a step is carried in pieces of one, as it is when nothing comes; of the longest one, in so many.
constexpr std::int64_t kMostPieces = 64;

// What processing a measurement costs, in instructions: a prediction, the update and the copies of both states. Source:
// test/benchmark/filter.
constexpr std::int64_t cost_of(const Measurement& measurement) {
  return 7'500 + std::int64_t{950} * measurement.reading.rows;
}

}  // namespace

void Filter::restore(const FilterState& state) {
  belief_ = state.belief;
  assists_ = state.assists;
  stamp_ = state.stamp;
  initialised_ = state.initialised;
}

void Filter::begin_history() {
  if (!options_.history) return;
  if (!history_) {
    const double expected = to_seconds(*options_.history) * kExpectedHz * static_cast<double>(options_.parts);
    history_.emplace(HistoryOptions{
        .length = *options_.history,
        .expected = static_cast<std::size_t>(std::clamp(expected, 0.0, static_cast<double>(options_.queue_limit))),
        .limit = options_.queue_limit});
  }
  history_->begin(state());
  jumped_ = corrected_ = false;
}

void Filter::begin_replays() {
  replay_budget_ = options_.replay_instructions + std::exchange(replay_surplus_, 0);
  // Before it is needed, and not in the middle of a pass.
  if (4 * history_->kept() > 3 * history_->places()) static_cast<void>(history_->make_place());
}

void Filter::take_in_order(const Measurement& measurement) {
  if (!history_->comes_last(measurement)) return insert_late(measurement);
  replay();  // so that this one is processed once
  --parts_[measurement.part].stats.waiting;
  make_room_in_history();
  if (history_->newest().stamp < stamp_) restore(history_->newest());
  jumped_ = false;
  process(measurement, Pass::First);
  if (std::exchange(jumped_, false)) {
    drop_pending(Rejection::BeforeHistory);
    begin_history();
    return;
  }
  history_->append(measurement, {command_, command_stamp_}, state());
  // A pass has to be faster than what comes.
  if (history_->pending()) replay_surplus_ += cost_of(measurement);
}

void Filter::insert_late(const Measurement& measurement) {
  PartStats& stats = parts_[measurement.part].stats;
  if (measurement.stamp < stamp_) stats.late_by = stamp_ - measurement.stamp;
  make_room_in_history();
  if (!history_->holds(measurement.stamp)) {
    --stats.waiting;
    ++stats.of(Rejection::BeforeHistory);
    return;
  }
  history_->insert(measurement);  // it waits until its pass comes to it
}

// Without a place and without a way to make one, the history becomes shorter than its length.
void Filter::make_room_in_history() {
  if (!history_->full() || history_->make_place()) return;
  if (history_->oldest_is_due()) {
    const FilterState live = state();
    restore(history_->before_oldest());
    replay_one(history_->oldest());
    history_->passed_oldest();
    restore(live);
  }
  history_->drop_oldest();
}

void Filter::replay_one(History::Entry& entry) {
  const Command live{command_, command_stamp_};
  command_ = entry.command.velocity;
  command_stamp_ = entry.command.stamp;
  if (entry.fresh) --parts_[entry.measurement.part].stats.waiting;
  process(entry.measurement, !entry.fresh ? Pass::Again : entry.late ? Pass::Late : Pass::First);
  entry.after = state();
  command_ = live.velocity;
  command_stamp_ = live.stamp;
  ++replays_.measurements;
}

void Filter::replay() {
  if (!history_->pending() || replay_budget_ <= 0) return;
  const FilterState live = state();
  bool ended = false;
  bool anew = true;
  while (history_->pending() && replay_budget_ > 0) {
    if (std::exchange(anew, false)) restore(history_->before_next());
    History::Entry& entry = history_->next();
    replay_budget_ -= cost_of(entry.measurement);
    replay_one(entry);
    if (!history_->passed_next()) continue;
    ended = anew = true;
    ++replays_.passes;
  }
  if (ended) {
    restore(history_->newest());
    corrected_ = true;
  } else {
    restore(live);
  }
}

void Filter::end_replays() {
  if (jumped_) {
    drop_pending(Rejection::BeforeHistory);
    begin_history();
  }
  const WallTime oldest = stamp_ - history_->length();
  if (history_->kept() == 0 && history_->newest().stamp < oldest) {
    // In a silence that is longer than the history, what was predicted before it is final.
    const FilterState live = state();
    restore(history_->newest());
    carry_in_pieces(oldest - stamp_, oldest);
    stamp_ = oldest;
    history_->begin(state());
    restore(live);
  }
  history_->trim(stamp_);
  replays_.continued += history_->pending() ? 1U : 0U;
}

void Filter::drop_pending(Rejection cause) {
  history_->for_each_fresh([this, cause](const Measurement& measurement) {
    PartStats& stats = parts_[measurement.part].stats;
    --stats.waiting;
    ++stats.of(cause);
  });
}

void Filter::carry_in_pieces(Duration gap, WallTime to) {
  const Duration longest = std::max(options_.period, options_.sensor_timeout);
  const auto carry_one = [this](Duration piece, WallTime end) {
    advance(assists_, belief_.mean, to_seconds(piece), options_.assists);
    carry(belief_, to_seconds(piece), end);
  };
  if (!history_ || gap <= longest || longest <= 0ns) return carry_one(gap, to);
  const std::int64_t pieces = std::min<std::int64_t>((gap - Duration{1}) / longest + 1, kMostPieces);
  for (std::int64_t left = pieces; left > 0; --left) {
    const Duration piece = gap / left;
    gap -= piece;
    carry_one(piece, to - gap);
  }
}

}  // namespace nacelle::ekf
