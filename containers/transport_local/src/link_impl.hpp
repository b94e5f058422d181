// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/transport_local/link.hpp"
#include "transport_local/wire/frame.hpp"

namespace nacelle {

namespace wire = transport_local;

/// A counter with one writing thread, read by others.
using Figure = std::atomic<std::uint64_t>;

/// The data of a link. Threads: on_*() any; the rest under `pumping`, on the thread that runs or calls pump().
struct Link::Impl final : GraphListener {
  /// The messages that wait to be sent to a reader of the peer. Threads: on_*() any.
  struct Outbox final : ReadyListener, StatusListener {
    Outbox(Impl& owner, std::uint64_t reader_id) : link(owner), id(reader_id) {}
    ~Outbox() override {
      if (head != nullptr) drop_reference(*head);
    }
    void on_ready() noexcept override { link.note_ready(*this); }
    void on_status() noexcept override { link.note_ready(*this); }

    Impl& link;
    const std::uint64_t id;
    std::unique_ptr<ProxyReader> reader;
    bool keeps_all = false;
    std::atomic<bool> queued{false};
    Block* head = nullptr;  // taken from the queue, but not sent yet
    ReaderCounters told;    // the losses that the peer has been sent
  };
  /// Publishes the messages that the carrier receives from a writer of the peer. Threads: the carrier's and the link's.
  struct Arrival final : CarrierSink {
    Arrival(Impl& owner, ProxyWriter& to, EndpointSpec of) : link(owner), writer(to), spec(std::move(of)) {}
    Block* borrow() noexcept override;
    void deliver(Block& block, const MessageInfo& info) noexcept override;
    void note_broken(const char* why) noexcept override;

    Impl& link;
    ProxyWriter& writer;
    const EndpointSpec spec;
    Mutex relaying;  // the stand-in belongs to one thread at a time
    bool told_broken = false;
    std::unique_ptr<CarrierReader> reader;  // the last member: its calls end first
  };
  /// An endpoint of the peer. It has at most one stand-in: `writer` or `outbox`.
  struct Remote {
    EndpointInfo info;
    std::string type, hash;
    bool refused = false, told_broken = false;
    std::unique_ptr<ProxyWriter> writer;
    std::unique_ptr<Outbox> outbox;
    // Of a KEEP_ALL reader: messages sent, acknowledged, and not acknowledged yet but sent by an earlier stand-in. All
    // count over all its stand-ins, because the peer's acknowledgements do.
    std::uint64_t sent = 0, taken = 0, not_ours = 0;
    // Of a writer: the receiving end of its carrier. Destroyed before the stand-in, which it calls.
    std::unique_ptr<Arrival> arrival;
  };
  /// The route of a local writer's stream, and its change to the carrier.
  struct Departure {
    enum class Step : std::uint8_t {
      Opening,  ///< Uses the socket; the peer has been asked to make its end of the carrier.
      Offered,  ///< Paused until the peer has delivered all messages that were sent over the socket.
      Carried,  ///< Uses the carrier.
      Closed,   ///< Uses the socket permanently.
    } step = Step::Opening;
    std::unique_ptr<CarrierWriter> writer;
    std::uint64_t told_copied = 0;  ///< Copied bytes that have been reported to the stream.
  };
  /// Lends the carrier's memory to messages that are borrowed here. A carrier's end is called under the lock, so that
  /// it is not destroyed meanwhile.
  struct Lender final : BufferLender {
    void prepare(std::uint64_t writer, Block& block) noexcept override {
      const LockGuard lock(mutex);
      if (const auto found = carried.find(writer); found != carried.end()) found->second->prepare(block);
    }
    void set(std::uint64_t writer, CarrierWriter* end) {
      const LockGuard lock(mutex);
      if (end != nullptr) {
        carried[writer] = end;
      } else {
        carried.erase(writer);
      }
    }
    Mutex mutex;
    std::map<std::uint64_t, CarrierWriter*> carried NACELLE_GUARDED_BY(mutex);
  };
  struct Event {
    enum class Kind : std::uint8_t { Made, Gone, Gate, Life } kind;
    EndpointInfo info;  // for Made; else only the id and `open`
  };
  struct Left {
    std::uint64_t count = 0;
    bool dirty = false;
  };
  struct TopicUse {
    std::size_t local_writers = 0, local_readers = 0;
    std::vector<std::uint64_t> remotes;
  };

  struct Services;  // link_services.hpp

  Impl(Graph& graph, const Clock& clock, int socket, LinkOptions options);
  ~Impl() override;

  // GraphListener
  void on_made(const EndpointInfo& endpoint) noexcept override;
  void on_gone(std::uint64_t id) noexcept override;
  void on_gate(std::uint64_t reader, bool open) noexcept override;
  void on_life(std::uint64_t writer) noexcept override;
  void on_left(std::uint64_t reader) noexcept override;
  void note(Event happened) noexcept;
  void note_ready(Outbox& outbox) noexcept;
  void wake() noexcept;

  // link.cpp: the socket and the thread
  void run();
  bool pump(bool readable);
  bool read_socket() NACELLE_REQUIRES(pumping);
  bool flush() NACELLE_REQUIRES(pumping);
  void end(const Problem& problem) NACELLE_REQUIRES(pumping);
  [[nodiscard]] bool handle(const wire::LinkFrame& frame) NACELLE_REQUIRES(pumping);
  [[nodiscard]] bool is_full() const NACELLE_REQUIRES(pumping) { return out.size() - out_sent > kHighWater; }

