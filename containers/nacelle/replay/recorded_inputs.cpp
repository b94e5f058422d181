// SPDX-License-Identifier: Apache-2.0
#include "replay/recorded_inputs.hpp"

#include <algorithm>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>

#include "record/model/bag_metadata.hpp"

namespace nacelle::replay {
namespace {

bool is_transforms(const msgs::MessageType& type) { return &type == &tf2_msgs::msg::TFMessage::message_type(); }

std::string value_of(const std::map<std::string, std::string>& metadata, const char* key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? "" : found->second;
}

}  // namespace

RecordedInputs::RecordedInputs(record::OrderedMessages& recording, Transport& transport, const FindType& find_type,
                               const std::set<std::string>& published)
    : recording_(recording) {
  for (const auto& topic : recording.topics()) add(topic, transport, find_type, published);
  next_ = recording_.next();
}

void RecordedInputs::add(const record::OrderedMessages::Topic& recorded, Transport& transport,
                         const FindType& find_type, const std::set<std::string>& published) {
  Topic& topic = topics_.emplace_back();
  const auto refuse = [&](const std::string& why) { refused_.push_back(recorded.name + ": " + why); };
  const bool is_shared = published.contains(recorded.name);
  if (recorded.message_encoding != "cdr") {
    if (!is_shared) refuse("its messages are '" + recorded.message_encoding + "', not CDR");
    return;
  }
  const msgs::MessageType* const type = find_type(recorded.type);
  if (is_shared && (type == nullptr || !is_transforms(*type))) return;
  if (type == nullptr) return refuse("its type " + recorded.type + " is not installed");
  const std::string hash = value_of(recorded.metadata, "topic_type_hash");
  if (!hash.empty() && hash != type->hash) return refuse("it was recorded with another definition of " + recorded.type);
  // The files of a recording may describe one topic differently.
  for (std::size_t i = 0; i + 1 < topics_.size(); ++i) {
    if (topics_[i].writer == nullptr || recording_.topics()[i].name != recorded.name) continue;
    if (topics_[i].type != type) return refuse("it has two types");
    topic = topics_[i];
    return;
  }
  const QoS qos = record::strongest_qos(record::read_qos_profiles(value_of(recorded.metadata, "offered_qos_profiles")));
  EndpointSpec spec;
  spec.topic = recorded.name;
  spec.type = type;
  spec.qos = qos;
  writers_.push_back(transport.create_writer(spec));
  ids_.insert(writers_.back()->id());
  topic = {type, writers_.back().get(), qos.resolved().durability() == Durability::TransientLocal, is_shared};
}

/// Returns false for bytes that are no message of the type.
bool RecordedInputs::decode_next(const Topic& topic, void* message) {
  if (!topic.type->decode(next_->data, message)) return false;
  if (!is_transforms(*topic.type) || claimed_.empty()) return true;
  auto& transforms = static_cast<tf2_msgs::msg::TFMessage*>(message)->transforms;
  std::erase_if(transforms, [this](const auto& one) { return claimed_.contains(one.child_frame_id); });
  return true;
}

void RecordedInputs::publish_next() {
  const Topic& topic = topics_[next_->topic];
  if (topic.writer != nullptr) {
    Block* const block = next_has_reader() ? topic.writer->borrow() : nullptr;
    if (block == nullptr) {
      ++figures_.unread;
    } else if (!decode_next(topic, block->message)) {
      ++figures_.undecoded;
      drop_reference(*block);
    } else if (topic.is_shared && static_cast<tf2_msgs::msg::TFMessage*>(block->message)->transforms.empty()) {
      drop_reference(*block);  // all of it is left to running components
    } else {
      ++figures_.played;
      static_cast<void>(topic.writer->publish(*block));
    }
  }
  next_ = recording_.next();
}

}  // namespace nacelle::replay
