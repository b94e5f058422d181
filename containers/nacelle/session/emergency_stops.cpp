// SPDX-License-Identifier: Apache-2.0
#include "session/emergency_stops.hpp"

#include <algorithm>
#include <std_msgs/msg/bool.hpp>
#include <system_error>
#include <utility>

#include "nacelle/base/names.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/runtime/repeat.hpp"
#include "session/robot_service.hpp"

namespace nacelle::session {
namespace {

QoS latched_qos() { return QoS(KeepAll{}).reliable().transient_local(); }

}  // namespace

void EmergencyStops::append_waits(std::vector<pollfd>& waits) const {
  waits.reserve(waits.size() + 2 * topics_.size());  // all or none
  for (const auto& [name, topic] : topics_) {
    waits.push_back({topic.latched->descriptor(), POLLIN, 0});
    waits.push_back({topic.passing->descriptor(), POLLIN, 0});
  }
}

void EmergencyStops::open(Topic& topic, const std::string& name, const msgs::MessageType& type) {
  // Not KEEP_ALL: the publisher of a stop must not wait for this reader.
  EndpointSpec spec{name, &type, QoS(100).reliable().transient_local(), ""};
  topic.latched = std::make_unique<requests::TopicTap>(container_.transport(), spec);
  spec.qos = QoS(100).best_effort();
  spec.unless_offered = latched_qos();
  topic.passing = std::make_unique<requests::TopicTap>(container_.transport(), spec);
}

// A late joiner gets the history of one publisher after the other, not in the order of time: the newest message decides.
void EmergencyStops::Topic::hear_latched(const Block& block) {
  const MonotonicTime said_at = block.info.source_time;
  if (static_cast<const std_msgs::msg::Bool*>(block.message)->data) {
    if (said_at < released_at) return;
    is_set = true;
    set_at = std::max(set_at, said_at);
  } else if (said_at >= set_at) {
    is_set = false;
    released_at = std::max(released_at, said_at);
  }
}

// Returns whether it is a stop. As for the base, a stop takes effect even if its stamp is older than the last release, so that the
// release does not undo it for a late joiner. A release must reach late joiners, too.
bool EmergencyStops::Topic::hear_passing(const Block& block) {
  if (!static_cast<const std_msgs::msg::Bool*>(block.message)->data) return false;
  is_set = true;
  set_at = std::max({set_at, block.info.source_time, released_at + 1ns});
  return true;
}

// Each newer stop is repeated, because an earlier release must not release it for a late joiner. Only the newest is
// kept.
void EmergencyStops::repeat_stop(Topic& topic, const std::string& name) {
  if (!topic.again) {
    const EndpointSpec spec{name, &topic.latched->type(), QoS(1).reliable().transient_local(),
                            fully_qualified_node_name(container_.options().name_space, "_emergency_stops")};
    topic.again = container_.transport().create_writer(spec);
  }
  Block* const block = topic.again->borrow();
  if (block == nullptr) return;
  static_cast<std_msgs::msg::Bool*>(block->message)->data = true;
  static_cast<void>(runtime::repeat(*topic.again, *block, topic.set_at));
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
      passing_set = topic.hear_passing(*block) || passing_set;
      drop_reference(*block);
    }
    while (Block* const block = topic.latched->take()) {
      topic.hear_latched(*block);
      drop_reference(*block);
    }
    if (passing_set && topic.is_set) repeat_stop(topic, name);
    if (!topic.is_set) topic.again.reset();
    changed = changed || topic.is_set != before;
  }
  if (!changed) return false;
  std::vector<std::string> names;
  for (const auto& [name, topic] : topics_) {
    if (topic.is_set) names.push_back(name);
  }
  *set_.lock() = std::move(names);
  return true;
}

Result<std::vector<answers::ReleasedStop>, Problem> EmergencyStops::release(const std::vector<std::string>& topics) {
  std::vector<runtime::StreamReport> streams;
  container_.report_streams(streams);
  std::vector<answers::ReleasedStop> released;
  for (const auto& stream : streams) {
    if (stream.readers != 0 && is_emergency_stop(stream.name, stream.type))
      released.push_back({stream.name, stream.readers});
  }
  if (!topics.empty()) {
    std::vector<answers::ReleasedStop> wanted;
    for (const auto& topic : topics) {
      if (!is_emergency_stop(topic, kEmergencyStopType) || !validate_full_topic_name(topic))
        return err(Problem{"topic " + topic, "is not an emergency stop", "give one whose last name is emergency_stop"});
      const auto found = std::ranges::find(released, topic, &answers::ReleasedStop::topic);
      // Even without a reader: one that joins later receives it.
      wanted.push_back(found == released.end() ? answers::ReleasedStop{topic, 0} : *found);
    }
    released = std::move(wanted);
  }
  if (released.empty()) {
    return err(Problem{"emergency stop", "no component of this container reads a topic emergency_stop",
                       "the base (nacelle::diff_drive::DiffDriveComponent) does; is it loaded?"});
  }
  auto writers = releases_.lock();
  for (const answers::ReleasedStop& one : released) {
    auto& writer = (*writers)[one.topic];
    if (!writer) {
      const EndpointSpec spec{one.topic, &std_msgs::msg::Bool::message_type(), QoS(1).reliable().transient_local(),
                              fully_qualified_node_name(container_.options().name_space, "_emergency_release")};
      writer = container_.transport().create_writer(spec);
    }
    Block* const block = writer->borrow();
    if (block == nullptr) return err(Problem{"topic " + one.topic, "out of memory", "try again"});
    static_cast<std_msgs::msg::Bool*>(block->message)->data = false;
    writer->publish(*block);
  }
  return released;
}

}  // namespace nacelle::session
