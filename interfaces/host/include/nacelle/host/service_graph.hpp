// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "nacelle/base/guarded.hpp"
#include "nacelle/msgs/any_message.hpp"

namespace nacelle {

/// Takes the answers of calls. Threads: the server's, with locks held: only note it and return.
class AnswerTaker {
 public:
  virtual ~AnswerTaker() = default;
  /// A null response: there will be none.
  virtual void push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) = 0;
};

/// The caller that waits for a response. The pointer expires when it stops waiting.
struct Asker {
  std::weak_ptr<Guarded<AnswerTaker*>> client;
  std::int64_t sequence = 0;

  /// Returns false if the caller no longer waits. A null response means that none will come.
  bool answer(std::unique_ptr<msgs::AnyMessage> response) const {
    const auto waits = client.lock();
    if (!waits) return false;
    auto taker = waits->lock();  // held while pushing, so that the client cannot go meanwhile
    if (*taker == nullptr) return false;
    (*taker)->push(sequence, std::move(response));
    return true;
  }
};

/// One request on its way; nothing in it belongs to a component.
struct Call {
  Asker asker;
  msgs::AnyMessage request;
};

/// A server or client of this process, as a link to other processes announces it.
struct ServiceEndInfo {
  std::uint64_t id = 0;  ///< Never used again in this process.
  bool is_server = false;
  std::string name;  ///< Fully qualified and remapped, as that of the node.
  std::string node;
  const msgs::MessageType* request = nullptr;  ///< These stay for the life of the process, also when the end has gone.
  const msgs::MessageType* response = nullptr;
  bool is_open = true;  ///< Of a server: its node is active.
};

/// Told which servers and clients come and go. Threads: any, with the graph's lock held: only note it and return.
class ServiceListener {
 public:
  virtual ~ServiceListener() = default;
  virtual void on_made(const ServiceEndInfo& end) noexcept = 0;
  virtual void on_gone(std::uint64_t id) noexcept = 0;
  /// A server's node has become active or inactive, or the service of a stand-in client has become ready or not.
  virtual void on_ready(std::uint64_t /*id*/, bool /*ready*/) noexcept {}
};

/// Servers of other processes, for one client of this one. Threads: any, with the graph's lock held: only note it and return.
class RemoteServer {
 public:
  virtual ~RemoteServer() = default;
  /// Takes a call. Its caller gets a response, or the notice that none will come. Returns false, and takes nothing, if too many
  /// calls wait to be sent.
  [[nodiscard]] virtual bool take(Call call) noexcept = 0;
};

/// The service servers and clients of this process, for links to other processes (docs/adr/0013). Links do not change the cost of
/// a call within the process. Threads: any.
class ServiceGraph {
 public:
  virtual ~ServiceGraph() = default;
  /// Tells the listener of all that is there, and from then on of each change.
  virtual void join(ServiceListener& listener) = 0;
  /// After its return the listener is not called any more.
  virtual void leave(ServiceListener& listener) = 0;
  /// From now on calls of this client go there while no server of this process is open, and its service is ready. Null: no more;
  /// after the return no take() runs. Without effect on a client that has gone.
  virtual void set_remote(std::uint64_t client, RemoteServer* server) = 0;

  enum class Sent : std::uint8_t {
    Yes,
    Closed,  ///< Its node is not active: no response will come.
    Full,    ///< A stand-in takes no more calls.
    Gone,
  };
  /// Hands a call from outside to this server. Preconditions: the request is of its type.
  [[nodiscard]] virtual Sent send(std::uint64_t server, Call call) = 0;
};

/// A graph with stand-ins for servers and clients of another process (docs/adr/0032). Listeners and callers see a stand-in as they
/// see an end of this process. Threads: any.
class ServiceHub : public ServiceGraph {
 public:
  /// Adds a stand-in and returns its id. `server` takes the calls of a server's stand-in; it is null for a client's.
  [[nodiscard]] virtual std::uint64_t add_stand_in(ServiceEndInfo end, RemoteServer* server) = 0;
  /// Opens or closes the stand-in of a server.
  virtual void open_stand_in(std::uint64_t server, bool open) = 0;
  /// Removes a stand-in. After the return no take() of its server runs.
  virtual void remove_stand_in(std::uint64_t id) = 0;
  /// Sends a call in the name of a client's stand-in. Returns false if no server takes it.
  [[nodiscard]] virtual bool call(std::uint64_t client, Call call) = 0;
};

}  // namespace nacelle
