// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mirror_impl.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/host/service_graph.hpp"
#include "transport_dds/wire/service_call.hpp"

namespace nacelle {

/// The services of a mirror: each server and client of this side with its two endpoints (docs/adr/0013).
///
/// Ownership: the mirror's. Threads: on_*(), note_*(), push() and take() any; the rest the network's own, which does
/// not run during the constructor and the destructor.
struct DdsMirror::Impl::Services final : ServiceListener {
  /// A matched remote endpoint.
  struct Peer {
    std::string id;  // its client_id or service_id; may be empty
    bool understands = true;
  };
  using Peers = std::map<dds::Gid, Peer>;

  /// A server or client of this side.
  struct End : dds::EndpointListener {
    End(Services& owner, ServiceEndInfo of) : services(owner), info(std::move(of)) {}
    void on_status() noexcept override {
      is_status_new = true;
      services.note_ready(*this);
    }
    void on_data() noexcept override { services.note_ready(*this); }
    /// Leaves the network: its callbacks are not called any more. Derived classes call this first in their destructors.
    void close() {
      reader.reset();
      writer.reset();
    }

    Services& services;
    const ServiceEndInfo info;
    // Matched remote endpoints. Of a server: its clients' request writers and reply readers; of a client: its servers'
    // reply writers and request readers.
    Peers writers, readers;
    std::atomic<bool> queued{false}, is_status_new{true};
    std::unique_ptr<dds::Writer> writer;
    std::unique_ptr<dds::Reader> reader;
  };
  /// A server of this side. Its graph's server delivers answers by push().
  struct Server final : End, AnswerTaker {
    Server(Services& owner, ServiceEndInfo of);
    ~Server() override;
    void push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) override;

    struct Asked {
      dds::CallHeader header;
      dds::Gid client;
    };
    /// An answer whose client's reader has not been matched yet.
    struct Held {
      Asked asked;
      std::unique_ptr<msgs::AnyMessage> response;
      MonotonicTime since;
    };
    std::shared_ptr<Guarded<AnswerTaker*>> self;
    std::int64_t last = 0;
    std::map<std::int64_t, Asked> waiting;  // for an answer of the graph's server
    std::deque<Held> held;
  };
  struct Client final : End, RemoteServer {
    using End::End;
    ~Client() override { close(); }
    [[nodiscard]] bool take(Call call) noexcept override;

    struct Sent {
      Asker asker;
      std::set<dds::Gid> servers;  // request readers that received the request and still exist
    };
    std::size_t noted = 0;  // calls that are not sent yet; guarded by Services::noting
    std::map<std::int64_t, Sent> waiting;
    bool is_available = false;
    MonotonicTime settled = kNeverExpires;  // when its server counts as available; kNeverExpires: no server is matched
  };

  Services(DdsMirror::Impl& owner, ServiceGraph& of);
  ~Services() override;

  void on_made(const ServiceEndInfo& end) noexcept override;
  void on_gone(std::uint64_t id) noexcept override;
  void note_ready(End& end) noexcept;

  /// Handles recorded events and due actions.
  void turn();
  /// Returns the latest time of the next turn().
  [[nodiscard]] MonotonicTime due() const;
  /// Threads: any.
  void fill(MirrorStats& out) const;

  // mirror_services.cpp
  template <typename F>
  void note(F change) noexcept;
  void take_made(const ServiceEndInfo& info);
  void take_gone(std::uint64_t id);
  [[nodiscard]] Result<void, Problem> open(End& end);
  void hide(const End& end);
  void look_at(std::uint64_t id);
  [[nodiscard]] Peers peers_of(const End& end, bool are_writers);
  void tell_once(const End& end, const std::string& what, Problem problem);

  // mirror_requests.cpp: from outside to servers of this side
  /// Passes received requests to the server. Returns true if it stopped early so that others get their turn.
  bool receive(Server& server);
  void take_request(Server& server, const dds::Sample& sample);
  void refuse(Server& server, const Server::Asked& asked, const msgs::AnyMessage& response);
  void take_answer(Server& server, std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response);
  /// Sends or drops an answer. Returns false if it must wait for the client's reader.
  [[nodiscard]] bool reply(Server& server, const Server::Held& answer);
  void send(Server& server, const dds::CallHeader& header, const msgs::MessageType& type, const void* response);
  void hold(Server& server, Server::Held answer);
  void reply_to_held();

  // mirror_calls.cpp: from clients of this side to servers outside
  void send(Client& client, Call call);
  bool receive(Client& client);
  void take_reply(Client& client, const dds::Sample& sample);
  /// Updates the availability of a client's servers after its peers have changed.
  void look_for_servers(Client& client);
  void look_at_settling();
  /// Notifies a caller that there will be no answer.
  void fail(const Asker& asker);

  class Questions;  // mirror_clock_questions.hpp

  struct Event {
    bool made;
    ServiceEndInfo info;  // if not made, only the id
  };
  struct Answer {
    std::uint64_t server;
    std::int64_t sequence;
    std::unique_ptr<msgs::AnyMessage> response;
  };
  struct NotedCall {
    std::uint64_t client;
    Call call;
  };
  struct Noted {
    std::vector<Event> events;
    std::vector<Answer> answers;
    std::vector<NotedCall> calls;
    std::vector<std::uint64_t> ready;
  };

  DdsMirror::Impl& mirror;
  ServiceGraph& graph;
  std::map<std::uint64_t, std::unique_ptr<Server>> servers;
  std::map<std::uint64_t, std::unique_ptr<Client>> clients;
  std::set<std::uint64_t> holding;   // servers with held answers
  std::set<std::uint64_t> settling;  // clients whose server has just been matched
  std::uint32_t last_id = 0;         // of clients and servers together, for the user data
  std::int64_t last_sequence = 0;    // of all clients together
  Bytes scratch;
  Noted now;

  Mutex noting;  // the last lock but the mirror's own
  Noted noted NACELLE_GUARDED_BY(noting);

  Figure requests{0}, requests_refused{0}, replies{0}, replies_dropped{0}, calls{0}, answers{0}, calls_failed{0},
      late{0}, server_count{0}, client_count{0}, clock_questions{0}, clock_answers{0};
  std::unique_ptr<Questions> questions;  // the last member: its endpoints' callbacks use the members above
};

}  // namespace nacelle
