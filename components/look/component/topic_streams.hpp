// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "look/component/picture_maker.hpp"
#include "look/model/outbox.hpp"
#include "look/protocol/server_message.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/node/generic_topics.hpp"

namespace nacelle::look {

/// The topics of a container as channels of the Foxglove protocol. A topic is read only while a viewer subscribes to it, and a message
/// is encoded once for all of them.
///
/// Beside each topic with raw pictures there is a channel with small JPEG pictures of them, "TOPIC/look".
/// Threads: the server's, but for the GraphListener's members.
class TopicStreams final : private GraphListener {
 public:
  /// `on_change`: topics, publishers or subscribers came or went; called on any thread, with locks held. `now`: the time that messages get,
  /// in nanoseconds since the epoch.
  TopicStreams(GenericTopics topics, std::function<void()> on_change, std::function<std::uint64_t()> now);
  ~TopicStreams() override;
  TopicStreams(const TopicStreams&) = delete;
  TopicStreams& operator=(const TopicStreams&) = delete;

  struct Changes {
    std::vector<ChannelInfo> made;
    std::vector<std::uint32_t> gone;
  };
  /// Follows what has changed since the last call.
  [[nodiscard]] Changes take_changes();
  [[nodiscard]] std::vector<ChannelInfo> channels() const;
  /// Adds who publishes and subscribes to what.
  void add_to(ConnectionGraph& graph) const;

  [[nodiscard]] bool has(std::uint32_t id) const { return channels_.contains(id); }
  /// From now on take_messages() gives its messages. Returns those that its publishers keep for late subscribers.
  [[nodiscard]] std::vector<std::shared_ptr<const Encoded>> subscribe(std::uint32_t id);
  void unsubscribe(std::uint32_t id);
  /// Hands over the messages that have come since the last call.
  void take_messages(const std::function<void(std::uint32_t channel, const std::shared_ptr<const Encoded>&)>& take);
  /// Why pictures of a channel cannot be made; said once.
  [[nodiscard]] std::optional<std::string> take_complaint();

 private:
  using Key = std::pair<std::string, const msgs::MessageType*>;
  struct NoListener final : ReadyListener {
    void on_ready() noexcept override {}
  };
  struct Channel {
    Key key;
    bool makes_pictures = false;
    std::size_t subscribers = 0;
    bool is_kept = false;  // by the publishers, for late subscribers
    std::size_t depth = 1;
    std::deque<std::shared_ptr<const Encoded>> kept;
    std::unique_ptr<Reader> reader;
    std::uint32_t sequence = 0;
  };
  struct Change {
    std::uint64_t id = 0;
    std::optional<EndpointInfo> made;  // not set: it is gone
  };
  void on_made(const EndpointInfo& endpoint) noexcept override { note({endpoint.id, endpoint}); }
  void on_gone(std::uint64_t id) noexcept override { note({id, std::nullopt}); }
  void on_gate(std::uint64_t, bool) noexcept override {}
  void on_life(std::uint64_t) noexcept override {}
  void on_left(std::uint64_t) noexcept override {}
  void note(Change change) noexcept;

  void add_channels(const Key& key, Changes& changes);
  [[nodiscard]] bool is_published(const Key& key) const;
  void open(Channel& channel);
  [[nodiscard]] std::shared_ptr<const Encoded> encoded(Channel& channel, const Block& block);
  [[nodiscard]] ChannelInfo info_of(std::uint32_t id, const Channel& channel) const;

  GenericTopics topics_;
  const std::function<void()> on_change_;
  const std::function<std::uint64_t()> now_;
  NoListener no_listener_;
  PictureMaker pictures_;
  bool makes_pictures_now_ = false;
  std::optional<std::string> complaint_;
  std::set<std::string> complained_;
  std::map<std::uint64_t, EndpointInfo> endpoints_;
  std::map<std::uint32_t, Channel> channels_;
  std::uint32_t last_channel_ = 0;

  Mutex mutex_;
  std::vector<Change> changes_ NACELLE_GUARDED_BY(mutex_);
  std::unique_ptr<GraphWatchHandle> graph_;  // the last one: it ends the calls of the listener
};

}  // namespace nacelle::look
