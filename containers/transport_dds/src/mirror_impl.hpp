// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "mirror_lane.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/transport_dds/mirror.hpp"
#include "transport_dds/port/discovery.hpp"
#include "transport_dds/port/reader.hpp"
#include "transport_dds/port/writer.hpp"
#include "transport_dds/wire/graph_snapshot.hpp"
#include "transport_dds/wire/network_fault.hpp"
#include "transport_dds/wire/peer_clock.hpp"
#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle {

namespace dds = transport_dds;

/// Returns the problem of an endpoint of this side that could not be made.
inline Problem end_not_shown(Place where, std::string name, const Problem& why) {
  return {std::move(where), "is not on the network: " + why.text(), "", dds::NetworkFault::EndNotShown,
          std::move(name)};
}

/// A counter with one writing thread, read by others.
using Figure = std::atomic<std::uint64_t>;

/// The data of a mirror. Threads: on_*() and note_*() any; the rest the network's own.
struct DdsMirror::Impl final : GraphListener, dds::DiscoveryListener {
  /// An endpoint of this side. Threads: on_*() any.
  struct LocalEnd : dds::EndpointListener, ReadyListener {
    LocalEnd(Impl& owner, EndpointInfo of) : mirror(owner), info(std::move(of)) {}
    void on_status() noexcept override {
      is_status_new = true;
      mirror.note_ready(*this);
    }
    void on_data() noexcept override { mirror.note_ready(*this); }
    void on_ready() noexcept override { mirror.note_ready(*this); }

    Impl& mirror;
    EndpointInfo info;
    std::atomic<bool> queued{false}, is_status_new{false};
  };
  /// The result of sending a message.
  struct Written {
    enum class How : std::uint8_t { Sent, HeldUp, Failed, TooMuch } how = How::Failed;
    std::size_t bytes = 0;
  };
  /// While a message is `at_lane`, the other thread uses `writer` and `unsent`, and this one nothing of the writer's.
  struct LocalWriter final : LocalEnd {
    using LocalEnd::LocalEnd;
    ~LocalWriter() override { drop_unsent(); }
    void drop_unsent() {
      if (unsent != nullptr) drop_reference(*std::exchange(unsent, nullptr));
      is_admitted = false;
    }
    std::set<dds::Gid> matched;
    Block* unsent = nullptr;   // taken from the tap, but not sent yet: DDS had no room, or its export rule limits it
    bool is_admitted = false;  // the export rule has admitted `unsent`
    std::uint64_t told_overwritten = 0;
    bool showed_life = false, told_refused = false, at_lane = false;
    Written by_lane;  // valid once lane_done
    std::atomic<bool> lane_done{false};
    MonotonicTime gives_up_at;            // for a writer that has ended here
    std::unique_ptr<dds::Writer> writer;  // null: refused. Destroyed before the members above
    std::unique_ptr<ProxyReader> tap;
  };
  struct LocalReader final : LocalEnd {
    using LocalEnd::LocalEnd;
    /// Messages that arrive while the gate is closed wait until it opens, if the reader requests history.
    [[nodiscard]] bool takes() const;
    std::map<dds::Gid, std::uint64_t> sequences;  // of the writers that it has received from
    std::optional<dds::Sample> head;              // taken, but not delivered yet
    dds::ReaderCounters told;
    std::uint64_t told_lost = 0;
    bool is_announced = false;
    std::unique_ptr<dds::Reader> reader;  // null: not announced, or refused
  };
  /// A remote participant with writers that this side reads.
  struct Peer {
    std::string host;  ///< As announced, or a substitute name.
    dds::PeerClock clock;
  };
  /// The proxy of a remote endpoint: one of the two.
  struct StandIn {
    dds::RemoteEndpoint end;
    std::uint64_t id = 0;
    const msgs::MessageType* type = nullptr;
    bool told_broken = false;
    MonotonicTime showed_life;
    Peer* peer = nullptr;  // for a writer: its entry in `peers`
    std::unique_ptr<ProxyWriter> writer;
    std::unique_ptr<Witness> witness;
  };
  struct TopicUse {
    std::vector<LocalWriter*> writers;
    std::vector<LocalReader*> readers;
    std::optional<dds::ExportGate> gate;  // none: no limits
  };
  struct Event {
    enum class Kind : std::uint8_t { Made, Gone, Gate, Life } kind;
    EndpointInfo info;  // for Made; else only the id and `open`
  };
  /// Events from other threads that the network's thread has not handled yet.
  struct Noted {
    std::vector<Event> events;
    std::vector<std::uint64_t> ready;
    bool discovery = false, snapshots = false, services = false, stopping = false;
    [[nodiscard]] bool any() const {
      return discovery || snapshots || services || stopping || !events.empty() || !ready.empty();
    }
  };
  struct Services;  // mirror_services.hpp
  /// Listener of the reader of other participants' snapshots.
  struct SnapshotListener final : dds::EndpointListener {
    explicit SnapshotListener(Impl& owner) : mirror(owner) {}
    void on_status() noexcept override {}
    void on_data() noexcept override;
    Impl& mirror;
  };

