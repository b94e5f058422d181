// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle {

/// A text that says what a run was started with: a launch file, or the parameters of its nodes.
struct RunText {
  std::string name;        ///< "robot.launch.yaml"
  std::string media_type;  ///< "application/yaml"
  std::string text;
};

/// What programs outside of this container publish under a name, with a type.
struct RemoteTopic {
  std::string name;      ///< "/chatter"
  std::string type;      ///< "std_msgs/msg/String"
  std::string dds_type;  ///< "std_msgs::msg::dds_::String_"
  std::string hash;      ///< As announced; may be empty.
  std::vector<QoS> offered;
  std::vector<std::string> nodes;  ///< Full names of the publishers, as far as they are known.
};

/// What a component may know of its container beside its streams.
///
/// A process of an isolated component has its own: the name is that of the process's container, other processes' faults are not counted, and
/// there are no texts.
/// Threads: any.
class ContainerFacts {
 public:
  explicit ContainerFacts(std::string n = {}) : name(std::move(n)) {}

  const std::string name;                ///< In full: "/robot".
  std::atomic<std::uint64_t> faults{0};  ///< How many faults and open faults its components have had.

  /// Returns the files of the launch, and the nodes' parameters as they are now; nothing if the program offers no texts.
  [[nodiscard]] std::vector<RunText> run_texts() const {
    auto read = read_texts_.lock();
    return *read ? (*read)() : std::vector<RunText>{};
  }
  /// Returns what other programs on the network publish, if that is not what the caller has seen already (`version`, which is set; 0: nothing).
  [[nodiscard]] std::vector<RemoteTopic> remote_topics(std::uint64_t& version) const {
    auto read = read_remote_.lock();
    return *read ? (*read)(version) : std::vector<RemoteTopic>{};
  }
  /// For the program: as read_texts_by().
  void read_remote_by(std::function<std::vector<RemoteTopic>(std::uint64_t& version)> read) {
    *read_remote_.lock() = std::move(read);
  }
  /// For the program: run_texts() calls the function, on any thread, one at a time. An empty one waits until none is called.
  void read_texts_by(std::function<std::vector<RunText>()> read) { *read_texts_.lock() = std::move(read); }

 private:
  Guarded<std::function<std::vector<RunText>()>> read_texts_;
  Guarded<std::function<std::vector<RemoteTopic>(std::uint64_t&)>> read_remote_;
};

/// For Node::shared_object(): the facts of a container.
inline constexpr const char* kContainerFactsName = "nacelle.container_facts";
[[nodiscard]] std::shared_ptr<void> make_container_facts();

}  // namespace nacelle
