// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle {

/// What programs outside of this container publish under a name, with a type.
struct RemoteTopic {
  std::string name;      ///< "/chatter"
  std::string type;      ///< "std_msgs/msg/String"
  std::string dds_type;  ///< "std_msgs::msg::dds_::String_"
  std::string hash;      ///< As announced; may be empty.
  std::vector<QoS> offered;
  std::vector<std::string> nodes;  ///< Full names of the publishers, as far as they are known.
};

/// What a component may know of the network that its container is on.
///
/// A process of an isolated component has its own, which knows nothing.
/// Threads: any.
class NetworkFacts {
 public:
  /// Returns what other programs publish, if that is not what the caller has seen already (`version`, which is set; 0: nothing).
  [[nodiscard]] std::vector<RemoteTopic> remote_topics(std::uint64_t& version) const {
    auto read = read_remote_.lock();
    return *read ? (*read)(version) : std::vector<RemoteTopic>{};
  }
  /// For the program: remote_topics() calls the function, on any thread, one at a time. An empty one waits until none is called.
  void read_remote_by(std::function<std::vector<RemoteTopic>(std::uint64_t& version)> read) {
    *read_remote_.lock() = std::move(read);
  }

 private:
  Guarded<std::function<std::vector<RemoteTopic>(std::uint64_t&)>> read_remote_;
};

/// For Node::shared_object(): what a container knows of its network.
inline constexpr const char* kNetworkFactsName = "nacelle.network_facts";
[[nodiscard]] std::shared_ptr<void> make_network_facts();

}  // namespace nacelle
