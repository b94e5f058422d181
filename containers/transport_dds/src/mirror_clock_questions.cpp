// SPDX-License-Identifier: Apache-2.0
#include "mirror_clock_questions.hpp"

#include <algorithm>
#include <rcl_interfaces/srv/get_parameter_types.hpp>
#include <utility>

namespace nacelle {
namespace {

using rcl_interfaces::srv::GetParameterTypes;

constexpr const char* kService = "rcl_interfaces/srv/GetParameterTypes";
constexpr std::size_t kMostOpen = 4, kMostQueued = 32;
// The shortest of several round trips is the most accurate, and on a lossy link some get no answer.
constexpr std::size_t kMostSent = 5, kAnswersEnough = 3;
constexpr Duration kBetween = 1s, kPatience = 6s;
// As with other calls (mirror_calls.cpp); a query that is lost nevertheless is followed by the next one.
constexpr Duration kUntilMet = 100ms;
// After so many, others get their turn.
constexpr int kMostTakenAtOnce = 64;

}  // namespace

struct DdsMirror::Impl::Services::Questions::Question final : End {
  using End::End;
  ~Question() override { close(); }

  struct Sent {
    std::int64_t sequence;
    WallTime wall;
    MonotonicTime at;
  };
  dds::Gid peer;
  std::vector<Sent> sent;  // and not answered
  std::size_t asked = 0, answered = 0;
  MonotonicTime next = kNeverExpires, ends;  // when to send the next query; when to give up
};

std::vector<std::string> DdsMirror::Impl::Services::Questions::services_of(const dds::Gid& peer) const {
  const msgs::MessageType& request = GetParameterTypes::Request::message_type();
  auto names = services_.mirror.remote.lock()->services_of(peer, kService, request.hash);
  // The export list applies to these clients too.
  const auto& exports = services_.mirror.options.exports;
  if (!exports.empty())
    std::erase_if(names, [&](const std::string& name) { return dds::rule_of(exports, name, kService) == nullptr; });
  return names;
}

dds::PeerClock* DdsMirror::Impl::Services::Questions::clock_of(const dds::Gid& peer) const {
  const auto known = services_.mirror.peers.find(peer);
  return known == services_.mirror.peers.end() ? nullptr : &known->second.clock;
}

bool DdsMirror::Impl::Services::Questions::add(const dds::Gid& peer) {
  if (is_forbidden_ || waiting_.size() == kMostQueued || services_of(peer).empty()) return false;
  waiting_.push_back(peer);
  return true;
}

void DdsMirror::Impl::Services::Questions::open(const dds::Gid& peer) {
  dds::PeerClock* const of_peer = clock_of(peer);
  if (of_peer == nullptr) return;
  const MonotonicTime at = services_.mirror.clock.now();
  const auto names = services_of(peer);
  if (names.empty()) return of_peer->end_asking(at);
  ServiceEndInfo info;
  // Servers and clients of this side have ids without the highest bit.
  info.id = std::uint64_t{1} << 63U | ++last_id_;
  // Another node each time: one of them may be busy.
  info.name = names[last_id_ % names.size()];
  info.request = &GetParameterTypes::Request::message_type();
  info.response = &GetParameterTypes::Response::message_type();
  auto question = std::make_shared<Question>(services_, info);
  question->peer = peer;
  question->ends = at + kPatience;
  if (const auto opened = services_.open(*question); !opened) {
    // Most likely the permissions of the own enclave, which do not change.
    is_forbidden_ = true;
    services_.mirror.log.info("the clocks of other machines are not queried: {}", opened.error().text());
    return of_peer->end_asking(at);
  }
  Question& added = *open_ones_.emplace(info.id, std::move(question)).first->second;
  // What came before it was to be found.
  added.queued = false;
  added.is_status_new = true;
  services_.note_ready(added);
}

void DdsMirror::Impl::Services::Questions::look_at(std::uint64_t id) {
  const auto found = open_ones_.find(id);
  if (found == open_ones_.end()) return;
  Question& question = *found->second;
  // Reset before reading: events that arrive meanwhile signal again.
  question.queued = false;
  if (question.is_status_new.exchange(false)) look_for_server(question);
  receive(question);
}

void DdsMirror::Impl::Services::Questions::look_for_server(Question& question) {
  const auto has = [&](const std::vector<dds::MatchedPeer>& matched) {
    return std::ranges::any_of(
        matched, [&](const dds::MatchedPeer& one) { return one.endpoint.gid.same_participant(question.peer); });
  };
  if (question.next == kNeverExpires && question.asked == 0 && has(question.reader->matched()) &&
      has(question.writer->matched())) {
    question.next = services_.mirror.clock.now() + kUntilMet;
    question.ends = question.next + kPatience;  // the time that it took to meet is not that of the answers
  }
}

void DdsMirror::Impl::Services::Questions::send(Question& question) {
  const Clock& own = services_.mirror.clock;
  const GetParameterTypes::Request request;
  const msgs::MessageType& type = *question.info.request;
  const dds::CallHeader header{question.writer->handle(), ++services_.last_sequence};
  ++question.asked;
  question.next = question.asked == kMostSent ? kNeverExpires : own.now() + kBetween;
  auto payload = question.writer->borrow(dds::call_size(type, &request));
  if (!payload) return;
  dds::write_call(header, type, &request, payload.bytes().data());
  const WallTime wall = own.wall_now();
  question.sent.push_back({header.sequence, wall, own.now()});
  if (question.writer->write(std::move(payload), wall) == dds::Writer::Sent::Yes) ++services_.clock_questions;
}

void DdsMirror::Impl::Services::Questions::receive(Question& question) {
  for (int left = kMostTakenAtOnce; left > 0; --left) {
    const auto sample = question.reader->take();
    if (!sample) return;
    take(question, *sample);
  }
  services_.note_ready(question);
}

void DdsMirror::Impl::Services::Questions::take(Question& question, const dds::Sample& sample) {
  const Clock& own = services_.mirror.clock;
  const WallTime came = own.wall_now();
  const MonotonicTime at = own.now();
  // Several nodes of one name answer, and every client of a service gets every reply.
  if (!sample.writer.same_participant(question.peer)) return;
  const auto call = dds::read_call(sample.payload.bytes(), services_.scratch);
  if (!call || !dds::is_reply_to(call->header, question.writer->handle())) return;
  const auto sent = std::ranges::find(question.sent, call->header.sequence, &Question::Sent::sequence);
  if (sent == question.sent.end()) return;
  if (dds::PeerClock* const of_peer = clock_of(question.peer))
    of_peer->note_answer({sent->wall, sent->at, sample.source_time, came, at});
  question.sent.erase(sent);
  ++question.answered;
  ++services_.clock_answers;
}

bool DdsMirror::Impl::Services::Questions::is_over(const Question& question) const {
  return question.answered == kAnswersEnough || services_.mirror.clock.now() >= question.ends ||
         clock_of(question.peer) == nullptr;
}

// While a large message is being sent, Cyclone blocks the destruction of endpoints.
void DdsMirror::Impl::Services::Questions::close(std::shared_ptr<Question> question) {
  if (dds::PeerClock* const of_peer = clock_of(question->peer)) of_peer->end_asking(services_.mirror.clock.now());
  if (services_.mirror.lane.is_busy()) services_.mirror.lane.add([question = std::move(question)] {});
}

void DdsMirror::Impl::Services::Questions::turn() {
  while (!waiting_.empty() && open_ones_.size() < kMostOpen) {
    open(waiting_.front());
    waiting_.pop_front();
  }
  for (auto one = open_ones_.begin(); one != open_ones_.end();) {
    Question& question = *one->second;
    if (is_over(question)) {
      close(std::move(one->second));
      one = open_ones_.erase(one);
      continue;
    }
    if (services_.mirror.clock.now() >= question.next) send(question);
    ++one;
  }
}

MonotonicTime DdsMirror::Impl::Services::Questions::due() const {
  MonotonicTime first = kNeverExpires;
  if (!waiting_.empty() && open_ones_.size() < kMostOpen) first = MonotonicTime{};
  for (const auto& [id, question] : open_ones_) first = std::min({first, question->next, question->ends});
  return first;
}

}  // namespace nacelle
