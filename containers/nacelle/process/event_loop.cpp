// SPDX-License-Identifier: Apache-2.0
#include "process/event_loop.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "process/attempt.hpp"

namespace nacelle::process {
namespace {

constexpr Duration kRetry = 100ms;
// poll() takes an int of milliseconds.
constexpr Duration kLongestWait = 1h;

}  // namespace

Task on_readable(std::string name, int descriptor, std::function<void()> serve) {
  return {.name = std::move(name),
          .watch =
              [descriptor](std::vector<pollfd>& waits) {
                waits.push_back({descriptor, POLLIN, 0});
              },
          .next_due = {},
          .serve = [serve = std::move(serve)](std::span<const pollfd>) { serve(); },
          .shed = {}};
}

void EventLoop::add(Task task) { entries_.emplace_back().task = std::move(task); }

std::optional<Problem> EventLoop::run() {
  while (!has_ended_) turn(std::nullopt);
  return why_;
}

void EventLoop::end(std::optional<Problem> why) {
  has_ended_ = true;
  if (!why_) why_ = std::move(why);
}

void EventLoop::end_with_a_lost_descriptor() {
  has_lost_a_descriptor_ = true;
  end(Problem{"container", "a component closed file descriptors of the container",
              "find the component that calls closefrom() or closes a descriptor twice; run it with "
              "`isolate: process`"});
}

void EventLoop::list(Entry& entry) {
  entry.first = waits_.size();
  entry.is_listed = !entry.task.watch || attempt(entry.task.name.c_str(), [&] { entry.task.watch(waits_); });
  if (!entry.is_listed)
    waits_.resize(entry.first);  // entries appended before the failure would wake the loop without being served
  entry.count = waits_.size() - entry.first;
  entry.due = entry.task.next_due ? entry.task.next_due() : std::nullopt;
}

int EventLoop::limit_ms(std::optional<Duration> limit) const {
  const auto shorten = [&](Duration to) { limit = std::clamp(to, Duration::zero(), limit.value_or(kLongestWait)); };
  for (const Entry& entry : entries_) {
    if (entry.has_failed || !entry.is_listed) shorten(kRetry);
    if (entry.due) shorten(*entry.due - clock_.now());
  }
  if (!limit) return -1;
  // Rounded up, so that a task that is due in half a millisecond is not checked twice.
  return *limit == Duration::zero() ? 0 : static_cast<int>(*limit / 1ms) + 1;
}

void EventLoop::wait(int limit_ms) {
  int ready = ::poll(waits_.data(), waits_.size(), limit_ms);
  if (ready < 0 && errno != EINTR) {
    // EINVAL: the limit of open files was lowered below the length of the list; or ENOMEM. What others opened must not end the loop.
    waits_.clear();
    for (Entry& entry : entries_) {
      if (entry.task.shed) {
        attempt(entry.task.name.c_str(), entry.task.shed);
        entry.first = entry.count = 0;
        entry.is_listed = false;  // its turn is the next one
      } else {
        list(entry);
      }
    }
    ready = ::poll(waits_.data(), waits_.size(), 0);
    if (ready < 0 && errno != EINTR)
      return end(Problem{"container", std::string{"poll failed: "} + std::strerror(errno), "raise `ulimit -n`"});
  }
  if (ready < 0) {
    for (pollfd& wait : waits_) wait.revents = 0;  // interrupted: poll() has written none of them
  }
  for (const Entry& entry : entries_) {
    if (!entry.task.shed &&
        std::ranges::any_of(part_of(entry), [](const pollfd& wait) { return (wait.revents & POLLNVAL) != 0; }))
      return end_with_a_lost_descriptor();
  }
}

void EventLoop::serve(Entry& entry) {
  if (!entry.is_listed) return;
  const bool is_ready = std::ranges::any_of(part_of(entry), [](const pollfd& wait) { return wait.revents != 0; });
  const bool is_due = entry.due && *entry.due <= clock_.now();
  if (!is_ready && !is_due && !entry.has_failed) return;
  entry.has_failed = !attempt(entry.task.name.c_str(), [&] { entry.task.serve(part_of(entry)); });
}

void EventLoop::turn(std::optional<Duration> limit) {
  waits_.clear();
  for (Entry& entry : entries_) list(entry);
  wait(limit_ms(limit));
  for (Entry& entry : entries_) {
    if (has_ended_) return;
    serve(entry);
  }
}

}  // namespace nacelle::process
