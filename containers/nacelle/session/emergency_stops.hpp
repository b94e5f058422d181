// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "answers/robot.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/runtime/container.hpp"
#include "requests/topic_tap.hpp"

namespace nacelle::session {

/// Tracks which emergency stops are set, by any publisher. A container that resumes after a crash publishes them again.
///
/// A stop of a publisher without history (`ros2 topic pub` without options) is republished latched until its release,
/// so that a base that is loaded or activated later also stops. The republished stop has the time of the original, or
/// the time just after the last release if that is later. A release that is published after the stop therefore takes
/// effect, even if it was in transit when the stop was republished, and even if its publisher's clock is behind.
/// Threads: one, except set() and release().
class EmergencyStops {
 public:
  explicit EmergencyStops(runtime::Container& container) : container_(container) {}

  void append_waits(std::vector<pollfd>& waits) const;
  /// Finds new topics and reads their messages. Returns true if set() has changed.
  bool look();
  /// Returns the topics on which a stop is set, sorted. Threads: any.
  [[nodiscard]] std::vector<std::string> set() const { return *set_.lock(); }
  /// Releases the stops on these topics, even without a reader; for an empty list, on every emergency stop topic that a
  /// component reads. A release is latched.
  /// Errors: a topic that is not an emergency stop; an empty list, and no component reads one; no memory. Threads: any.
  [[nodiscard]] Result<std::vector<answers::ReleasedStop>, Problem> release(const std::vector<std::string>& topics);

 private:
  struct Topic {
    void hear_latched(const Block& block);
    bool hear_passing(const Block& block);
    std::unique_ptr<requests::TopicTap> latched, passing;  // for publishers with a history, and for the others
    std::unique_ptr<Writer> again;                         // republishes a stop of the others
    MonotonicTime set_at{}, released_at{};                 // the newest of each
    bool is_set = false;
  };
  void open(Topic& topic, const std::string& name, const msgs::MessageType& type);
  void repeat_stop(Topic& topic, const std::string& name);
  runtime::Container& container_;
  std::map<std::string, Topic> topics_;
  Guarded<std::vector<std::string>> set_;
  Guarded<std::map<std::string, std::unique_ptr<Writer>>> releases_;
};

}  // namespace nacelle::session
