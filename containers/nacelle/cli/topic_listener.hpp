// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/whom.hpp"

namespace nacelle::cli {

/// The topics that a command reads, and how it prints them.
struct Listening {
  struct Topic {
    std::string name;
    std::string type;  ///< Selects one type of a topic with several; empty: the topic's.
  };
  Whom whom;
  std::vector<Topic> topics;
  std::string show = "yaml";  ///< The form of each message, as in the request "topic.listen".
  std::string field;          ///< Only this field of each message: "pose.pose.position"; empty: the whole message.
  std::size_t longest = 0;    ///< Longest list and text that YAML shows; 0: no limit.
  std::size_t least = 1;  ///< The number of messages needed before anything is shown; a topic with fewer is reported.
  std::function<void()> began = [] {};  ///< Called once, when every topic exists.
};

/// Passes each item with its topic's index to `take` until that returns false, a signal arrives or the container ends.
/// If a topic has fewer than `least` messages after 2 s, reports it once on stderr, with the reason if it is known.
/// Returns the exit code; errors have been printed.
/// Threads: one.
int listen(const Listening& wish, const std::function<bool(std::size_t, std::string_view)>& take);

}  // namespace nacelle::cli
