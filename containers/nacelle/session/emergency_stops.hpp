// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/session/topic_tap.hpp"

namespace nacelle::session {

/// Which emergency stops are set, whoever set them: what a container that comes back after a crash has to say again.
///
/// A stop of a publisher that keeps no history (`ros2 topic pub` without more) is said again latched, so that a base that is made or
/// activated later obeys it; the release ends that. Threads: one.
class EmergencyStops {
 public:
  explicit EmergencyStops(runtime::Container& container) : container_(container) {}

  void append_waits(std::vector<pollfd>& waits) const;
  /// Finds topics that have come since, and takes what was said. True: set() is another one now.
  bool look();
  /// The topics on which a stop is set, sorted.
  [[nodiscard]] std::vector<std::string> set() const;

 private:
  struct Topic {
    void hear(const Block& block);
    std::unique_ptr<TopicTap> latched, passing;  // of publishers with a history, and of the others
    std::unique_ptr<Writer> again;               // while what one of the others said holds
    MonotonicTime said_at{};                     // of several writers the newest word counts, as for the base
    bool is_set = false;
  };
  void open(Topic& topic, const std::string& name, const msgs::MessageType& type);
  void say_again(Topic& topic, const std::string& name);
  runtime::Container& container_;
  std::map<std::string, Topic> topics_;
};

}  // namespace nacelle::session
