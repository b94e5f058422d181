// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>

#include "link_impl.hpp"

namespace nacelle {

/// The services of a link (docs/adr/0032). On the side with `options.services`, the leaf, it announces servers and clients; on the
/// side with `options.service_hub` it makes stand-ins for them. Each side gives numbers to the calls that it sends.
/// Threads: on_*(), push() and Exit::take() any, with locks of the graph held; the rest under Link::Impl::pumping.
struct Link::Impl::Services final : ServiceListener, private AnswerTaker {
  /// Takes calls that go to the peer: of a stand-in server on the hub, of a client on the leaf.
  struct Exit final : RemoteServer {
    Exit(Services& owner, std::uint64_t id, const msgs::MessageType& response)
        : services(owner), end(id), response_type(response) {}
    [[nodiscard]] bool take(Call call) noexcept override;
    void assume_noting() const NACELLE_ASSERTS_HELD(services.noting_) {}  // the owner holds it by another name

    Services& services;
    const std::uint64_t end;  // as the leaf has announced it
    const msgs::MessageType& response_type;
    // With those that wait to be sent.
    std::size_t unanswered NACELLE_GUARDED_BY(services.noting_) = 0;
  };
  /// A server or client: on the leaf one of its graph, on the hub one of the peer's.
  struct End {
    ServiceEndInfo info;
    std::uint64_t stand_in = 0;  // on the hub; 0: there is none
    std::unique_ptr<Exit> exit;  // of a server on the hub, of a client on the leaf
    std::size_t unanswered = 0;  // calls of the peer
  };
  struct Event {
    enum class Kind : std::uint8_t { Made, Gone, Ready } kind;
    ServiceEndInfo info;  // of Made; else the id and is_open
  };
  struct NotedCall {
    std::uint64_t end;
    Call call;
    std::size_t bytes;
  };
  struct NotedAnswer {
    std::int64_t number;  // as this side has counted the peer's calls
    std::unique_ptr<msgs::AnyMessage> response;
    std::size_t bytes;
  };
  /// A call of this side that the peer has not answered.
  struct Sent {
    std::uint64_t end;
    Asker asker;
    const msgs::MessageType* response_type;
  };
  /// A call of the peer that this side has not answered.
  struct Taken {
    std::uint64_t number;  // as the peer counts
    std::uint64_t end;
  };

  explicit Services(Impl& owner)
      : link_(owner),
        leaf_(owner.options.services),
        hub_(owner.options.service_hub),
        self_(std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this))) {}

  void join();
  /// Removes the stand-ins, and tells every caller that waits that there will be no answer.
  void end();

  // ServiceListener
  void on_made(const ServiceEndInfo& end) noexcept override;
  void on_gone(std::uint64_t id) noexcept override;
  void on_ready(std::uint64_t id, bool is_ready) noexcept override;

  /// Announces what has changed. Returns true if there was something.
  bool take_events();
  /// Sends what waits, as long as the socket has room. Returns true if there was something.
  bool send();
  [[nodiscard]] bool is_held_back() const {
    assume_pumping();
    return held_back_;
  }
  /// Returns false for a frame that breaks the protocol.
  [[nodiscard]] bool handle(const wire::LinkFrame& frame);

 private:
  /// Every caller of the members above, whose lock it is by another name, holds it.
  void assume_pumping() const NACELLE_ASSERTS_HELD(link_.pumping) {}
  void push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) override;
  void note(Event change) noexcept;
  void take_event(const Event& change) NACELLE_REQUIRES(link_.pumping);
  void send_call(NotedCall call) NACELLE_REQUIRES(link_.pumping);
  void send_answer(const NotedAnswer& answer) NACELLE_REQUIRES(link_.pumping);
  [[nodiscard]] bool handle_service(ByteView payload) NACELLE_REQUIRES(link_.pumping);
  void handle_gone(std::uint64_t id) NACELLE_REQUIRES(link_.pumping);
  void handle_ready(std::uint64_t id, bool is_ready) NACELLE_REQUIRES(link_.pumping);
  void handle_call(const wire::CallFrame& frame) NACELLE_REQUIRES(link_.pumping);
  void handle_answer(const wire::AnswerFrame& frame) NACELLE_REQUIRES(link_.pumping);
  [[nodiscard]] bool hand_on(const End& end, Call call) NACELLE_REQUIRES(link_.pumping);
  [[nodiscard]] const msgs::MessageType* type_for(const std::string& name, const std::string& hash, const End& end)
      NACELLE_REQUIRES(link_.pumping);
  void note_answered(std::uint64_t end) NACELLE_REQUIRES(link_.pumping);
  void note_broken(const std::string& service, const msgs::MessageType& type, msgs::DecodeFault fault)
      NACELLE_REQUIRES(link_.pumping);
  void forget_abandoned(std::uint64_t end) NACELLE_REQUIRES(link_.pumping);

  Impl& link_;
  ServiceGraph* const leaf_;
  ServiceHub* const hub_;
  const std::shared_ptr<Guarded<AnswerTaker*>> self_;
  std::map<std::uint64_t, End> ends_ NACELLE_GUARDED_BY(link_.pumping);                 // by the leaf's ids
  std::map<std::uint64_t, std::uint64_t> stand_ins_ NACELLE_GUARDED_BY(link_.pumping);  // on the hub: the leaf's ids
  std::map<std::uint64_t, Sent> sent_ NACELLE_GUARDED_BY(link_.pumping);                // by number
  std::uint64_t last_sent_ NACELLE_GUARDED_BY(link_.pumping) = 0;
  std::map<std::int64_t, Taken> taken_ NACELLE_GUARDED_BY(link_.pumping);
  std::int64_t last_taken_ NACELLE_GUARDED_BY(link_.pumping) = 0;
  bool held_back_ NACELLE_GUARDED_BY(link_.pumping) = false;
  bool told_broken_ NACELLE_GUARDED_BY(link_.pumping) = false;
  std::vector<Event> events_now_ NACELLE_GUARDED_BY(link_.pumping);

  // The last lock of all.
  Mutex noting_;
  std::vector<Event> events_ NACELLE_GUARDED_BY(noting_);
  std::deque<NotedCall> calls_ NACELLE_GUARDED_BY(noting_);
  std::deque<NotedAnswer> answers_ NACELLE_GUARDED_BY(noting_);
  std::size_t waiting_bytes_ NACELLE_GUARDED_BY(noting_) = 0;
};

}  // namespace nacelle
