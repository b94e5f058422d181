// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <list>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/host/graph.hpp"
#include "nacelle/runtime/component_info.hpp"
#include "nacelle/runtime/graph_watch.hpp"
#include "nacelle/runtime/introspection.hpp"
#include "nacelle/runtime/pool.hpp"
#include "nacelle/runtime/reports.hpp"

namespace nacelle::runtime {

class BrokerWriter;
class Executable;
class ReaderQueue;
class Topic;
class QosWatch;

/// How deadlines and leases are checked: by the caller with watch(), or by a thread of the broker, which is started for
/// the first of them.
enum class Watching : std::uint8_t { ByCaller, ByThread };

/// The in-process transport: passes envelopes from a writer to the queues of its readers. Nothing is encoded, and a
/// message is copied only if several readers want to own it (design D4).
///
/// A writer keeps its own list of matched readers and compares a version to detect a newer one, so publish() takes one
/// short lock per executor whose readers it serves, and no lock of the broker. A ReadyListener may take() from within
/// on_ready(): no lock of the queue is held then. It must not publish to that topic, nor make or destroy an endpoint: a
/// writer with a history calls it under its topic's lock.
/// Threads: as Transport.
class Broker final : public Graph {
 public:
  explicit Broker(const Clock& clock, Watching watching = Watching::ByCaller);
  ~Broker() override;

  [[nodiscard]] std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override;
  [[nodiscard]] std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, Taking taking,
                                                      ReadyListener* listener) override;
  /// Creates a reader that passes its messages to the executable when that runs (Executable::execute_with). Never null.
  [[nodiscard]] std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, Taking taking, Executable& executable);
  MonotonicTime watch(MonotonicTime now) override;

  [[nodiscard]] std::uint32_t join(GraphListener& listener) override;
  void leave(std::uint32_t link) override;
  [[nodiscard]] std::unique_ptr<ProxyWriter> create_proxy_writer(const EndpointSpec& spec, std::uint64_t id) override;
  [[nodiscard]] std::unique_ptr<ProxyReader> create_proxy_reader(const EndpointSpec& spec,
                                                                 ReadyListener* listener) override;
  [[nodiscard]] std::unique_ptr<ProxyReader> create_tap(const EndpointInfo& writer, std::uint32_t link,
                                                        ReadyListener* listener) override;
  [[nodiscard]] std::unique_ptr<Witness> create_witness(const EndpointSpec& spec) override;
  void note_lost(const EndpointInfo& reader, const ReaderCounters& losses) override;
  void note_other_type(const EndpointInfo& ours, const std::string& node, const std::string& type) override;

  [[nodiscard]] std::vector<ClashReport> clashes() const;
  /// Returns the topics in use, and the newest 256 of those without endpoints, with their totals.
  void report(std::vector<StreamReport>& out) const;
  void report(std::vector<ReaderReport>& out) const;
  [[nodiscard]] WiringReport wiring(const std::string& name, Duration age) const;
  [[nodiscard]] std::vector<EndpointReport> endpoints() const;
  [[nodiscard]] std::vector<std::string> topics_of(const std::string& node) const;
  /// Returns the types of the streams that a node publishes or reads.
  [[nodiscard]] std::vector<const msgs::MessageType*> types_of(const std::string& node) const;
  [[nodiscard]] const msgs::MessageType* topic_type(const std::string& name) const;

  /// Frees the pools of destroyed writers to which all messages have returned. Returns the messages of these nodes that
  /// are still held: "2 messages of /scan"; empty: none.
  [[nodiscard]] std::string sweep(const std::vector<std::string>& nodes);

 private:
  friend class BrokerWriter;
  friend class BrokerReader;
  struct Retired {
    std::string node, topic;
    std::unique_ptr<MessagePool> pool;
  };
  std::shared_ptr<Topic> topic(const EndpointSpec& spec) NACELLE_REQUIRES(mutex_);
  void note_end(Topic& topic);
  std::unique_ptr<ProxyWriter> make_writer(const EndpointSpec& spec, std::uint64_t id) NACELLE_REQUIRES(mutex_);
  std::unique_ptr<ProxyReader> make_reader(std::shared_ptr<ReaderQueue> queue) NACELLE_REQUIRES(mutex_);
  void retire(const EndpointSpec& spec, std::unique_ptr<MessagePool> pool);
  void drop_what_is_home() NACELLE_REQUIRES(mutex_);
  void look_earlier();
  void tell_type_clashes() NACELLE_REQUIRES(mutex_);
  /// Calls `found` with each writer and reader of one name whose types differ, unless the reader's node reads both
  /// types. Not checked by the compiler: it holds the locks of two topics, under other names than `found` uses.
  template <typename F>
  void for_each_type_clash(F&& found) const NACELLE_REQUIRES(mutex_) NACELLE_NOT_CHECKED;

  const Clock& clock_;
  mutable Mutex mutex_;
  std::map<std::pair<std::string, const msgs::MessageType*>, std::shared_ptr<Topic>> topics_ NACELLE_GUARDED_BY(mutex_);
  // Topics without an endpoint, kept for their totals; the oldest first.
  std::list<Topic*> unused_ NACELLE_GUARDED_BY(mutex_);
  std::vector<Retired> retired_ NACELLE_GUARDED_BY(mutex_);
  std::uint64_t next_id_ NACELLE_GUARDED_BY(mutex_);  // of endpoints; unique on the host
  std::uint32_t next_link_ NACELLE_GUARDED_BY(mutex_) = 1;
  GraphWatch links_;
  bool types_to_compare_ NACELLE_GUARDED_BY(mutex_) = false;  // an endpoint joined a name with several types
  // Writer, reader: each pair is reported once.
  std::set<std::pair<std::uint64_t, std::uint64_t>> told_types_ NACELLE_GUARDED_BY(mutex_);
  std::unique_ptr<QosWatch> qos_watch_;  // the last member: its thread uses the others
};

}  // namespace nacelle::runtime
