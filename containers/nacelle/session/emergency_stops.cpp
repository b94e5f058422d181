// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/emergency_stops.hpp"

#include <std_msgs/msg/bool.hpp>
#include <system_error>
#include <utility>

#include "nacelle/base/names.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/session/robot_service.hpp"

namespace nacelle::session {
namespace {

QoS latched_qos() { return QoS(KeepAll{}).reliable().transient_local(); }

}  // namespace

void EmergencyStops::append_waits(std::vector<pollfd>& waits) const {
  for (const auto& [name, topic] : topics_) {
    waits.push_back({topic.latched->descriptor(), POLLIN, 0});
    waits.push_back({topic.passing->descriptor(), POLLIN, 0});
  }
}

void EmergencyStops::open(Topic& topic, const std::string& name, const msgs::MessageType& type) {
  // Not KEEP_ALL: the publisher of a stop must not wait for this reader.
  EndpointSpec spec{name, &type, QoS(100).reliable().transient_local(), ""};
  topic.latched = std::make_unique<TopicTap>(container_.transport(), spec);
  spec.qos = QoS(100).best_effort();
  spec.unless_offered = latched_qos();
  topic.passing = std::make_unique<TopicTap>(container_.transport(), spec);
}

void EmergencyStops::Topic::hear(const Block& block) {
  if (block.info.source_time < said_at) return;
  said_at = block.info.source_time;
  is_set = static_cast<const std_msgs::msg::Bool*>(block.message)->data;
}

void EmergencyStops::say_again(Topic& topic, const std::string& name) {
  const EndpointSpec spec{name, &topic.latched->type(), latched_qos(),
                          fully_qualified_node_name(container_.options().name_space, "_emergency_stops")};
  topic.again = container_.transport().create_writer(spec);
  Block* const block = topic.again->borrow();
  if (block == nullptr) return;
  static_cast<std_msgs::msg::Bool*>(block->message)->data = true;
  static_cast<void>(topic.again->publish(*block));
}

bool EmergencyStops::look() {
  std::vector<runtime::StreamReport> streams;
  container_.report_streams(streams);
  for (const auto& stream : streams) {
    if (!is_emergency_stop(stream.name, stream.type) || topics_.count(stream.name) != 0) continue;
    const msgs::MessageType* const type = container_.topic_type(stream.name);
    if (type == nullptr || type->name != kEmergencyStopType) continue;
    try {
      Topic topic;
      open(topic, stream.name, *type);
      topics_.emplace(stream.name, std::move(topic));
    } catch (const std::system_error&) {
      continue;  // out of descriptors; the stop is latched, so that the next look finds it
    }
  }
  bool changed = false;
  for (auto& [name, topic] : topics_) {
    const bool before = topic.is_set;
    bool passing_set = false;
    while (Block* const block = topic.passing->take()) {
      // Only a stop: who releases has to be heard by late joiners, too.
      if (static_cast<const std_msgs::msg::Bool*>(block->message)->data) {
        topic.hear(*block);
        passing_set = true;
      }
      drop_reference(*block);
    }
    while (Block* const block = topic.latched->take()) {
      topic.hear(*block);
      drop_reference(*block);
    }
    if (passing_set && topic.is_set && !topic.again) say_again(topic, name);
    if (!topic.is_set) topic.again.reset();
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
