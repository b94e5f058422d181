// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/host/graph.hpp"
#include "nacelle/host/service_graph.hpp"
#include "nacelle/transport_local/carrier.hpp"

namespace nacelle {

struct LinkOptions {
  std::string peer = "the other process";  ///< For people.
  /// Stand-ins for everything that the peer has, so that reports and checks see it; else only where this side has a use for them.
  bool mirror_all = false;
  /// Servers and clients of this graph are announced to the peer, which must have a `service_hub`. Must outlive the link. Null: none.
  ServiceGraph* services = nullptr;
  std::string private_node;  ///< Full name of the node whose servers and clients are not announced.
  /// Gets stand-ins for the peer's servers and clients. Must outlive the link. Null: the peer's are ignored.
  ServiceHub* service_hub = nullptr;
  /// Finds a type by name that no endpoint here has; null: there are no others. Called on the link's thread.
  std::function<const msgs::MessageType*(const std::string&)> find_type;
  Carrier* carrier = nullptr;  ///< Must outlive the link. Null: everything goes over the socket.
  /// What the peer's send_note() sent. On the link's thread; must not destroy the link.
  std::function<void(std::string note)> on_note;
  /// The link has ended, once: the peer is gone, or cannot be understood. On the link's thread; must not destroy the link.
  std::function<void(const Problem&)> on_end;
};

struct LinkStats {
  std::uint64_t sent = 0, received = 0;              ///< Messages, calls and answers over the socket.
  std::uint64_t bytes_sent = 0, bytes_received = 0;  ///< Everything over the socket.
  std::uint64_t carried = 0;                         ///< Messages given to the carrier.
  std::uint64_t dropped = 0;  ///< Had no destination: their reader, writer, server or caller went meanwhile.
  std::uint64_t broken = 0;   ///< Were no messages of their type.
};

/// Joins the graphs of two processes over a connected stream socket (docs/adr/0007).
///
/// Each side announces its endpoints. For a reader of the peer the link makes a stand-in with that reader's QoS in its own graph and
/// sends what arrives there; for a writer of the peer it makes one that hands on what comes. So the same code judges QoS on both
/// sides as within a process. The socket never blocks a publisher: a stand-in's queue overwrites or refuses as its reader's would.
///
/// Holds: a reliable KEEP_ALL reader has at most max_samples messages of the writers behind one link outstanding; publish()
/// answers WouldBlock from then on until it has taken one. Messages of writers in several processes may meet in its queue: those that
/// find no room there are counted as `full` by the reader.
///
/// Services cross in both directions: `service_hub` gets stand-ins for the servers and clients of the peer's `services`
/// (docs/adr/0032). Every call gets an answer or the notice that there will be none, also when the link ends. A server or client
/// has at most 256 calls over the link that are not answered; a request or response is at most 16 MiB long, and at most 64 MiB
/// wait to be sent. What is beyond is refused.
/// Not over the link: frame claims, shared objects.
/// Threads: one of its own after start(); all members from any thread, pump() and start() exclude each other.
/// Errors: a peer that breaks the protocol ends the link; a stream whose type is unknown here, or another one of that name,
///         is refused by name in the log.
class Link final {
 public:
  /// Takes over the socket. `graph` and `clock` must outlive it.
  Link(Graph& graph, const Clock& clock, int socket, LinkOptions options);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  /// The stand-ins go; the peer sees the end of the socket.
  ~Link();

  /// Lets a thread of the link's own do the work.
  void start();
  /// Does what can be done without waiting; true if there was something. For those who have no thread for it.
  bool pump();
  /// Sends bytes to the peer's on_note. What this thread has made in the graph before is announced before.
  void send_note(std::string note);
  [[nodiscard]] bool has_ended() const;
  [[nodiscard]] LinkStats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle
