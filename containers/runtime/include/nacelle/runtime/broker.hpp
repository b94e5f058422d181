// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "nacelle/node/transport.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/pool.hpp"

namespace nacelle::runtime {

class Topic;

/// The in-process transport: hands envelopes from a writer to the queues of its readers. Nothing is encoded or copied, but for
/// owners that share a message (design D4).
///
/// A writer keeps its own list of matched readers and looks for a newer one by comparing a version, so publish() takes one short
/// lock per reader and none of the broker's. Lock order: topic, reader's queue, then whatever the listener locks.
/// Threads: as Transport.
class Broker final : public Transport {
 public:
  explicit Broker(const Clock& clock);
  ~Broker() override;

  [[nodiscard]] std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override;
  [[nodiscard]] std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, Taking taking,
                                                      ReadyListener* listener) override;

  [[nodiscard]] std::vector<ClashReport> clashes() const;
  void report(std::vector<StreamReport>& out) const;
  [[nodiscard]] const msgs::MessageType* topic_type(const std::string& name) const;

  /// Pools whose writer is gone wait here for their last messages; sweep() frees those that are complete.
  /// Returns what a node's messages are still held by: "2 messages of /scan", or nothing.
  [[nodiscard]] std::string sweep(const std::string& node);

 private:
  friend class Topic;
  friend class BrokerWriter;
  struct Retired {
    std::string node, topic;
    std::unique_ptr<MessagePool> pool;
  };
  std::shared_ptr<Topic> topic(const EndpointSpec& spec);
  void retire(const EndpointSpec& spec, std::unique_ptr<MessagePool> pool);

  const Clock& clock_;
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, const msgs::MessageType*>, std::shared_ptr<Topic>> topics_;
  std::vector<Retired> retired_;
  std::uint64_t next_writer_id_ = 1;
};

}  // namespace nacelle::runtime