  Impl(Graph& graph, const Clock& clock, MirrorOptions options, std::unique_ptr<dds::Participant> participant);
  ~Impl() override;
  [[nodiscard]] Result<void, Problem> open(ServiceGraph* service_graph);

  // GraphListener, DiscoveryListener
  void on_made(const EndpointInfo& endpoint) noexcept override;
  void on_gone(std::uint64_t id) noexcept override;
  void on_gate(std::uint64_t reader, bool open) noexcept override;
  void on_life(std::uint64_t writer) noexcept override;
  void on_left(std::uint64_t) noexcept override {}
  void on_discovery() noexcept override;
  void note_ready(LocalEnd& end) noexcept;
  void note_services() noexcept;
  template <typename F>
  void note(F change) noexcept;

  // mirror.cpp: the thread
  void run();
  void turn();
  void tell(const Problem& problem);
  /// Reports a problem once for each key. The number of remembered keys is limited.
  void tell_once(const std::string& key, const Problem& problem);

  // mirror_local.cpp: the endpoints of this side on the network
  void take(const Event& event);
  void take_made(const EndpointInfo& info);
  void take_gone(std::uint64_t id);
  void wind_up(std::unique_ptr<LocalWriter> end);
  void bury(std::shared_ptr<LocalEnd> end);
  void make_writer(const EndpointInfo& info);
  void make_reader(const EndpointInfo& info);
  void announce(LocalReader& end);
  void withdraw(LocalReader& end);
  /// Chooses which of several types is announced under a name: see Announced.
  void choose_types();
  void choose_type(TopicUse& use, const std::string& topic);
  void count_readers();
  [[nodiscard]] Result<dds::EndpointOptions, Problem> options_for(const EndpointInfo& info) const;
  /// Adds an endpoint to the snapshot of this side's nodes, or removes it.
  void show(const std::string& node, const dds::Gid& gid, bool is_writer);
  void hide(const std::string& node, const dds::Gid& gid, bool is_writer);
  void look_at_status(LocalWriter& end);
  void look_at_status(LocalReader& end);
  /// Sets whether a remote reader counts as a subscription of this writer in the graph.
  void count(const dds::Gid& reader, const LocalWriter& by, bool counts);

  // mirror_remote.cpp: remote endpoints
  void take_discovery();
  void take_participant(dds::DiscoveryEvent::Kind kind, const dds::DiscoveredParticipant& found);
  void take_endpoint(dds::DiscoveryEvent::Kind kind, const dds::DiscoveredEndpoint& found);
  void take_snapshots();
  void consider(const dds::RemoteEndpoint& end);
  void consider_all(const std::string& topic);
  void make_stand_in(const dds::RemoteEndpoint& end, const msgs::MessageType& type);
  void drop_gone();
  void forget(const dds::Gid& gid);
  /// Returns "/arm/driver", for display.
  [[nodiscard]] std::string node_of(const dds::Gid& endpoint) const;
  [[nodiscard]] static std::string node_name_of(const dds::RemoteEndpoint& end);
  MonotonicTime show_life();
  void look_for_namesakes();

  // mirror_clocks.cpp: the clocks of other machines
  [[nodiscard]] Peer& peer_of(const dds::RemoteEndpoint& writer);
  void note_stamp(StandIn& from, WallTime source, WallTime came, MonotonicTime at);
  void tell_skew(const std::string& host);
  void ask_for_time(StandIn& from, MonotonicTime at);
  /// Publishes the clock skews, for log messages about stamps.
  void publish_skews();

  // mirror_misfits.cpp: reports about incompatible remote endpoints
  /// Returns true if the report about an endpoint must wait for the name of its node: no endpoint of this side matches
  /// it, and the wait is limited.
  [[nodiscard]] bool waits_for_name(const dds::RemoteEndpoint& end, const TopicUse& use, const msgs::MessageType& type);
  [[nodiscard]] bool fits(const dds::RemoteEndpoint& end, const msgs::MessageType& type);
  /// Returns the endpoints of this side that have another type.
  [[nodiscard]] std::vector<const EndpointInfo*> those_with_other_types(const dds::RemoteEndpoint& end) const;
  /// Records a mismatch in the graph, once for each pair.
  void note_misfit(const EndpointInfo& ours, const dds::RemoteEndpoint& end, const std::string& type);
  void tell_other_types(const dds::RemoteEndpoint& end);
  /// Reports a remote reader whose QoS a publisher here does not satisfy; nothing else reports it.
  void tell_unserved(const dds::RemoteEndpoint& reader);
  /// Returns the writers of this side from which this reader gets nothing, because it requests more.
  [[nodiscard]] std::vector<const EndpointInfo*> those_that_do_not_serve(const dds::RemoteEndpoint& reader) const;
  /// Adds an endpoint to those that are reported later. Returns the time at which it was added first.
  MonotonicTime wait_in(std::map<dds::Gid, MonotonicTime>& those, const dds::Gid& gid);
  /// Reports the mismatches that are due. Returns when to check again.
  MonotonicTime look_at_misfits();

