// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::process {

/// What a loop waits for, and what it does then. A task that has neither `watch` nor `next_due` is never served.
struct Task {
  std::string name;  ///< What a failure of it is reported as.
  /// Appends what is to be polled. If there is no memory for that, it throws and leaves the list as it was.
  std::function<void(std::vector<pollfd>&)> watch;
  /// When it has something to do though nothing happens; empty, or nothing: never.
  std::function<std::optional<MonotonicTime>()> next_due;
  /// Called when a descriptor is ready, when it is due, and again if it threw. `waits`: what `watch` appended, after poll().
  std::function<void(std::span<const pollfd> waits)> serve;
  /// Of a task whose descriptors belong to others: called when poll() refuses the whole list, to give some of them up. One of them that
  /// is closed is the task's affair.
  std::function<void()> shed;
};

/// A task that waits for one descriptor, which is the same as long as the loop lives.
[[nodiscard]] Task on_readable(std::string name, int descriptor, std::function<void()> serve);

/// What a thread waits for and does: each room adds its tasks, and none knows another one's descriptors.
///
/// A task that throws is reported and served again 100 ms later; the others and the loop go on.
/// Threads: one. Allocates: nothing once each task has had its longest list.
class EventLoop {
 public:
  explicit EventLoop(const Clock& clock) : clock_(clock) {}
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  /// Tasks that are ready together are served in the order in which they were added.
  void add(Task task);
  /// Serves until end() is called. Returns what it was called with.
  /// Errors: poll() fails on descriptors that no task can give up; a descriptor was closed by other code.
  [[nodiscard]] std::optional<Problem> run();
  /// Waits no longer than `limit` and serves once what is ready then.
  void turn(std::optional<Duration> limit);
  /// The loop ends after the task that is being served. For tasks.
  void end(std::optional<Problem> why = std::nullopt);
  /// A descriptor that a task needs was closed by other code, and its number may be another file's. For tasks.
  void end_with_a_lost_descriptor();
  [[nodiscard]] bool has_lost_a_descriptor() const { return has_lost_a_descriptor_; }

 private:
  struct Entry {
    Task task;
    std::size_t first = 0, count = 0;  // its part of waits_
    std::optional<MonotonicTime> due;
    bool is_listed = false, has_failed = false;
  };

  void list(Entry& entry);
  [[nodiscard]] int limit_ms(std::optional<Duration> limit) const;
  void wait(int limit_ms);
  [[nodiscard]] std::span<const pollfd> part_of(const Entry& entry) const {
    return {waits_.data() + entry.first, entry.is_listed ? entry.count : 0};
  }
  void serve(Entry& entry);

  const Clock& clock_;
  std::vector<Entry> entries_;
  std::vector<pollfd> waits_;
  bool has_ended_ = false, has_lost_a_descriptor_ = false;
  std::optional<Problem> why_;
};

}  // namespace nacelle::process
