// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "whom.hpp"

namespace nacelle::cli {

/// What a command wants to hear.
struct Listening {
  struct Topic {
    std::string name;
    std::string type;  ///< Of a topic with several; empty: the topic's.
  };
  Whom whom;
  std::vector<Topic> topics;
  std::string show = "yaml";  ///< What comes of each message: the words of the request "topic.listen".
  std::string field;          ///< One part of each message only: "pose.pose.position"; empty: all of it.
  std::size_t longest = 0;    ///< Elements of a list and letters of a text, of which YAML shows no more; 0: all.
  std::size_t least =
      1;  ///< So many messages are needed for anything to be shown; a topic that brings fewer is told of.
  std::function<void()> began = [] {};  ///< Called once, when every topic is there.
};

/// Listens, and gives each item with its topic's index to `take` until that answers false, a signal comes or the container ends.
/// A topic that stays silent is told of on stderr, once, with the reason as far as it is known.
/// Returns: the exit code; what went wrong has been said.
/// Threads: one.
int listen(const Listening& wish, const std::function<bool(std::size_t, std::string_view)>& take);

}  // namespace nacelle::cli
