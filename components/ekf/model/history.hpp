// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "ekf/model/assists.hpp"
#include "ekf/model/control.hpp"
#include "ekf/model/measurement_queue.hpp"
#include "ekf/model/state.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

/// What going back in time restores: everything that a measurement changes in the filter, but for its counters. Whoever gives
/// the filter another state of that kind adds it here (Filter::state() and Filter::restore()).
struct FilterState {
  Belief belief;
  AssistState assists;
  WallTime stamp{};
  bool initialised{false};
};

/// The command that was in force. Source: robot_localization keeps one with every measurement, too.
struct Command {
  std::array<double, ControlOptions::kAxes> velocity{};
  WallTime stamp{};
};

struct HistoryOptions {
  Duration length{};          ///< How far behind the filter a late measurement may be.
  std::size_t expected{256};  ///< So many measurements have a place at once.
  std::size_t limit{4096};    ///< The most that are kept, however high the rates are.
};

/// The last measurements in the order of their stamps, each with the filter's state behind it; those of one stamp in the order of
/// their parts, then of their arrival. So the state is the same in whatever order they came.
///
/// A pass goes through all behind the oldest new one and writes their states anew. It may be done in slices: next() is the one whose turn
/// it is. A measurement that comes behind the pass waits for the next pass, so that every pass ends.
/// Threads: one. Allocates: in the constructor, and when more measurements are kept than ever before (4.2 kB each).
class History {
 public:
  struct Entry {
    FilterState after;
    Measurement measurement;
    Command command;
    bool fresh{false};  ///< Not processed yet.
    bool late{false};
  };

  explicit History(const HistoryOptions& options);

  /// Forgets all; the filter is in this state.
  void begin(const FilterState& base);

  /// Whether a measurement of this stamp has a place in it.
  [[nodiscard]] bool holds(WallTime stamp) const { return stamp >= cutoff_ && stamp >= base().stamp; }
  /// Whether it is to be processed after everything in the history.
  [[nodiscard]] bool comes_last(const Measurement& measurement) const;
  /// The state behind the newest measurement.
  [[nodiscard]] const FilterState& newest() const { return at(size() - 1).after; }

  /// Keeps a measurement that was processed. comes_last() must be true, full() false.
  void append(const Measurement& measurement, const Command& command, const FilterState& after);
  /// Puts a measurement that was not processed into its place, and orders a pass from there. comes_last() must be false, holds()
  /// true, full() false.
  void insert(const Measurement& measurement);

  /// Entries are due for a pass.
  [[nodiscard]] bool pending() const { return next_ < size(); }
  /// The one to process now, and the state before it.
  [[nodiscard]] Entry& next() { return at(next_); }
  [[nodiscard]] const FilterState& before_next() const { return at(next_ - 1).after; }
  /// That one's state is written. Returns true if that ended a pass: newest() is valid for all that the pass began with.
  [[nodiscard]] bool passed_next();

  /// Makes the state at the end of the oldest measurements the base, as far as they are older than the filter's stamp by more than the
  /// length and no pass needs them.
  void trim(WallTime stamp);
  /// No place is left; make_place() or drop_oldest() makes one.
  [[nodiscard]] bool full() const { return free_.empty(); }
  /// Returns false if the limit is reached.
  [[nodiscard]] bool make_place();
  /// The oldest measurement waits for its pass: its state has to be written before drop_oldest().
  [[nodiscard]] bool oldest_is_due() const { return next_ == 1 || again_ == 1; }
  [[nodiscard]] Entry& oldest() { return at(1); }
  [[nodiscard]] const FilterState& before_oldest() const { return base(); }
  void passed_oldest();
  /// Makes the state after the oldest measurement the base. Counts it as cut short.
  void drop_oldest();

  /// Calls `f(Measurement)` for those that were not processed yet.
  template <typename F>
  void for_each_fresh(F&& f) const {
    for (std::size_t i = 1; i < size(); ++i) {
      if (at(i).fresh) f(at(i).measurement);
    }
  }

  /// Measurements that are kept.
  [[nodiscard]] std::size_t kept() const { return size() - 1; }
  [[nodiscard]] std::size_t places() const { return places_; }
  [[nodiscard]] Duration length() const { return options_.length; }
  [[nodiscard]] std::size_t limit() const { return options_.limit; }
  /// How often a measurement was forgotten before its time, because the limit was reached.
  [[nodiscard]] std::uint64_t cut_short() const { return cut_short_; }
  /// How far back the history reaches now.
  [[nodiscard]] Duration reach() const { return kept() == 0 ? Duration{} : newest().stamp - at(1).measurement.stamp; }

 private:
  static constexpr std::size_t kChunk = 64;
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t size() const { return order_.size(); }
  [[nodiscard]] const FilterState& base() const { return at(0).after; }
  [[nodiscard]] const Entry& at(std::size_t i) const { return chunks_[order_[i] / kChunk][order_[i] % kChunk]; }
  [[nodiscard]] Entry& at(std::size_t i) { return chunks_[order_[i] / kChunk][order_[i] % kChunk]; }
  [[nodiscard]] std::size_t place_of(const Measurement& measurement) const;
  [[nodiscard]] Entry& take_place(std::size_t i);
  void make_places(std::size_t count);
  void forget_oldest(std::size_t count);

  HistoryOptions options_;
  std::vector<std::unique_ptr<Entry[]>> chunks_;  // places stay where they are when there are more
  std::vector<std::uint32_t> free_;
  std::vector<std::uint32_t> order_;  // the first is the base: of it only the state counts
  std::size_t places_{0};
  std::size_t next_{kNone};   // of the running pass
  std::size_t again_{kNone};  // the first that came behind it
  WallTime cutoff_{};
  std::uint64_t cut_short_{0};
};

}  // namespace nacelle::ekf
