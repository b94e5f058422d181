// SPDX-License-Identifier: Apache-2.0
#include "services.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::runtime {
namespace {

bool answer(const Asker& asker, std::unique_ptr<AnyMessage> response) {
  const auto client = asker.client.lock();
  if (!client) return false;
  auto port = client->lock();  // held while pushing, so that the client cannot go meanwhile
  if (*port == nullptr) return false;
  (*port)->push(asker.sequence, std::move(response));
  return true;
}

}  // namespace

void ServiceDirectory::add(const std::string& name, ServerPort& server) { servers_.lock()->emplace(name, &server); }

void ServiceDirectory::remove(const std::string& name, ServerPort& server) {
  auto servers = servers_.lock();
  const auto [first, last] = servers->equal_range(name);
  for (auto it = first; it != last; ++it) {
    if (it->second == &server) {
      servers->erase(it);
      return;
    }
  }
}

bool ServiceDirectory::send(const std::string& name, const msgs::MessageType& request, Call call) {
  auto servers = servers_.lock();
  const auto [first, last] = servers->equal_range(name);
  for (auto it = first; it != last; ++it) {
    if (&it->second->request_type() != &request || !it->second->is_open()) continue;
    it->second->push(std::move(call));
    return true;
  }
  return false;
}

bool ServiceDirectory::is_ready(const std::string& name, const msgs::MessageType& request) const {
  auto servers = servers_.lock();
  const auto [first, last] = servers->equal_range(name);
  for (auto it = first; it != last; ++it) {
    if (&it->second->request_type() == &request && it->second->is_open()) return true;
  }
  return false;
}

bool ServiceDirectory::is_ready(const std::string& name) const {
  auto servers = servers_.lock();
  const auto [first, last] = servers->equal_range(name);
  return std::any_of(first, last, [](const auto& entry) { return entry.second->is_open(); });
}

Problem ServiceDirectory::why_not(const std::string& name, const msgs::MessageType& request) const {
  auto servers = servers_.lock();
  const auto [first, last] = servers->equal_range(name);
  std::vector<std::string> others;
  for (auto it = first; it != last; ++it) {
    const msgs::MessageType& type = it->second->request_type();
    if (&type == &request) return {"service " + name, "its node is not active", "see `nacelle lifecycle nodes`"};
    others.push_back(service_type_of(type));
  }
  if (!others.empty())
    return {"service " + name, "has the type " + join(others, " and ") + ", not " + service_type_of(request), ""};
  std::vector<std::string> names;
  for (const auto& [other, server] : *servers) names.push_back(other);
  return {"service " + name, "no node of this process offers it", suggestion(name, names)};
}

std::string service_type_of(const msgs::MessageType& request) {
  constexpr std::string_view kEnding = "_Request";
  std::string name = request.name;
  if (name.ends_with(kEnding)) name.resize(name.size() - kEnding.size());
  return name;
}

void ServerPort::push(Call call) {
  const MonotonicTime now = clock_.now();
  auto calls = calls_.lock();
  calls->push_back({std::move(call), now});
  waiting_.store(calls->size(), std::memory_order_release);
  on_ready();  // under the lock: docs/wake_up.md, rule 2
}

void ServerPort::execute(MonotonicTime now) {
  std::list<Waiting> taken;
  {
    auto calls = calls_.lock();
    if (calls->empty()) return;
    taken.splice(taken.begin(), *calls, calls->begin());
    waiting_.store(calls->size(), std::memory_order_release);
    if (stats_) stats_->latency.record(now - taken.front().since);
    // In a reentrant group the next call need not wait for this one's callback.
    if (!calls->empty() && group().type() == CallbackGroupType::Reentrant) on_ready();
  }
  const Call& call = taken.front().call;
  if (!is_open()) {
    answer(call.asker, nullptr);
    return;
  }
  std::int64_t number = 0;
  {
    auto open = open_calls_.lock();
    number = ++open->last;
    open->calls.emplace(number, call.asker);
  }
  auto response = std::make_unique<AnyMessage>(response_);
  try {
    if (!callback_.run(callback_.context, number, call.request.get(), response->get())) return;
  } catch (...) {
    answer_open(number, nullptr);
    throw;  // the executor makes it the component's fault
  }
  answer_open(number, std::move(response));
}

bool ServerPort::answer_open(std::int64_t call, std::unique_ptr<AnyMessage> response) {
  // The asker may have its answer, or have been told that there will be none.
  const auto taken = open_calls_.lock()->calls.extract(call);
  return !taken.empty() && answer(taken.mapped(), std::move(response));
}

bool ServerPort::send_response(std::int64_t call, void* response) {
  auto moved = std::make_unique<AnyMessage>(response_);
  response_.move_assign(moved->get(), response);
  return answer_open(call, std::move(moved));
}

void ServerPort::refuse_all() {
  std::list<Waiting> waiting;
  {
    auto calls = calls_.lock();
    calls->swap(waiting);
    waiting_.store(0, std::memory_order_release);
  }
  std::map<std::int64_t, Asker> open;
  open_calls_.lock()->calls.swap(open);
  for (const auto& entry : open) answer(entry.second, nullptr);
  for (const Waiting& refused : waiting) answer(refused.call.asker, nullptr);
}

void ClientPort::push(std::int64_t sequence, std::unique_ptr<AnyMessage> response) {
  const MonotonicTime now = clock_.now();
  auto answers = answers_.lock();
  answers->push_back({sequence, std::move(response), now});
  waiting_.store(answers->size(), std::memory_order_release);
  on_ready();
}

void ClientPort::execute(MonotonicTime now) {
  Answer next{};
  {
    auto answers = answers_.lock();
    if (answers->empty()) return;
    next = std::move(answers->front());
    answers->pop_front();
    waiting_.store(answers->size(), std::memory_order_release);
    stats_.latency.record(now - next.since);
    if (!answers->empty() && group().type() == CallbackGroupType::Reentrant) on_ready();
  }
  callback_.run(callback_.context, next.sequence, next.response ? next.response->get() : nullptr);
}

}  // namespace nacelle::runtime
