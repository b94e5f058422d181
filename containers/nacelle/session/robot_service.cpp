// SPDX-License-Identifier: Apache-2.0
#include "session/robot_service.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <iterator>
#include <nlohmann/json.hpp>

#include "nacelle/host/standard_interfaces.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/spatial/transform_buffer.hpp"
#include "process/process_figures.hpp"
#include "report/run_report.hpp"
#include "requests/publish_encoded.hpp"

namespace nacelle::session {

namespace {

// Writers that only emergency stops can have.
constexpr std::size_t kWritersForStops = 8;

}  // namespace

bool is_emergency_stop(std::string_view topic, std::string_view type) {
  return type == kEmergencyStopType && topic.size() > kEmergencyStopTopic.size() &&
         topic.substr(topic.rfind('/') + 1) == kEmergencyStopTopic;
}

RobotService::RobotService(runtime::Container& container, const std::vector<std::filesystem::path>& message_folders,
                           void (*on_shutdown)(void*), void* context, Bell& bell)
    : container_(container),
      types_(message_folders),
      on_shutdown_(on_shutdown),
      context_(context),
      bell_(bell),
      main_thread_(::pthread_self()),
      buffer_name_(spatial::kTransformBufferName) {
  streams_.reserve(64);
  // An emergency stop must work when no library can be opened any more.
  static_cast<void>(types_.message(kEmergencyStopType));
}

bool RobotService::is_emergency_stop(control::NamePair topic_and_type) const {
  return session::is_emergency_stop(topic_and_type.first, topic_and_type.second);
}

void RobotService::descriptors_ran_out(bool ran_out) {
  has_no_descriptors_ = ran_out;
  bell_.ring();
}

void RobotService::descriptor_was_lost() {
  has_lost_a_descriptor_ = true;
  // The event may be closed as well. A signal interrupts the main thread's poll() in any case.
  ::pthread_kill(main_thread_, SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
}

Result<std::uint16_t, std::string> RobotService::open_writer(control::NamePair topic_and_type) {
  if (auto valid = validate_full_topic_name(topic_and_type.first); !valid) return err(valid.error().text());
  auto type = types_.message(topic_and_type.second);
  if (!type) return err(type.error().text());
  const bool latched = is_emergency_stop(topic_and_type);
  for (std::size_t i = 0; latched && i < writers_.size(); ++i) {
    if (writers_[i].latched_topic == topic_and_type.first) return static_cast<std::uint16_t>(i);
  }
  const std::size_t most = writers_.size() - (latched ? 0 : kWritersForStops);
  for (std::size_t i = 0; i < most; ++i) {
    if (writers_[i].writer) continue;
    // Named, so that it counts as one of the stream's writers: the command of a person at the socket is data of the robot.
    // With a '_', as the nodes of ROS 2's tools: lists leave it out.
    EndpointSpec spec{std::string{topic_and_type.first}, type.value(), QoS{10},
                      fully_qualified_node_name(container_.options().name_space, "_control_socket")};
    if (latched) spec.qos = QoS(KeepAll{}).reliable().transient_local();
    writers_[i] = {container_.transport().create_writer(spec), type.value(), latched ? spec.topic : std::string{}};
    return static_cast<std::uint16_t>(i);
  }
  return err(std::string{"too many writers are open"});
}

void RobotService::close_writer(std::uint16_t handle) {
  if (handle < writers_.size() && writers_[handle].latched_topic.empty()) writers_[handle] = {};
}

const char* RobotService::publish(const control::Publication& publication) {
  if (publication.handle >= writers_.size() || !writers_[publication.handle].writer)
    return "no such handle; open the writer first";
  const OpenWriter& open = writers_[publication.handle];
  // Between two stops nothing is sent: what came too late must not move a robot that is being put to rest.
  // An emergency stop may be set, and released, at any time.
  if (phase_ != Phase::Running && open.latched_topic.empty()) return "the robot is not running (yet, or no longer)";
  if (const char* const why = requests::publish_encoded(*open.writer, *open.type, publication.cdr); why != nullptr)
    return why;
  if (!open.latched_topic.empty()) bell_.ring();
  return nullptr;
}

Result<void, std::string> RobotService::set_emergency_stop(const std::string& topic) {
  const auto handle = open_writer({topic, kEmergencyStopType});
  if (!handle) return err(handle.error());
  msgs::AnyMessage stop{*writers_[handle.value()].type};
  if (auto read = msgs::from_json(R"({"data":true})", stop.type(), stop.get()); !read) return err(read.error().text());
  const Bytes cdr = stop.encoded();
  const char* const refused = publish({handle.value(), cdr});
  return refused == nullptr ? Result<void, std::string>{} : err(std::string{refused});
}

control::TransformAnswer RobotService::lookup(control::NamePair target_and_source) {
  if (!transforms_)
    transforms_ = std::static_pointer_cast<spatial::TransformBuffer>(container_.shared_object(buffer_name_));
  control::TransformAnswer answer;
  if (!transforms_) return answer;
  const auto found = transforms_->lookup_latest(target_and_source.first, target_and_source.second);
  if (!found) return answer;
  const auto& X_TS = found.value().X_TS;
  answer.known = true;
  answer.stamp = found.value().stamp;
  answer.translation_m = {X_TS.translation_m.x(), X_TS.translation_m.y(), X_TS.translation_m.z()};
  answer.rotation_xyzw = {X_TS.rotation.x(), X_TS.rotation.y(), X_TS.rotation.z(), X_TS.rotation.w()};
  return answer;
}

void RobotService::append_stats(std::string& out) {
  // Names are ROS names and types, so nothing needs escaping; nodes_json_ was made by a JSON library.
  const auto at = std::back_inserter(out);
  fmt::format_to(at, R"({{"phase":"{}","cpu_s":{:.3f},"rss_mb":{:.1f},"nodes":)", to_text(phase_),
                 to_seconds(process::cpu_time()), static_cast<double>(process::resident_bytes()) / 1e6);
  out.append(*nodes_json_.lock());
  out.append(R"(,"streams":[)");
  container_.report_streams(streams_);
  bool first = true;
  for (const auto& stream : streams_) {
    if (is_standard_topic(stream.name)) continue;
    fmt::format_to(
        at,
        R"({}{{"name":"{}","type":"{}","published":{},"delivered":{},"readers":{},"writers":{},"copies":{},"hz":{:.3f}}})",
        first ? "" : ",", stream.name, stream.type, stream.published, stream.delivered, stream.readers, stream.writers,
        stream.copies, stream.hz());
    first = false;
  }
  out.append("]}");
}

void RobotService::set_nodes(const std::vector<runtime::ComponentInfo>& nodes) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& node : nodes) {
    nlohmann::ordered_json row{{"name", report::component_name(node.node)},
                               {"state", node.managed ? nacelle::to_text(node.state) : "running"}};
    if (!node.fault.code.empty()) row["fault"] = node.fault.code + ": " + node.fault.text;
    for (const auto& fault : node.open_faults) row["open_faults"].push_back(fault.code + ": " + fault.text);
    list.push_back(std::move(row));
  }
  *nodes_json_.lock() = list.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace nacelle::session
