// SPDX-License-Identifier: Apache-2.0
#include "answers/own_container.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "answers/verbs.hpp"

namespace nacelle::answers {
namespace {

constexpr std::size_t kMeasuredDepth = 1000, kReadDepth = 10;

/// The types of which a topic has ends.
std::vector<std::string> types_of(const runtime::Container& container, const std::string& topic) {
  std::vector<runtime::StreamReport> streams;
  container.report_streams(streams);
  std::vector<std::string> types;
  for (const auto& stream : streams) {
    if (stream.name == topic && stream.writers + stream.readers != 0) types.push_back(stream.type);
  }
  return types;
}

}  // namespace

OwnContainer::OwnContainer(Robot& robot) : robot_(robot), types_(robot.message_folders()) {}

const Clock& OwnContainer::clock() const { return robot_.container().clock(); }

requests::Answer OwnContainer::answer(const std::string& verb, const nlohmann::json& request) {
  return reply_to_verb(robot_, types_, verb, request);
}

Result<std::unique_ptr<requests::TopicTap>, Problem> OwnContainer::tap(const requests::TapWish& wish) {
  auto type = type_of(wish);
  if (!type) return err(type.error());
  // Text for display may lose messages; measurements must not.
  return std::make_unique<requests::TopicTap>(robot_.container().transport(), wish.topic, *type.value(),
                                              wish.is_measured ? kMeasuredDepth : kReadDepth);
}

Result<const msgs::MessageType*, Problem> OwnContainer::type_of(const requests::TapWish& wish) {
  const runtime::Container& container = robot_.container();
  // A name may carry two types (cmd_vel does); then the one that is meant can be given.
  if (!wish.type.empty()) {
    auto found = types_.message(wish.type);
    if (!found) return found;
    // With another type no message would ever arrive. A topic without endpoints may still get this type.
    const std::vector<std::string> types = types_of(container, wish.topic);
    if (types.empty() || std::find(types.begin(), types.end(), found.value()->name) != types.end()) return found;
    return err(
        Problem{"topic " + wish.topic, "has the type " + join(types, " and ") + ", not " + found.value()->name, ""});
  }
  if (const auto* const type = container.topic_type(wish.topic); type != nullptr) return type;
  std::vector<std::string> names;
  std::vector<runtime::StreamReport> streams;
  container.report_streams(streams);
  for (const auto& stream : streams) {
    // A stream outlives its endpoints. Such a name, as this one's may be, is no help.
    if (stream.writers != 0 || stream.readers != 0) names.push_back(stream.name);
  }
  return err(Problem{"topic " + wish.topic, "no node publishes it or subscribes to it", suggestion(wish.topic, names)});
}

}  // namespace nacelle::answers
