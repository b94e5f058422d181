// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>

#include "link_impl.hpp"

namespace nacelle {

/// The services of a link (docs/adr/0032). The side with `options.services`, the leaf, announces its servers and
/// clients; the side with `options.service_hub`, the hub, makes stand-ins for them. Each side numbers the calls that it
/// sends.
/// Threads: on_*(), push() and Exit::take() any, with locks of the graph held; the rest under Link::Impl::pumping.
struct Link::Impl::Services final : ServiceListener, private AnswerTaker {
  /// Takes the calls that go to the peer: those to a stand-in server on the hub, or of a client on the leaf.
  struct Exit final : RemoteServer {
    Exit(Services& owner, std::uint64_t id, const msgs::MessageType& response)
        : services(owner), end(id), response_type(response) {}
    [[nodiscard]] bool take(Call call) noexcept override;
    void assume_noting() const NACELLE_ASSERTS_HELD(services.noting_) {}  // the caller holds the owner's noting_

    Services& services;
    const std::uint64_t end;  // the id that the leaf has announced
    const msgs::MessageType& response_type;
    // Includes calls that wait to be sent.
    std::size_t unanswered NACELLE_GUARDED_BY(services.noting_) = 0;
  };
  /// A server or client of the leaf's graph, on either side.
  struct End {
    ServiceEndInfo info;
    std::uint64_t stand_in = 0;  // on the hub; 0: there is none
    std::unique_ptr<Exit> exit;  // for a server on the hub, for a client on the leaf
    std::size_t unanswered = 0;  // calls of the peer to it
  };
  struct Event {
    enum class Kind : std::uint8_t { Made, Gone, Ready } kind;
    ServiceEndInfo info;  // for Made; else only the id and is_open
  };
  struct NotedCall {
    std::uint64_t end;
    Call call;
    std::size_t bytes;
  };
  struct NotedAnswer {
    std::int64_t number;  // this side's number of the peer's call
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
    std::uint64_t number;  // the peer's number of the call
    std::uint64_t end;
  };

  explicit Services(Impl& owner)
      : link_(owner),
        leaf_(owner.options.services),
        hub_(owner.options.service_hub),
        self_(std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this))) {}

  void join();
  /// Removes the stand-ins, and notifies all waiting callers that there will be no answer.
  void end();

  // ServiceListener
  void on_made(const ServiceEndInfo& end) noexcept override;
  void on_gone(std::uint64_t id) noexcept override;
  void on_ready(std::uint64_t id, bool is_ready) noexcept override;

  /// Announces the changes of this side's servers and clients. Returns true if there were any.
  bool take_events();
  /// Sends waiting calls and answers, as long as the socket has room. Returns true if it sent any.
  bool send();
  [[nodiscard]] bool is_held_back() const {
    assume_pumping();
    return held_back_;
  }
  /// Returns false for a frame that breaks the protocol.
  [[nodiscard]] bool handle(const wire::LinkFrame& frame);

 private:
  /// For the compiler: all callers of the members above hold link_.pumping, which it knows by another name.
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
  std::map<std::uint64_t, End> ends_ NACELLE_GUARDED_BY(link_.pumping);  // by the leaf's ids
  std::map<std::uint64_t, std::uint64_t> stand_ins_
      NACELLE_GUARDED_BY(link_.pumping);  // on the hub: by their own ids, the leaf's ids
  std::map<std::uint64_t, Sent> sent_ NACELLE_GUARDED_BY(link_.pumping);  // by number
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
