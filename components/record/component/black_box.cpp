// SPDX-License-Identifier: Apache-2.0
#include "record/component/black_box.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace nacelle::record {
namespace {

constexpr Duration kAftermath = 1s;
constexpr Duration kApart = 10s;  // a component that fails again and again does not fill the disk

}  // namespace

BlackBox::BlackBox(Options options, std::shared_ptr<const ContainerFacts> facts)
    : options_(std::move(options)), facts_(std::move(facts)), faults_seen_(facts_->faults) {}

SnapshotWish BlackBox::wish(const std::string& reason) const {
  return {.folder = options_.folder(),
          .reason = reason,
          .compression = options_.compression,
          .keep_free = options_.keep_free};
}

void BlackBox::note(const std::string& reason, const Result<Snapshot, Problem>& result) {
  {
    auto figures = figures_.lock();
    if (result) {
      ++figures->snapshots;
      figures->last = result->folder;
      figures->problem.reset();
    } else {
      figures->problem = result.error();
    }
  }
  options_.on_written(reason, result);
}

void BlackBox::on_stop(const std::string& topic) {
  if (event_.empty()) event_ = "emergency stop " + topic;
}

void BlackBox::look_for_faults() {
  const std::uint64_t faults = facts_->faults;
  if (std::exchange(faults_seen_, faults) != faults && event_.empty()) event_ = fmt::format("fault {}", faults);
}

void BlackBox::finish(Ring& ring) {
  look_for_faults();
  if (!event_.empty()) snapshot(ring, std::exchange(event_, {}), [](bool) {});
}

void BlackBox::look_at(Ring& ring, MonotonicTime now) {
  look_for_faults();
  if (event_.empty()) return;
  if (!due_) due_ = last_ ? std::max(now + kAftermath, *last_ + kApart) : now + kAftermath;
  if (now < *due_) return;
  snapshot(ring, std::exchange(event_, {}), [](bool) {});
  due_.reset();
  last_ = now;
}

void BlackBox::snapshot(Ring& ring, const std::string& reason, const std::function<void(bool)>& done) {
  thread_.write(wish(reason), ring.content(), [this, reason, done](const Result<Snapshot, Problem>& result) {
    note(reason, result);
    done(result.has_value());
  });
}

void BlackBox::recover(std::shared_ptr<RingFolder> left) {
  const std::string reason = "what a killed process left";
  SnapshotWish crashed = wish(reason);
  crashed.folder += "_crashed";
  thread_.write(std::move(crashed), std::move(left),
                [this, reason](const Result<Snapshot, Problem>& result) { note(reason, result); });
}

}  // namespace nacelle::record
