// SPDX-License-Identifier: Apache-2.0
#include "answers/frames.hpp"

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/runtime/interface_messages.hpp"
#include "nacelle/spatial/transform_buffer.hpp"

namespace nacelle::answers {
namespace {

using nacelle_interfaces::srv::GetFrames;
using nacelle_interfaces::srv::LookupTransform;
using nlohmann::json;

std::shared_ptr<spatial::TransformBuffer> buffer_of(const runtime::Container& container) {
  return std::static_pointer_cast<spatial::TransformBuffer>(container.shared_object(spatial::kTransformBufferName));
}

double rate_of(const spatial::FrameInfo& frame) {
  const Duration span = frame.newest - frame.oldest;
  return frame.is_static || frame.samples < 2 || span <= Duration::zero()
             ? 0.0
             : static_cast<double>(frame.samples - 1) / to_seconds(span);
}

Problem why_not(const spatial::TransformBuffer& buffer, const spatial::LookupFault& fault, const std::string& target,
                const std::string& source) {
  std::set<std::string> names;
  for (const auto& frame : buffer.frames()) names.insert({frame.child, frame.parent});
  std::string way_out = "see `nacelle tf tree`";
  for (const auto& name : {target, source}) {
    if (names.count(name) == 0) way_out = "'" + name + "': " + suggestion(name, {names.begin(), names.end()});
  }
  return {source + " in " + target, fault.text(),
          names.empty() ? "no component has published a transform yet" : way_out};
}

LookupTransform::Response refusal(const Problem& problem) {
  LookupTransform::Response response;
  response.problem = runtime::message_of(problem);
  return response;
}

}  // namespace

GetFrames::Response frames_of(const runtime::Container& container, const launch::NamespacePlan& names) {
  GetFrames::Response response;
  response.name_space = names.path;
  response.tf_topic = names.tf_topic();
  response.frame_prefix = names.frame_prefix();
  const auto buffer = buffer_of(container);
  if (!buffer) return response;
  std::map<std::string, std::string> owners;
  for (const auto& claim : container.frames()) {
    if (claim.owns) owners[claim.child] = claim.node;
  }
  const auto skews = std::static_pointer_cast<ClockSkews>(container.shared_object(kClockSkewsName));
  const WallTime now = container.clock().wall_now();
  for (const auto& frame : buffer->frames()) {
    auto& row = response.frames.emplace_back();
    row.child = frame.child;
    row.parent = frame.parent;
    if (const auto owner = owners.find(frame.child); owner != owners.end()) row.owner = owner->second;
    row.is_static = frame.is_static;
    row.rate_hz = rate_of(frame);
    row.samples = frame.samples;
    if (frame.is_static) continue;
    row.age_s = to_seconds(now - frame.newest);
    row.history_s = to_seconds(frame.newest - frame.oldest);
    row.clock_skew = skews->of_writer(frame.writer).text();
  }
  return response;
}

LookupTransform::Response transform_of(const runtime::Container& container, const LookupTransform::Request& request) {
  const auto buffer = buffer_of(container);
  if (!buffer) {
    return refusal({"transforms", "no component of this container keeps them",
                    "load nacelle::transforms::TransformsComponent, or a component that uses them"});
  }
  const auto found = buffer->lookup_latest(request.target, request.source);
  if (!found) return refusal(why_not(*buffer, found.error(), request.target, request.source));
  const auto& X_TS = found.value().X_TS;
  LookupTransform::Response response;
  response.success = true;
  auto& header = response.transform.header;
  header.frame_id = request.target;
  header.stamp = found.value().stamp;
  response.transform.child_frame_id = request.source;
  auto& translation = response.transform.transform.translation;
  auto& rotation = response.transform.transform.rotation;
  translation.x = X_TS.translation_m.x();
  translation.y = X_TS.translation_m.y();
  translation.z = X_TS.translation_m.z();
  rotation.x = X_TS.rotation.x();
  rotation.y = X_TS.rotation.y();
  rotation.z = X_TS.rotation.z();
  rotation.w = X_TS.rotation.w();
  return response;
}

}  // namespace nacelle::answers
