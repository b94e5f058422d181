// SPDX-License-Identifier: Apache-2.0
#include "session/readiness.hpp"

#include <memory>
#include <vector>

#include "nacelle/spatial/transform_buffer.hpp"

namespace nacelle::session {
namespace {

std::string first_message_missing(const runtime::Container& container, const std::string& topic) {
  std::vector<runtime::StreamReport> streams;
  container.report_streams(streams);
  bool has_writer = false;
  for (const auto& stream : streams) {
    if (stream.name != topic) continue;
    if (stream.published > 0) return {};
    has_writer = has_writer || stream.writers > 0;
  }
  return has_writer ? "no message yet" : "no publisher of " + topic;
}

std::string transform_missing(const runtime::Container& container, const std::string& target,
                              const std::string& source) {
  const auto buffer =
      std::static_pointer_cast<spatial::TransformBuffer>(container.shared_object(spatial::kTransformBufferName));
  if (!buffer) return "no component collects transforms (nacelle::transforms::TransformsComponent does)";
  const auto found = buffer->lookup_latest(target, source);
  return found ? std::string{} : found.error().text();
}

}  // namespace

std::string words_of(const launch::AfterCondition& condition) {
  if (condition.when == launch::When::Active) return {};
  return std::string{launch::to_text(condition.when)} + "(" + condition.detail + ")";
}

std::function<std::string()> missing_of(const launch::AfterCondition& condition, const runtime::Container& container) {
  switch (condition.when) {
    case launch::When::Active: break;
    case launch::When::FirstMessage:
      return [&container, topic = condition.detail] { return first_message_missing(container, topic); };
    case launch::When::Tf: {
      const auto arrow = condition.detail.find("->");
      return [&container, target = condition.detail.substr(0, arrow), source = condition.detail.substr(arrow + 2)] {
        return transform_missing(container, target, source);
      };
    }
    case launch::When::Service:
      return [&container, service = condition.detail] {
        return container.service_is_ready(service) ? std::string{} : "no server offers it";
      };
  }
  return {};
}

}  // namespace nacelle::session