  // link_graph.cpp: the endpoints of both sides
  bool take_events() NACELLE_REQUIRES(pumping);
  void take_made(const EndpointInfo& endpoint) NACELLE_REQUIRES(pumping);
  void take_gone(std::uint64_t id) NACELLE_REQUIRES(pumping);
  [[nodiscard]] bool handle_endpoint(const wire::LinkFrame& frame) NACELLE_REQUIRES(pumping);
  void handle_gone(std::uint64_t id) NACELLE_REQUIRES(pumping);
  void handle_gate(std::uint64_t id, bool open) NACELLE_REQUIRES(pumping);
  void reconcile(const std::string& topic) NACELLE_REQUIRES(pumping);
  void forget_if_unused(const std::string& topic) NACELLE_REQUIRES(pumping);
  void make_stand_in(Remote& remote) NACELLE_REQUIRES(pumping);
  void drop_stand_in(Remote& remote) NACELLE_REQUIRES(pumping);
  [[nodiscard]] const msgs::MessageType* type_for(Remote& remote) NACELLE_REQUIRES(pumping);
  [[nodiscard]] const msgs::MessageType* find_type(const std::string& name) const NACELLE_REQUIRES(pumping);
  void refuse(Remote& remote, const std::string& why, const std::string& way_out) NACELLE_REQUIRES(pumping);

  // link_messages.cpp: messages over the socket, their acknowledgements and losses
  bool send_ready() NACELLE_REQUIRES(pumping);
  void send_topic(const TopicUse& topic) NACELLE_REQUIRES(pumping);
  void fetch_head(Outbox& outbox) NACELLE_REQUIRES(pumping);
  void send_message(Block& block, const msgs::MessageType& type, const std::vector<Outbox*>& to)
      NACELLE_REQUIRES(pumping);
  bool tell_losses(Outbox& outbox) NACELLE_REQUIRES(pumping);
  bool tell_taken() NACELLE_REQUIRES(pumping);
  [[nodiscard]] bool handle_data(ByteView payload) NACELLE_REQUIRES(pumping);
  [[nodiscard]] bool handle_taken(ByteView payload) NACELLE_REQUIRES(pumping);
  void handle_lost(const wire::LostFrame& lost) NACELLE_REQUIRES(pumping);

  // link_carrier.cpp
  [[nodiscard]] bool may_send(const Block& block, const TopicUse& topic) NACELLE_REQUIRES(pumping);
  [[nodiscard]] bool send_by_carrier(Block& block, const Outbox& outbox) NACELLE_REQUIRES(pumping);
  void socket_used(std::uint64_t writer) NACELLE_REQUIRES(pumping);
  void close_departure(std::uint64_t writer, const std::string& why) NACELLE_REQUIRES(pumping);
  [[nodiscard]] bool handle_carry(ByteView payload) NACELLE_REQUIRES(pumping);
  void open_arrival(Remote& remote) NACELLE_REQUIRES(pumping);
  bool drain_carrier();
  [[nodiscard]] static CarriedStream carried_stream(std::uint64_t writer, const EndpointSpec& spec,
                                                    std::uint64_t sender);

  static constexpr std::size_t kHighWater = std::size_t{256} << 10U;

  Graph& graph;
  const Clock& clock;
  const int socket;
  const LinkOptions options;
  const Logger log{"link"};
  const int event;  // eventfd
  const std::uint64_t token;
  std::atomic<std::uint32_t> number{0};
  std::thread thread;
  std::atomic<bool> stopping{false}, ended{false}, signalled{false};

  mutable Mutex pumping;  // never taken with a lock of the graph held
  wire::LinkFrameReader in NACELLE_GUARDED_BY(pumping);
  Bytes out NACELLE_GUARDED_BY(pumping);
  std::size_t out_sent NACELLE_GUARDED_BY(pumping) = 0;
  std::map<std::uint64_t, EndpointInfo> local NACELLE_GUARDED_BY(pumping);
  std::map<std::uint64_t, Remote> remotes NACELLE_GUARDED_BY(pumping);
  std::map<std::string, TopicUse> topics NACELLE_GUARDED_BY(pumping);
  std::map<std::uint64_t, Departure> departures NACELLE_GUARDED_BY(pumping);  // of local writers
  const std::shared_ptr<Lender> lender = std::make_shared<Lender>();
  bool held_back NACELLE_GUARDED_BY(pumping) = false;  // a message is ready, and the socket was full
  std::uint64_t peer_token NACELLE_GUARDED_BY(pumping) = 0;
  bool carries NACELLE_GUARDED_BY(pumping) = false;  // both sides have the same carrier
  std::map<std::string, const msgs::MessageType*> types NACELLE_GUARDED_BY(pumping);  // of local endpoints
  std::vector<std::uint64_t> ready_now NACELLE_GUARDED_BY(pumping), again NACELLE_GUARDED_BY(pumping),
      targets NACELLE_GUARDED_BY(pumping);
  std::vector<Outbox*> outboxes NACELLE_GUARDED_BY(pumping), same NACELLE_GUARDED_BY(pumping);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> taken_now NACELLE_GUARDED_BY(pumping);
  std::vector<Event> events_now NACELLE_GUARDED_BY(pumping);
  std::vector<std::string> notes_now NACELLE_GUARDED_BY(pumping);

  Mutex noting;  // the last lock of all
  std::vector<Event> events NACELLE_GUARDED_BY(noting);
  std::vector<std::string> notes NACELLE_GUARDED_BY(noting);
  std::vector<std::uint64_t> ready NACELLE_GUARDED_BY(noting);
  std::map<std::uint64_t, Left> left NACELLE_GUARDED_BY(noting);

  const std::unique_ptr<Services> services;

  Figure sent{0}, received{0}, bytes_sent{0}, bytes_received{0}, carried{0}, arrived{0}, dropped{0}, broken{0};
};

}  // namespace nacelle
