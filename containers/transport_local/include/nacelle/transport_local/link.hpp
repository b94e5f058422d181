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
  std::string peer = "the other process";  ///< Name of the peer, for display.
  /// Makes stand-ins for all endpoints of the peer, so that reports and checks include them. Otherwise only for those
  /// with a counterpart on this side.
  bool mirror_all = false;
  /// The graph whose servers and clients are announced to the peer, which must have a `service_hub`. Must outlive the
  /// link. Null: none are announced.
  ServiceGraph* services = nullptr;
  std::string private_node;  ///< Full name of the node whose servers and clients are not announced.
  /// Receives stand-ins for the peer's servers and clients. Must outlive the link. Null: they are ignored.
  ServiceHub* service_hub = nullptr;
  /// Finds a type by name if no endpoint here uses it; returns null if there is none. Called on the link's thread.
  /// Empty: only types of local endpoints are known.
  std::function<const msgs::MessageType*(const std::string&)> find_type;
  Carrier* carrier = nullptr;  ///< Must outlive the link. Null: all messages use the socket.
  /// Receives the bytes that the peer passed to send_note(). Called on the link's thread; must not destroy the link.
  std::function<void(std::string note)> on_note;
  /// Called once, when the link ends: the peer is gone, or breaks the protocol. On the link's thread; must not destroy
  /// the link.
  std::function<void(const Problem&)> on_end;
};

struct LinkStats {
  std::uint64_t sent = 0, received = 0;              ///< Messages, calls and answers over the socket.
  std::uint64_t bytes_sent = 0, bytes_received = 0;  ///< All bytes over the socket.
  std::uint64_t carried = 0;                         ///< Messages that the carrier accepted.
  std::uint64_t dropped = 0;                         ///< Received without a destination, or without a free envelope.
  std::uint64_t broken = 0;                          ///< Received, but not messages of their type.
};

/// Joins the graphs of two processes over a connected stream socket (docs/adr/0007).
///
/// Each side announces its endpoints. For a reader of the peer the link makes a stand-in with that reader's QoS in its
/// own graph, and sends the messages that this stand-in receives. For a writer of the peer it makes a stand-in that
/// publishes the received messages. So QoS is checked by the same code as within a process. The socket never blocks a
/// publisher: a stand-in's queue overwrites or refuses messages as its reader's queue would.
///
/// For a reliable KEEP_ALL reader, at most max_samples messages of the writers behind one link are outstanding. Beyond
/// that publish() answers WouldBlock until the reader has taken one. If writers of several processes fill its queue, a
/// message that finds no room is counted as `full` by the reader.
///
/// Services work in both directions: `service_hub` gets stand-ins for the servers and clients of the peer's `services`
/// (docs/adr/0032). Every call ends with an answer or with a notice that there will be none, also when the link ends.
/// Limits: 256 unanswered calls of one server or client over the link, 16 MiB for a request or response, and 64 MiB
/// that wait to be sent. A request beyond a limit is refused; a response beyond a limit is replaced by the notice.
/// Frame claims and shared objects are not transferred.
/// Threads: one of its own after start(). All members from any thread, but use either start() or pump().
/// Errors: a peer that breaks the protocol ends the link. If the type of a stream is unknown here, or has another
///         definition here, the stream is not linked, and an error in the log names it.
class Link final {
 public:
  /// Takes ownership of the socket. `graph` and `clock` must outlive the link.
  Link(Graph& graph, const Clock& clock, int socket, LinkOptions options);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  /// Removes the stand-ins and closes the socket, which ends the peer's link.
  ~Link();

  /// Starts the link's own thread.
  void start();
  /// Does all work that is possible without waiting. Returns true if there was any. For callers that did not start().
  bool pump();
  /// Sends bytes to the peer's on_note. Endpoints that this thread has made before the call are announced before them.
  void send_note(std::string note);
  [[nodiscard]] bool has_ended() const;
  [[nodiscard]] LinkStats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle
