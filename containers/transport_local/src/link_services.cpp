// SPDX-License-Identifier: Apache-2.0
// Services over the link: stand-ins for the peer's servers and clients, calls and their answers.
#include "link_services.hpp"

#include <algorithm>

#include "nacelle/base/names.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle {
namespace {

constexpr std::size_t kMostServiceEnds = 4096;
// Calls of one server or client that are not answered, in each direction. The result of an action is an answer that comes when
// its goal ends.
constexpr std::size_t kMostCalls = 256;
// Requests and responses that wait to be sent.
constexpr std::size_t kMostWaitingBytes = std::size_t{64} << 20U;

}  // namespace

// --- what this side's graph says ----------------------------------------------------------------------------------------

void Link::Impl::Services::join() {
  if (leaf_ != nullptr) leaf_->join(*this);
  if (hub_ != nullptr) hub_->join(*this);
}

void Link::Impl::Services::end() {
  assume_pumping();
  if (leaf_ != nullptr) leaf_->leave(*this);
  if (hub_ != nullptr) hub_->leave(*this);
  for (auto& [id, end] : ends_) {
    if (end.stand_in != 0) hub_->remove_stand_in(end.stand_in);
    if (leaf_ != nullptr && end.exit) leaf_->set_remote(id, nullptr);
  }
  *self_->lock() = nullptr;  // waits for a push() that is under way
  std::deque<NotedCall> unsent;
  {
    const LockGuard lock(noting_);
    unsent.swap(calls_);
    answers_.clear();
    events_.clear();
  }
  for (const NotedCall& call : unsent) call.call.asker.answer(nullptr);
  for (const auto& [id, call] : sent_) call.asker.answer(nullptr);
  sent_.clear();
  taken_.clear();
  stand_ins_.clear();
  ends_.clear();
}

void Link::Impl::Services::note(Event change) noexcept {
  {
    const LockGuard lock(noting_);
    events_.push_back(std::move(change));
  }
  link_.wake();
}

void Link::Impl::Services::on_made(const ServiceEndInfo& end) noexcept {
  if (leaf_ != nullptr && end.node != link_.options.private_node) note({Event::Kind::Made, end});
}
void Link::Impl::Services::on_gone(std::uint64_t id) noexcept {
  if (leaf_ != nullptr) note({Event::Kind::Gone, {.id = id}});
}
void Link::Impl::Services::on_ready(std::uint64_t id, bool is_ready) noexcept {
  note({Event::Kind::Ready, {.id = id, .is_open = is_ready}});
}

bool Link::Impl::Services::Exit::take(Call call) noexcept {
  const std::size_t bytes = call.request.type().encoded_size(call.request.get());
  {
    const LockGuard lock(services.noting_);
    if (unanswered >= kMostCalls || bytes > wire::kLongestServiceBytes ||
        services.waiting_bytes_ + bytes > kMostWaitingBytes)
      return false;
    ++unanswered;
    services.waiting_bytes_ += bytes;
    services.calls_.push_back({end, std::move(call), bytes});
  }
  services.link_.wake();
  return true;
}

void Link::Impl::Services::push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) {
  std::size_t bytes = response ? response->type().encoded_size(response->get()) : 0;
  if (bytes > wire::kLongestServiceBytes) {
    link_.log.error("a response of {} bytes ({}) is longer than a link carries: its caller gets none", bytes,
                    response->type().name);
    response.reset();
  }
  {
    const LockGuard lock(noting_);
    if (waiting_bytes_ + bytes > kMostWaitingBytes) response.reset();
    if (!response) bytes = 0;
    waiting_bytes_ += bytes;
    answers_.push_back({sequence, std::move(response), bytes});
  }
  link_.wake();
}

// --- to the peer --------------------------------------------------------------------------------------------------------

bool Link::Impl::Services::take_events() {
  assume_pumping();
  {
    const LockGuard lock(noting_);
    std::swap(events_, events_now_);
  }
  const bool did = !events_now_.empty();
  for (const Event& change : events_now_) take_event(change);
  events_now_.clear();
  return did;
}

void Link::Impl::Services::take_event(const Event& change) {
  const std::uint64_t id = change.info.id;
  if (change.kind == Event::Kind::Made) {
    const ServiceEndInfo& info = change.info;
    End& end = ends_[id];
    end.info = info;
    if (!info.is_server) end.exit = std::make_unique<Exit>(*this, id, *info.response);
    wire::append_service(link_.out, {id, info.is_server, info.is_open, info.name, info.node, info.request->name,
                                     info.request->hash, info.response->name, info.response->hash});
  } else if (change.kind == Event::Kind::Gone) {
    // Nothing takes calls for it any more, and its callers have gone with it.
    if (ends_.erase(id) == 0) return;
    std::erase_if(sent_, [&](const auto& entry) { return entry.second.end == id; });
    wire::append_id(link_.out, wire::LinkFrameKind::ServiceGone, id);
  } else if (hub_ != nullptr) {
    const auto found = stand_ins_.find(id);
    if (found == stand_ins_.end() || ends_.at(found->second).info.is_server) return;
    wire::append_id_and_byte(link_.out, wire::LinkFrameKind::ServiceReady, found->second, change.info.is_open ? 1 : 0);
  } else if (const auto found = ends_.find(id); found != ends_.end() && found->second.info.is_server) {
    wire::append_id_and_byte(link_.out, wire::LinkFrameKind::ServiceReady, id, change.info.is_open ? 1 : 0);
  }
}

