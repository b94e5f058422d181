// SPDX-License-Identifier: Apache-2.0
#include "record/component/remote_topics.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "nacelle/msgs/byte_message.hpp"

namespace nacelle::record {
namespace {

constexpr std::size_t kMostFound = 1000;  // of what other programs may announce
constexpr std::size_t kMostDefinitionBytes = std::size_t{1} << 20U;

/// "std_msgs/String" for "std_msgs/msg/String", as definitions name types.
std::string short_name(const std::string& type) {
  const auto first = type.find('/'), last = type.rfind('/');
  return first == std::string::npos ? type : type.substr(0, first) + type.substr(last);
}

}  // namespace

std::string definition_in(const type_description_interfaces::srv::GetTypeDescription::Response& response,
                          const std::string& type) {
  if (!response.successful) return {};
  const auto& sources = response.type_sources;
  const auto own = std::find_if(sources.begin(), sources.end(), [&](const auto& one) { return one.type_name == type; });
  if (own == sources.end()) return {};
  std::string text{own->raw_file_contents};
  std::set<std::string> known{type};
  for (const auto& source : sources) {
    const std::string name{source.type_name};
    if (source.encoding != "msg" || source.raw_file_contents.empty()) return {};
    if (!known.insert(name).second) continue;
    text += "\n" + std::string(80, '=') + "\nMSG: " + short_name(name) + "\n" + std::string{source.raw_file_contents};
    if (text.size() > kMostDefinitionBytes) return {};
  }
  return text;
}

RemoteTopics::RemoteTopics(Node& node, const Clock& clock, std::shared_ptr<const NetworkFacts> facts, Options options)
    : node_(node),
      clock_(clock),
      facts_(std::move(facts)),
      options_(std::move(options)),
      types_({msgs::TypeLibrary::own_folder()}) {}

RemoteTopics::~RemoteTopics() = default;

void RemoteTopics::look() {
  for (RemoteTopic& topic : facts_->remote_topics(version_)) {
    if (options_.takes(topic.name)) take(std::move(topic));
  }
  for (auto& [key, found] : found_) {
    if (found.type != nullptr) continue;
    ask(found);
    if (clock_.now() >= found.until) settle(found, {});
  }
}

void RemoteTopics::take(RemoteTopic topic) {
  const Key key{topic.name, topic.type, topic.hash};
  const auto known = found_.find(key);
  if (known != found_.end()) {
    known->second.topic = std::move(topic);
    if (known->second.type != nullptr)
      options_.add(known->second.topic.name, *known->second.type, known->second.topic.offered);
    return;
  }
  if (found_.size() >= kMostFound) return;
  Found& found = found_[key];
  found.topic = std::move(topic);
  found.until = clock_.now() + options_.patience;
  const auto installed = types_.message(found.topic.type);
  if (!installed || (!found.topic.hash.empty() && found.topic.hash != (*installed)->hash)) {
    if (found.topic.hash.empty()) settle(found, {});  // nodes answer for hashes
    return;
  }
  found.type = *installed;
  options_.add(found.topic.name, *found.type, found.topic.offered);
}

/// The publishers' nodes may be known later than their topic, and their services later than they.
void RemoteTopics::ask(Found& found) {
  const auto& nodes = found.topic.nodes;
  if (nodes.empty() || found.is_sent) return;
  if (std::find(nodes.begin(), nodes.end(), found.asked) == nodes.end()) {
    found.asked = nodes.front();
    found.client = node_.create_client<GetTypeDescription>(found.asked + "/get_type_description");
  }
  if (!found.client->service_is_ready()) return;
  GetTypeDescription::Request request;
  request.type_name = found.topic.type;
  request.type_hash = found.topic.hash;
  request.include_type_sources = true;
  const Key key{found.topic.name, found.topic.type, found.topic.hash};
  found.is_sent = found.client->async_send_request(std::move(request), [this, key](const auto* response) {
    Found& asked = found_.at(key);
    if (asked.type == nullptr) settle(asked, response == nullptr ? "" : definition_in(*response, asked.topic.type));
  });
}

void RemoteTopics::settle(Found& found, const std::string& definition) {
  const RemoteTopic& topic = found.topic;
  found.type = msgs::lasting_byte_type(topic.type, topic.dds_type, topic.hash, definition);
  if (found.type == nullptr) {
    found.until = MonotonicTime{Duration::max()};  // there are too many types: it is left out
    return;
  }
  const std::string as = definition.empty()
                             ? " is recorded without its definition, which no node of its publishers gives"
                             : " is recorded by its bytes: this program has no such type";
  node_.get_logger().info("{} ({}){}", topic.name, topic.type, as);
  options_.add(topic.name, *found.type, topic.offered);
}

}  // namespace nacelle::record
