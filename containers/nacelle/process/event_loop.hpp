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

/// A unit of work of an EventLoop. A task without `watch` and `next_due` never runs.
struct Task {
  std::string name;  ///< Names the task when it fails.
  /// Appends the descriptors to poll. If it throws, the task is skipped for one turn.
  std::function<void(std::vector<pollfd>&)> watch;
  /// Returns when the task must run even if no descriptor is ready; nothing: never. Optional.
  std::function<std::optional<MonotonicTime>()> next_due;
  /// Runs when a descriptor is ready, when the task is due, and again after an exception. `waits`: the entries that
  /// `watch` appended, after poll().
  std::function<void(std::span<const pollfd> waits)> serve;
  /// Closes some of the task's client descriptors. Called when poll() rejects the list. For a task without it, a closed
  /// descriptor ends the loop.
  std::function<void()> shed;
};

/// Returns a task that waits for one descriptor, which must not change while the loop exists.
[[nodiscard]] Task on_readable(std::string name, int descriptor, std::function<void()> serve);

/// The event loop of a thread. Each part of the program adds its own tasks, and needs to know no descriptor of another
/// part.
///
/// An exception of a task is reported, and the task runs again after 100 ms. The other tasks and the loop continue.
/// Threads: one. Allocates: only when the list of descriptors grows.
class EventLoop {
 public:
  explicit EventLoop(const Clock& clock) : clock_(clock) {}
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  /// Tasks that are ready at the same time run in the order in which they were added.
  void add(Task task);
  /// Runs tasks until end() is called. Returns the argument of end().
  /// Errors: poll() fails and no task can close descriptors; other code closed a descriptor.
  [[nodiscard]] std::optional<Problem> run();
  /// Waits for at most `limit`, then runs every ready task once.
  void turn(std::optional<Duration> limit);
  /// Ends the loop after the current task. Called by tasks.
  void end(std::optional<Problem> why = std::nullopt);
  /// Ends the loop because other code closed a descriptor of a task; its number may now belong to another file. Called
  /// by tasks.
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