bool Link::Impl::Services::send() {
  assume_pumping();
  bool did = false;
  for (;;) {
    std::optional<NotedCall> call;
    std::optional<NotedAnswer> answer;
    {
      const LockGuard lock(noting_);
      held_back_ = link_.is_full() && !(answers_.empty() && calls_.empty());
      if (held_back_ || (answers_.empty() && calls_.empty())) return did;
      if (!answers_.empty()) {
        answer.emplace(std::move(answers_.front()));
        answers_.pop_front();
        waiting_bytes_ -= answer->bytes;
      } else {
        call.emplace(std::move(calls_.front()));
        calls_.pop_front();
        waiting_bytes_ -= call->bytes;
      }
    }
    did = true;
    if (answer) send_answer(*answer);
    if (call) send_call(std::move(*call));
  }
}

void Link::Impl::Services::send_call(NotedCall call) {
  const auto found = ends_.find(call.end);
  if (found == ends_.end() || !found->second.exit) {  // gone meanwhile
    call.call.asker.answer(nullptr);
    return;
  }
  const msgs::AnyMessage& request = call.call.request;
  request.type().encode(request.get(), wire::append_call(link_.out, call.end, ++last_sent_, call.bytes));
  sent_.emplace(last_sent_, Sent{call.end, std::move(call.call.asker), &found->second.exit->response_type});
  ++link_.sent;
  bool many = false;
  {
    const LockGuard lock(noting_);
    found->second.exit->assume_noting();
    many = found->second.exit->unanswered > kMostCalls / 2;
  }
  if (many) forget_abandoned(call.end);
}

// Callers that no longer wait leave room for others.
void Link::Impl::Services::forget_abandoned(std::uint64_t end) {
  for (auto it = sent_.begin(); it != sent_.end();) {
    if (it->second.end != end || !it->second.asker.client.expired()) {
      ++it;
      continue;
    }
    it = sent_.erase(it);
    note_answered(end);
  }
}

void Link::Impl::Services::note_answered(std::uint64_t end) {
  const auto found = ends_.find(end);
  if (found == ends_.end() || !found->second.exit) return;
  const LockGuard lock(noting_);
  found->second.exit->assume_noting();
  --found->second.exit->unanswered;
}

void Link::Impl::Services::send_answer(const NotedAnswer& answer) {
  const auto asked = taken_.extract(answer.number);
  if (asked.empty()) return;
  if (const auto end = ends_.find(asked.mapped().end); end != ends_.end()) --end->second.unanswered;
  if (answer.response) {
    answer.response->type().encode(answer.response->get(),
                                   wire::append_answer(link_.out, asked.mapped().number, answer.bytes));
  } else {
    wire::append_no_answer(link_.out, asked.mapped().number);
  }
  ++link_.sent;
}

// --- from the peer ------------------------------------------------------------------------------------------------------

bool Link::Impl::Services::handle(const wire::LinkFrame& frame) {
  assume_pumping();
  using wire::LinkFrameKind;
  switch (frame.kind) {
    case LinkFrameKind::Service: return handle_service(frame.payload);
    case LinkFrameKind::ServiceGone: {
      const auto id = wire::read_id(frame.payload);
      if (id) handle_gone(*id);
      return id.has_value();
    }
    case LinkFrameKind::ServiceReady: {
      const auto told = wire::read_id_and_byte(frame.payload);
      if (told) handle_ready(told->first, told->second != 0);
      return told.has_value();
    }
    case LinkFrameKind::Call: {
      const auto call = wire::read_call(frame.payload);
      if (call) handle_call(*call);
      return call.has_value();
    }
    case LinkFrameKind::Answer: {
      const auto answer = wire::read_answer(frame.payload);
      if (answer) handle_answer(*answer);
      return answer.has_value();
    }
    default: return false;
  }
}

bool Link::Impl::Services::handle_service(ByteView payload) {
  const auto told = wire::read_service(payload);
  if (!told) return false;
  if (hub_ == nullptr) return true;
  if (ends_.contains(told->id) || ends_.size() >= kMostServiceEnds) return false;
  if (const auto fine = validate_full_topic_name(told->name); !fine) {
    link_.log.error("a service of {} is refused: {}", link_.options.peer, fine.error().text());
    return true;
  }
  End& end = ends_[told->id];
  end.info = {0, told->is_server, told->name, told->node, nullptr, nullptr, told->open};
  end.info.request = type_for(told->request, told->request_hash, end);
  if (end.info.request != nullptr) end.info.response = type_for(told->response, told->response_hash, end);
  if (end.info.response == nullptr) return true;
  if (told->is_server) end.exit = std::make_unique<Exit>(*this, told->id, *end.info.response);
  end.stand_in = hub_->add_stand_in(end.info, end.exit.get());
  stand_ins_.emplace(end.stand_in, told->id);
  return true;
}

