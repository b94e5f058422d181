// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::replay {

/// A component of the launch file, as its constructor declared it.
struct Candidate {
  std::string node;                        ///< Full name.
  std::set<std::string> reads, publishes;  ///< Full names of topics.
  std::string driver;        ///< Why it is a driver: "it opens /dev/ttyUSB0 (port_name)"; empty: it is none.
  std::string failure;       ///< Why it could not be constructed; empty: it was.
  bool uses_frames = false;  ///< It looks transforms up.
};

/// Whether a component runs in a replay.
struct Role {
  std::string node;
  std::string left_out;  ///< Why it does not run; empty: it runs.
  [[nodiscard]] bool runs() const { return left_out.empty(); }
  friend bool operator==(const Role&, const Role&) = default;
};

/// Chooses the components of a replay: those named, or else all that are no drivers and read a topic that is recorded or that another chosen one
/// publishes. Names are full ones, or those without namespaces. The roles are in the candidates' order. Pure.
/// Errors: a name that no candidate has, or that is a driver's: a replay opens no device.
[[nodiscard]] Result<std::vector<Role>, Problem> cast(const std::vector<Candidate>& candidates,
                                                      const std::set<std::string>& recorded,
                                                      const std::vector<std::string>& named);

/// A topic that a running component reads, and that neither the recording has nor a running component publishes.
struct MissingTopic {
  std::string topic;
  std::vector<std::string> readers;
  std::string publisher;  ///< A component that is left out and publishes it; empty: none of the launch file does.
  friend bool operator==(const MissingTopic&, const MissingTopic&) = default;
};
/// Returns them by name. Pure.
[[nodiscard]] std::vector<MissingTopic> missing_topics(const std::vector<Candidate>& candidates,
                                                       const std::vector<Role>& roles,
                                                       const std::set<std::string>& recorded);

/// Returns the running components that look transforms up although none that runs reads /tf_static: nothing keeps transforms for them. Pure.
[[nodiscard]] std::vector<std::string> without_transforms(const std::vector<Candidate>& candidates,
                                                          const std::vector<Role>& roles);

}  // namespace nacelle::replay