  // mirror_messages.cpp
  /// Sends the published messages. Returns true if it stopped early so that others get their turn.
  bool send(LocalWriter& end);
  /// Encodes and writes a message. Threads: the one that uses the writer at the moment.
  [[nodiscard]] Written write(LocalWriter& end, const Block& block, std::size_t bytes) const;
  void count_overtaken(LocalWriter& end);
  void write_at_lane(LocalWriter& end, std::size_t bytes);
  /// Handles the result of sending `unsent`. Returns false if a KEEP_ALL writer has no room for it now.
  [[nodiscard]] bool settle(LocalWriter& end, const Written& did);
  /// Returns true if a large message is still being sent, or was returned because there was no room for it.
  [[nodiscard]] bool is_busy(LocalWriter& end);
  MonotonicTime send_held_up();
  void hold_up(const LocalWriter& end, MonotonicTime until);
  enum class Passage : std::uint8_t { Goes, Waits, Dropped };
  /// Applies its export rule to the message to send.
  [[nodiscard]] Passage passage_of(LocalWriter& end, std::size_t bytes);
  /// Delivers the received messages of these readers. Returns true if it stopped early so that others get their turn.
  bool receive(TopicUse& use);
  [[nodiscard]] StandIn* stand_in_of(const dds::Sample& sample);
  void hand_on(const std::vector<LocalReader*>& to, StandIn& from, std::uint64_t sequence);
  void tell_losses(LocalReader& end);
  void send_snapshot();

  Graph& graph;
  const Clock& clock;
  const MirrorOptions options;
  const Logger log{"network"};
  const std::unique_ptr<dds::Participant> participant;
  std::atomic<std::uint32_t> number{0};  // of this link

  std::map<std::uint64_t, std::unique_ptr<LocalWriter>> writers;
  std::map<std::uint64_t, std::unique_ptr<LocalReader>> readers;
  std::map<std::uint64_t, std::unique_ptr<LocalWriter>>
      ending;  // have ended in the graph while a large message is being sent
  std::map<std::string, TopicUse, std::less<>> topics;
  std::map<dds::Gid, Peer> peers;  // outlive the proxies that point to them
  std::map<dds::Gid, StandIn> stand_ins;
  std::map<std::string, ClockSkew, std::less<>> told_skews;  // by host
  Guarded<std::vector<ClockSkew>> host_skews;
  // With the time since when they are known: endpoints to report once the name of their node is known, endpoints with
  // another type, and readers whose QoS a writer of this side does not satisfy.
  std::map<dds::Gid, MonotonicTime> nameless, other_types, unserved;
  std::set<dds::Gid> awaited;                 // endpoints whose wait for the name of their node is over
  MonotonicTime misfits_due = kNeverExpires;  // when to check these
  // Pairs of a remote endpoint and one of this side that are recorded in the graph.
  std::set<std::pair<dds::Gid, std::uint64_t>> misfits;
  std::map<std::uint64_t, dds::Gid> handles;  // Cyclone's numbers of remote writers, which outlive them
  std::set<dds::Gid>
      gone_now;  // writers or whole participants that have ended; removed when their last messages are taken
  std::set<std::string> told;
  std::uint64_t next_stand_in = 0;
  std::set<std::uint64_t> held_up;  // writers with an unsent message
  MonotonicTime retry_at;           // when to send these: DDS does not notify when there is room
  std::set<std::uint64_t> hidden;   // endpoints that no export rule names
  std::set<dds::Gid> manual;        // proxies for writers with manual liveliness
  dds::GraphSnapshot own_nodes;
  std::map<std::string, std::size_t> ends_of_node;
  bool is_snapshot_new = true;
  bool are_types_new = false;  // an endpoint of a topic was added or removed: choose_types()
  Guarded<dds::RemoteGraph> remote;
  Guarded<std::vector<Namesake>> namesakes;
  Noted now;
  std::vector<dds::DiscoveryEvent> found_now;
  std::vector<std::uint64_t> targets;
  std::vector<LocalReader*> same;

  Mutex noting;  // the last lock of all
  std::condition_variable woken;
  Noted noted NACELLE_GUARDED_BY(noting);
  bool sleeping NACELLE_GUARDED_BY(noting) = false;

  Figure encoded{0}, bytes_encoded{0}, overtaken{0}, held_back{0}, refused{0}, received{0}, decoded{0}, broken{0},
      stray{0}, snapshots{0}, problems{0}, taps{0}, writer_count{0}, reader_count{0}, stand_in_count{0},
      hidden_count{0};

  std::unique_ptr<Services> services;  // null: topics only
  SnapshotListener snapshot_listener{*this};
  // The last members except the thread: their callbacks use the members above.
  std::unique_ptr<dds::Writer> snapshot_writer;
  std::unique_ptr<dds::Reader> snapshot_reader;
  std::unique_ptr<dds::Discovery> discovery;
  MirrorLane lane;  // for large messages
  std::thread thread;
};

}  // namespace nacelle