const msgs::MessageType* Link::Impl::Services::type_for(const std::string& name, const std::string& hash,
                                                        const End& end) {
  const auto* const type = link_.find_type(name);
  if (type != nullptr && hash == type->hash) return type;
  const std::string role = end.info.node + (end.info.is_server ? " offers " : " calls ") + name;
  const Problem problem =
      type == nullptr
          ? Problem{"service " + end.info.name, role + ", which this process does not know: the service is not linked",
                    "install its message package here too"}
          : Problem{"service " + end.info.name,
                    role + " as " + hash + ", this process has " + type->hash + ": the service is not linked",
                    "build both sides with the same message definitions"};
  link_.log.error("{}", problem.text());
  return nullptr;
}

void Link::Impl::Services::handle_gone(std::uint64_t id) {
  const auto found = ends_.find(id);
  if (hub_ == nullptr || found == ends_.end()) return;
  if (found->second.stand_in != 0) {
    hub_->remove_stand_in(found->second.stand_in);
    stand_ins_.erase(found->second.stand_in);
  }
  // Calls that a server has taken are still answered by the peer. Those of a client have no caller any more.
  if (!found->second.info.is_server) std::erase_if(taken_, [&](const auto& call) { return call.second.end == id; });
  ends_.erase(found);
}

void Link::Impl::Services::handle_ready(std::uint64_t id, bool is_ready) {
  const auto found = ends_.find(id);
  if (found == ends_.end()) return;
  if (hub_ != nullptr) {
    if (found->second.info.is_server && found->second.stand_in != 0)
      hub_->open_stand_in(found->second.stand_in, is_ready);
  } else if (found->second.exit) {
    leaf_->set_remote(id, is_ready ? found->second.exit.get() : nullptr);
  }
}

void Link::Impl::Services::handle_call(const wire::CallFrame& frame) {
  ++link_.received;
  const auto found = ends_.find(frame.end);
  // On the leaf the peer calls servers, on the hub its clients call.
  const bool known = found != ends_.end() && found->second.info.request != nullptr &&
                     found->second.info.is_server == (leaf_ != nullptr);
  if (!known) {
    ++link_.dropped;
    wire::append_no_answer(link_.out, frame.number);
    return;
  }
  End& end = found->second;
  msgs::AnyMessage request{*end.info.request};
  if (const auto decoded = end.info.request->decode(frame.cdr, request.get()); !decoded) {
    note_broken(end.info.name, *end.info.request, decoded.error());
    wire::append_no_answer(link_.out, frame.number);
    return;
  }
  if (end.unanswered >= kMostCalls) {
    wire::append_no_answer(link_.out, frame.number);
    return;
  }
  ++end.unanswered;
  taken_.emplace(++last_taken_, Taken{frame.number, frame.end});
  if (hand_on(end, {{self_, last_taken_}, std::move(request)})) return;
  --end.unanswered;
  taken_.erase(last_taken_);
  wire::append_no_answer(link_.out, frame.number);
}

bool Link::Impl::Services::hand_on(const End& end, Call call) {
  if (hub_ != nullptr) return hub_->call(end.stand_in, std::move(call));
  return leaf_->send(end.info.id, std::move(call)) == ServiceGraph::Sent::Yes;
}

void Link::Impl::Services::handle_answer(const wire::AnswerFrame& frame) {
  ++link_.received;
  const auto asked = sent_.extract(frame.number);
  if (asked.empty()) {
    ++link_.dropped;
    return;
  }
  const Sent& call = asked.mapped();
  note_answered(call.end);
  std::unique_ptr<msgs::AnyMessage> response;
  if (frame.answered) {
    response = std::make_unique<msgs::AnyMessage>(*call.response_type);
    if (const auto decoded = call.response_type->decode(frame.cdr, response->get()); !decoded) {
      response.reset();
      const auto end = ends_.find(call.end);
      note_broken(end == ends_.end() ? "" : end->second.info.name, *call.response_type, decoded.error());
    }
  }
  call.asker.answer(std::move(response));
}

void Link::Impl::Services::note_broken(const std::string& service, const msgs::MessageType& type,
                                       msgs::DecodeFault fault) {
  ++link_.broken;
  if (std::exchange(told_broken_, true)) return;
  link_.log.error("service {}: what {} sent is no {}: {}; the call fails, and the next ones are only counted", service,
                  link_.options.peer, type.name, msgs::explain(fault));
}

}  // namespace nacelle
