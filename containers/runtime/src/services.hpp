// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/host/node_host.hpp"
#include "nacelle/host/service_graph.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/runtime/executor.hpp"
#include "nacelle/runtime/introspection.hpp"

namespace nacelle::runtime {

using msgs::AnyMessage;

class ServerPort;

/// Returns "std_srvs/srv/SetBool" from its request's type.
[[nodiscard]] std::string service_type_of(const msgs::MessageType& request);

/// The servers and clients of the container's services. Threads: any.
class ServiceDirectory final : public ServiceHub {
 public:
  void add(const std::string& name, const std::string& node, ServerPort& server);
  /// Removes a server. Without effect for an unknown server.
  void remove(const std::string& name, ServerPort& server);
  /// Reports to listeners that the node of this server has become active or inactive. Without effect for an unknown
  /// server.
  void note_gate(const std::string& name, const ServerPort& server);
  /// Registers a client and returns its id. An unregistered client can call too, but only servers of this process and
  /// stand-ins.
  [[nodiscard]] std::uint64_t add_client(ServiceEndInfo client);
  void remove_client(std::uint64_t client);
  /// Passes the call to an open server of this process or stand-in; if there is none, to the client's remote server.
  /// Returns false if that does not exist either, or the server takes no more calls.
  [[nodiscard]] bool send(const std::string& name, const msgs::MessageType& request, Call call,
                          std::uint64_t client = 0);
  [[nodiscard]] bool is_ready(const std::string& name, const msgs::MessageType& request,
                              std::uint64_t client = 0) const;
  /// Returns whether a server of this process or a stand-in of that name, with any type, is open.
  [[nodiscard]] bool is_ready(const std::string& name) const;
  void report_stand_ins(std::vector<ServiceReport>& out) const;
  /// Returns why a call would not be delivered: no such service, another type, an inactive server.
  [[nodiscard]] Problem why_not(const std::string& name, const msgs::MessageType& request) const;

  // ServiceGraph
  void join(ServiceListener& listener) override;
  void leave(ServiceListener& listener) override;
  void set_remote(std::uint64_t client, RemoteServer* server) override;
  [[nodiscard]] Sent send(std::uint64_t server, Call call) override;
  // ServiceHub
  [[nodiscard]] std::uint64_t add_stand_in(ServiceEndInfo end, RemoteServer* server) override;
  void open_stand_in(std::uint64_t server, bool open) override;
  void remove_stand_in(std::uint64_t id) override;
  [[nodiscard]] bool call(std::uint64_t client, Call call) override;

 private:
  /// A server of this process has a `port`; a stand-in has a `remote`, which takes its calls.
  struct Server {
    [[nodiscard]] bool is_open() const;
    [[nodiscard]] bool take(Call call) const;
    ServiceEndInfo info;  // is_open: as last reported
    ServerPort* port = nullptr;
    RemoteServer* remote = nullptr;
  };
  struct Client {
    ServiceEndInfo info;
    RemoteServer* remote = nullptr;
    bool is_stand_in = false;
    bool is_ready = false;  // of a stand-in: as last reported
  };
  struct Ends {
    std::multimap<std::string, Server> servers;  // by name
    std::map<std::uint64_t, Client> clients;
    std::vector<ServiceListener*> listeners;
    std::uint64_t last_id = 0;
  };
  using Servers = std::multimap<std::string, Server>;
  static void add(Ends& ends, Server server);
  static void remove(Ends& ends, Servers::iterator server);
  static void tell_gate(Ends& ends, Server& server);
  /// Notifies the listeners about stand-in clients for which the readiness of this service has changed.
  static void tell_ready(Ends& ends, const std::string& name);
  [[nodiscard]] static bool is_offered(const Ends& ends, const std::string& name, const msgs::MessageType& request);
  [[nodiscard]] static Servers::iterator find_server(Ends& ends, std::uint64_t id);
  [[nodiscard]] static bool send(const Ends& ends, const std::string& name, const msgs::MessageType& request, Call call,
                                 std::uint64_t client);
  Guarded<Ends> ends_;
};

/// A service's queue of calls.
class ServerPort final : public Executable {
 public:
  ServerPort(CallbackGroup& group, const msgs::MessageType& request, const msgs::MessageType& response,
             ServiceCallback callback, const std::atomic<bool>& open, const Clock& clock, bool measured)
      : Executable(group), request_(request), response_(response), callback_(callback), open_(open), clock_(clock) {
    if (!measured) return;
    stats_ = std::make_unique<CallbackStats>();
    keep_stats_in(*stats_);
  }
  void execute(MonotonicTime now) override;
  [[nodiscard]] bool wants_again() const override { return waiting_.load(std::memory_order_acquire) != 0; }
  void push(Call call);
  /// Answers a call that the callback left unanswered: see ServiceHandle.
  bool send_response(std::int64_t call, void* response);
  /// Notifies every waiting client that there will be no answer, including those whose calls are running or were left
  /// unanswered.
  void refuse_all();
  [[nodiscard]] bool is_open() const { return open_.load(std::memory_order_acquire); }
  [[nodiscard]] const msgs::MessageType& request_type() const { return request_; }
  /// Returns null if the service is not measured, which saves 4 KiB.
  [[nodiscard]] const CallbackStats* stats() const { return stats_.get(); }
  [[nodiscard]] const msgs::MessageType& response_type() const { return response_; }

 private:
  struct Waiting {
    Call call;
    MonotonicTime since;
  };
  const msgs::MessageType& request_;
  const msgs::MessageType& response_;
  const ServiceCallback callback_;
  const std::atomic<bool>& open_;  // the node's lifecycle gate
  const Clock& clock_;
  struct Open {  // calls whose callback runs, or has postponed the answer
    std::int64_t last = 0;
    std::map<std::int64_t, Asker> calls;  // the thread that removes an entry answers it
  };
  bool answer_open(std::int64_t call, std::unique_ptr<AnyMessage> response);
  Guarded<std::list<Waiting>> calls_;
  Guarded<Open> open_calls_;
  std::atomic<std::size_t> waiting_{0};
  std::unique_ptr<CallbackStats> stats_;  // its latency is guarded by the lock of calls_
};

/// A client's queue of responses.
class ClientPort final : public Executable, private AnswerTaker {
 public:
  ClientPort(CallbackGroup& group, ResponseCallback callback, const Clock& clock)
      : Executable(group),
        callback_(callback),
        self_(std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this))),
        clock_(clock) {
    keep_stats_in(stats_);
  }
  void execute(MonotonicTime now) override;
  [[nodiscard]] bool wants_again() const override { return waiting_.load(std::memory_order_acquire) != 0; }
  /// Detaches the port: after this no server uses it any more.
  void detach() { *self_->lock() = nullptr; }
  [[nodiscard]] std::weak_ptr<Guarded<AnswerTaker*>> handle() const { return self_; }
  [[nodiscard]] const CallbackStats& stats() const { return stats_; }

 private:
  void push(std::int64_t sequence, std::unique_ptr<AnyMessage> response) override;
  struct Answer {
    std::int64_t sequence;
    std::unique_ptr<AnyMessage> response;  // null: there will be none
    MonotonicTime since;
  };
  const ResponseCallback callback_;
  const std::shared_ptr<Guarded<AnswerTaker*>> self_;
  const Clock& clock_;
  Guarded<std::deque<Answer>> answers_;
  std::atomic<std::size_t> waiting_{0};
  CallbackStats stats_;  // its latency is guarded by the lock of answers_
};

}  // namespace nacelle::runtime
