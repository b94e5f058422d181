// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "answers/robot.hpp"
#include "desk/topic_tap.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::session {

/// Tracks which emergency stops are set, by any publisher. A container that resumes after a crash publishes them again.
///
/// A stop of a publisher that keeps no history (`ros2 topic pub` without more) is repeated latched, so that a base that is made or
/// activated later obeys it; the release ends that. The repetition has the time of the stop itself: a release that was said after
/// the stop counts, also if it was on its way when the stop was repeated, and if the clock of both is behind.
/// Threads: one, but for set() and release().
class EmergencyStops {
 public:
  explicit EmergencyStops(runtime::Container& container) : container_(container) {}

  void append_waits(std::vector<pollfd>& waits) const;
  /// Finds topics that have come since, and takes what was said. True: set() is another one now.
  bool look();
  /// The topics on which a stop is set, sorted. Threads: any.
  [[nodiscard]] std::vector<std::string> set() const { return *set_.lock(); }
  /// Releases the stops on these topics; for an empty list on every topic that a component reads. A release is latched.
  /// Errors: a topic of another kind; no component reads one. Threads: any.
  [[nodiscard]] Result<std::vector<answers::ReleasedStop>, Problem> release(const std::vector<std::string>& topics);

 private:
  struct Topic {
    void hear_latched(const Block& block);
    bool hear_passing(const Block& block);
    std::unique_ptr<desk::TopicTap> latched, passing;  // of publishers with a history, and of the others
    std::unique_ptr<Writer> again;                     // while what one of the others said holds
    MonotonicTime set_at{}, released_at{};             // the newest of each
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
