// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/host/service_graph.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/runtime/introspection.hpp"

namespace nacelle::remote {

/// A pending call over the network.
/// Threads: as ServiceCall; push() on the network's thread.
class RemoteCall final : public runtime::ServiceCall, private AnswerTaker {
 public:
  /// `on_answer` is called once, on the network's thread with locks held. It may only record the event.
  explicit RemoteCall(std::function<void()> on_answer)
      : on_answer_(std::move(on_answer)),
        self_(std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this))) {}
  RemoteCall(const RemoteCall&) = delete;
  RemoteCall& operator=(const RemoteCall&) = delete;
  ~RemoteCall() override { *self_->lock() = nullptr; }

  [[nodiscard]] Asker asker() const { return {self_, 0}; }
  [[nodiscard]] State state() const override { return answer_.lock()->state; }
  [[nodiscard]] const void* response() const override;

 private:
  struct Answer {
    State state = State::Waiting;
    std::unique_ptr<msgs::AnyMessage> response;
  };
  void push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) override;

  const std::function<void()> on_answer_;
  const std::shared_ptr<Guarded<AnswerTaker*>> self_;
  Guarded<Answer> answer_;
};

/// The service graph of a process that offers no services and calls remote ones.
/// Threads: any.
class ServiceClients final : public ServiceGraph {
 public:
  /// Takes the name of the calling node. `on_change` is called, with locks held, when a client's service has
  /// appeared or disappeared.
  ServiceClients(std::string node, std::function<void()> on_change)
      : node_(std::move(node)), on_change_(std::move(on_change)) {}

  /// Returns the client of this service, and creates it if there is none.
  [[nodiscard]] std::uint64_t client_of(const std::string& service, const msgs::ServiceType& type);
  [[nodiscard]] bool is_ready(std::uint64_t client) const;
  /// Sends a call. Returns false if the service is not ready, or if too many calls are pending.
  [[nodiscard]] bool call(std::uint64_t client, Call call);

  // ServiceGraph
  void join(ServiceListener& listener) override;
  void leave(ServiceListener& listener) override;
  void set_remote(std::uint64_t client, RemoteServer* server) override;
  [[nodiscard]] Sent send(std::uint64_t, Call) override { return Sent::Gone; }  // this process has no servers

 private:
  struct Client {
    ServiceEndInfo info;
    RemoteServer* server = nullptr;
  };
  struct Ends {
    std::map<std::uint64_t, Client> clients;
    std::vector<ServiceListener*> listeners;
  };
  const std::string node_;
  const std::function<void()> on_change_;
  Guarded<Ends> ends_;
};

}  // namespace nacelle::remote
