// SPDX-License-Identifier: Apache-2.0
#include "look/component/topic_streams.hpp"

#include <algorithm>
#include <cstring>

#include "nacelle/msgs/message_type.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::look {
namespace {

constexpr std::size_t kLeastDepth = 8, kMostDepth = 64;  // between two looks
constexpr int kMostAtOnce = 256;

bool is_picture(const msgs::MessageType& type) {
  return std::strcmp(type.name, sensor_msgs::msg::Image::message_type().name) == 0;
}

}  // namespace

TopicStreams::TopicStreams(GenericTopics topics, std::function<void()> on_change, std::function<std::uint64_t()> now)
    : topics_(std::move(topics)), on_change_(std::move(on_change)), now_(std::move(now)) {
  graph_ = topics_.watch(*this);
}

TopicStreams::~TopicStreams() { graph_.reset(); }

void TopicStreams::note(Change change) noexcept {
  bool is_first = false;
  {
    const LockGuard lock{mutex_};
    is_first = changes_.empty();
    changes_.push_back(std::move(change));
  }
  if (is_first) on_change_();
}

TopicStreams::Changes TopicStreams::take_changes() {
  std::vector<Change> now;
  {
    const LockGuard lock{mutex_};
    std::swap(now, changes_);
  }
  Changes changes;
  std::set<Key> made, gone;
  for (Change& change : now) {
    if (!change.made) {
      const auto found = endpoints_.find(change.id);
      if (found == endpoints_.end()) continue;
      if (found->second.is_writer) gone.insert({found->second.spec.topic, found->second.spec.type});
      endpoints_.erase(found);
    } else {
      if (change.made->is_writer) made.insert({change.made->spec.topic, change.made->spec.type});
      endpoints_.insert_or_assign(change.id, std::move(*change.made));
    }
  }
  for (const Key& key : made) add_channels(key, changes);
  for (const Key& key : gone) {
    if (is_published(key)) continue;
    std::erase_if(channels_, [&](auto& entry) {
      if (entry.second.key != key) return false;
      changes.gone.push_back(entry.first);
      return true;
    });
  }
  return changes;
}

bool TopicStreams::is_published(const Key& key) const {
  return std::any_of(endpoints_.begin(), endpoints_.end(), [&](const auto& entry) {
    return entry.second.is_writer && entry.second.spec.topic == key.first && entry.second.spec.type == key.second;
  });
}

void TopicStreams::add_channels(const Key& key, Changes& changes) {
  bool is_known = false;
  for (auto& [id, channel] : channels_) {
    if (channel.key != key) continue;
    is_known = true;
    if (channel.reader) open(channel);  // the new publisher may offer less
  }
  if (is_known || !is_published(key)) return;
  const auto add = [&](bool makes_pictures) {
    Channel& channel = channels_[++last_channel_];
    channel.key = key;
    channel.makes_pictures = makes_pictures;
    changes.made.push_back(info_of(last_channel_, channel));
  };
  add(false);
  if (is_picture(*key.second)) add(true);
}

ChannelInfo TopicStreams::info_of(std::uint32_t id, const Channel& channel) const {
  const auto& type = channel.makes_pictures ? sensor_msgs::msg::CompressedImage::message_type() : *channel.key.second;
  return {id, channel.key.first + (channel.makes_pictures ? "/look" : ""), type.name, type.definition};
}

std::vector<ChannelInfo> TopicStreams::channels() const {
  std::vector<ChannelInfo> all;
  for (const auto& [id, channel] : channels_) all.push_back(info_of(id, channel));
  return all;
}

void TopicStreams::add_to(ConnectionGraph& graph) const {
  for (const auto& [id, endpoint] : endpoints_) {
    if (!endpoint.spec.node.empty())
      (endpoint.is_writer ? graph.published : graph.subscribed)[endpoint.spec.topic].insert(endpoint.spec.node);
  }
}

void TopicStreams::open(Channel& channel) {
  std::vector<QoS> offered;
  for (const auto& [id, endpoint] : endpoints_) {
    if (endpoint.is_writer && endpoint.spec.topic == channel.key.first && endpoint.spec.type == channel.key.second)
      offered.push_back(endpoint.spec.qos);
  }
  if (offered.empty()) return;
  const msgs::MessageType& type = *channel.key.second;
  // Of messages in a device's memory as few as possible are kept from it.
  const QoS qos = type.holds_buffers ? reader_qos(offered, 1, 1) : reader_qos(offered, kLeastDepth, kMostDepth);
  channel.reader.reset();
  channel.kept.clear();
  channel.is_kept = qos.durability() == Durability::TransientLocal;
  channel.depth = 0;
  for (const QoS& one : offered) channel.depth += one.resolved().queue_capacity();
  channel.depth = std::clamp<std::size_t>(channel.depth, 1, kMostDepth);
  channel.reader = topics_.read(channel.key.first, type, qos, no_listener_);
}

std::vector<std::shared_ptr<const Encoded>> TopicStreams::subscribe(std::uint32_t id) {
  Channel& channel = channels_.at(id);
  if (++channel.subscribers == 1) open(channel);
  return {channel.kept.begin(), channel.kept.end()};
}

void TopicStreams::unsubscribe(std::uint32_t id) {
  const auto found = channels_.find(id);
  if (found == channels_.end() || found->second.subscribers == 0 || --found->second.subscribers > 0) return;
  found->second.reader.reset();
  found->second.kept.clear();
}

std::shared_ptr<const Encoded> TopicStreams::encoded(Channel& channel, const Block& block) {
  const msgs::MessageType& type = *channel.key.second;
  auto made = std::make_shared<Encoded>();
  made->time = now_();
  if (!channel.makes_pictures) {
    made->bytes.resize(type.encoded_size(block.message));
    type.encode(block.message, made->bytes.data());
    return made;
  }
  auto picture = pictures_.make(*static_cast<const sensor_msgs::msg::Image*>(block.message));
  if (!picture) {
    if (complained_.insert(channel.key.first).second) complaint_ = channel.key.first + ": " + picture.error();
    return nullptr;
  }
  made->bytes = std::move(picture).value();
  return made;
}

void TopicStreams::take_messages(
    const std::function<void(std::uint32_t, const std::shared_ptr<const Encoded>&)>& take) {
  makes_pictures_now_ = !makes_pictures_now_;  // half as many: each costs milliseconds
  for (auto& [id, channel] : channels_) {
    if (!channel.reader || (channel.makes_pictures && !makes_pictures_now_)) continue;
    // Large messages: the newest only, so that none is encoded in vain.
    const bool newest_only = channel.key.second->holds_buffers;
    Block* newest = nullptr;
    for (int left = kMostAtOnce; left > 0; --left) {
      Block* const block = channel.reader->take();
      if (block == nullptr) break;
      if (newest_only) {
        if (newest != nullptr) drop_reference(*newest);
        newest = block;
        continue;
      }
      const auto message = encoded(channel, *block);
      drop_reference(*block);
      if (message == nullptr) continue;
      if (channel.is_kept) {
        channel.kept.push_back(message);
        if (channel.kept.size() > channel.depth) channel.kept.pop_front();
      }
      take(id, message);
    }
    if (newest == nullptr) continue;
    const auto message = encoded(channel, *newest);
    drop_reference(*newest);
    if (message != nullptr) take(id, message);
  }
}

std::optional<std::string> TopicStreams::take_complaint() { return std::exchange(complaint_, std::nullopt); }

}  // namespace nacelle::look
