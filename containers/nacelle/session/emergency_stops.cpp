// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/emergency_stops.hpp"

#include <std_msgs/msg/bool.hpp>
#include <system_error>
#include <utility>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/session/robot_service.hpp"

namespace nacelle::session {

void EmergencyStops::append_waits(std::vector<pollfd>& waits) const {
  for (const auto& [name, topic] : topics_) waits.push_back({topic.tap->descriptor(), POLLIN, 0});
}

bool EmergencyStops::look() {
  std::vector<runtime::StreamReport> streams;
  container_.report_streams(streams);
  for (const auto& stream : streams) {
    if (!is_emergency_stop(stream.name, stream.type) || topics_.count(stream.name) != 0) continue;
    const msgs::MessageType* const type = container_.topic_type(stream.name);
    if (type == nullptr || type->name != kEmergencyStopType) continue;
    try {
      auto tap = std::make_unique<TopicTap>(container_.transport(), stream.name, *type, 100);
      topics_[stream.name].tap = std::move(tap);
    } catch (const std::system_error&) {
      continue;  // out of descriptors; the stop is latched, so that the next look finds it
    }
  }
  bool changed = false;
  for (auto& [name, topic] : topics_) {
    const bool before = topic.is_set;
    while (Block* const block = topic.tap->take()) {
      if (block->info.source_time >= topic.said_at) {
        topic.said_at = block->info.source_time;
        topic.is_set = static_cast<const std_msgs::msg::Bool*>(block->message)->data;
      }
      drop_reference(*block);
    }
    changed = changed || topic.is_set != before;
  }
  return changed;
}

std::vector<std::string> EmergencyStops::set() const {
  std::vector<std::string> names;
  for (const auto& [name, topic] : topics_) {
    if (topic.is_set) names.push_back(name);
  }
  return names;
}

}  // namespace nacelle::session
