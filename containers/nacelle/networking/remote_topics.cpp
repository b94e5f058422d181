// SPDX-License-Identifier: Apache-2.0
#include "networking/remote_topics.hpp"

#include <algorithm>
#include <string>

#include "transport_dds/wire/names.hpp"
#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::networking {

std::vector<RemoteTopic> remote_topics_of(const transport_dds::RemoteGraph& graph) {
  std::vector<RemoteTopic> all;
  for (const auto& [name, types] : graph.topics()) {
    const std::size_t first = all.size();
    for (const auto& end : graph.ends_of_topic(name)) {
      if (!end.is_writer) continue;
      const auto same = [&](const RemoteTopic& one) {
        return one.type == end.type && one.hash == end.user_data.type_hash;
      };
      auto topic = std::find_if(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(), same);
      if (topic == all.end()) {
        auto dds_type = transport_dds::dds_type_name(end.type);
        if (!dds_type) continue;  // no type of ROS 2
        topic = all.insert(all.end(), {name, end.type, std::move(*dds_type), end.user_data.type_hash, {}, {}});
      }
      topic->offered.push_back(end.qos);
      if (end.node_name == transport_dds::kUnknownNodeName) continue;
      topic->nodes.push_back((end.node_namespace == "/" ? "" : end.node_namespace) + "/" + end.node_name);
    }
  }
  return all;
}

}  // namespace nacelle::networking
