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

/// Who waits for an answer. The pointer is null once nobody does any more.
struct Asker {
  std::weak_ptr<Guarded<AnswerTaker*>> client;
  std::int64_t sequence = 0;

  /// Returns false if nobody waits any more. Null: there will be no response.
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
};

/// Told which servers and clients come and go. Threads: any, with the graph's lock held: only note it and return.
class ServiceListener {
 public:
  virtual ~ServiceListener() = default;
  virtual void on_made(const ServiceEndInfo& end) noexcept = 0;
  virtual void on_gone(std::uint64_t id) noexcept = 0;
};

/// Servers of other processes, for one client of this one. Threads: any, with the graph's lock held: only note it and return.
class RemoteServer {
 public:
  virtual ~RemoteServer() = default;
  /// Its asker is told in the end, of a response or that there will be none. Returns false if too many wait to be sent: then
  /// nothing is.
  [[nodiscard]] virtual bool take(Call call) noexcept = 0;
};

/// Who calls whom in this process, for links to others (docs/adr/0013). What a call within the process costs does not depend on
/// who has joined. Threads: any.
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
    Closed,  ///< Its node is not active: it answers nobody.
    Gone,
  };
  /// Hands a call from outside to this server. Preconditions: the request is of its type.
  [[nodiscard]] virtual Sent send(std::uint64_t server, Call call) = 0;
};

}  // namespace nacelle
