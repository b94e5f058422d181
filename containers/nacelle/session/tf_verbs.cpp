// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/tf_verbs.hpp"

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tf2_msgs/msg/tf_message.hpp>

#include "nacelle/control/client.hpp"
#include "nacelle/session/session.hpp"
#include "nacelle/spatial/rotation.hpp"
#include "nacelle/spatial/transform_buffer.hpp"

namespace nacelle::session {
namespace {

using control::reply_of;
using nlohmann::json;

std::shared_ptr<spatial::TransformBuffer> buffer_of(Session& session) {
  return std::static_pointer_cast<spatial::TransformBuffer>(
      session.container().shared_object(spatial::kTransformBufferName));
}

double rate_of(const spatial::FrameInfo& frame) {
  const Duration span = frame.newest - frame.oldest;
  return frame.is_static || frame.samples < 2 || span <= Duration::zero()
             ? 0.0
             : static_cast<double>(frame.samples - 1) / to_seconds(span);
}

json tree(Session& session) {
  std::map<std::string, std::string> owners;
  for (const auto& claim : session.container().frames()) {
    if (claim.owns) owners[claim.child] = claim.node;
  }
  const auto skews = std::static_pointer_cast<ClockSkews>(session.container().shared_object(kClockSkewsName));
  const WallTime now = session.container().clock().wall_now();
  json rows = json::array();
  if (const auto buffer = buffer_of(session)) {
    for (const auto& frame : buffer->frames()) {
      const auto owner = owners.find(frame.child);
      rows.push_back({{"child", frame.child},
                      {"parent", frame.parent},
                      {"owner", owner == owners.end() ? "" : owner->second},
                      {"static", frame.is_static},
                      {"rate_hz", rate_of(frame)},
                      {"age_s", frame.is_static ? 0.0 : to_seconds(now - frame.newest)},
                      {"history_s", frame.is_static ? 0.0 : to_seconds(frame.newest - frame.oldest)},
                      {"samples", frame.samples}});
      if (const ClockSkew skew = skews->of_writer(frame.writer); skew && !frame.is_static)
        rows.back()["clock_skew"] = skew.text();
    }
  }
  return {{"ok", true}, {"frames", std::move(rows)}};
}

Problem why_not(const spatial::TransformBuffer& buffer, const spatial::LookupFault& fault, const std::string& target,
                const std::string& source) {
  std::set<std::string> names;
  for (const auto& frame : buffer.frames()) names.insert({frame.child, frame.parent});
  std::string way_out = "see `nacelle tf tree`";
  for (const auto& name : {target, source}) {
    if (names.count(name) == 0) way_out = "'" + name + "': " + suggestion(name, {names.begin(), names.end()});
  }
  return {source + " in " + target, fault.text(), names.empty() ? "nobody has sent a transform yet" : way_out};
}

json lookup(Session& session, const json& request) {
  const std::string target = request.value("target", ""), source = request.value("source", "");
  const auto buffer = buffer_of(session);
  if (!buffer) {
    return reply_of({"transforms", "no component of this container keeps them",
                     "load nacelle::transforms::TransformsComponent, or a component that uses them"});
  }
  const auto found = buffer->lookup_latest(target, source);
  if (!found) return reply_of(why_not(*buffer, found.error(), target, source));
  const auto& X_TS = found.value().X_TS;
  const auto angles = spatial::rpy_from_quaternion(X_TS.rotation);
  return {{"ok", true},
          {"stamp_ns", found.value().stamp.nanoseconds()},
          {"translation_m", {X_TS.translation_m.x(), X_TS.translation_m.y(), X_TS.translation_m.z()}},
          {"rotation_xyzw", {X_TS.rotation.x(), X_TS.rotation.y(), X_TS.rotation.z(), X_TS.rotation.w()}},
          {"rpy_rad", {angles.roll_rad, angles.pitch_rad, angles.yaw_rad}}};
}

}  // namespace

json reply_to_tf_verb(Session& session, const std::string& verb, const json& request) {
  if (verb == "tf.tree") return tree(session);
  if (verb == "tf.lookup") return lookup(session, request);
  return nullptr;
}

void append_transform_times(std::string& out, const Block& block, const Clock& clock) {
  const auto& message = *static_cast<const tf2_msgs::msg::TFMessage*>(block.message);
  const WallTime published = clock.wall_now() - (clock.now() - block.info.source_time);
  json rows = json::array();
  for (const auto& transform : message.transforms) {
    const auto& stamp = transform.header.stamp;
    rows.push_back({transform.child_frame_id, transform.header.frame_id,
                    std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec, published.nanoseconds()});
  }
  out += rows.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace nacelle::session
