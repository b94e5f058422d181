// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/node/host.hpp"
#include "nacelle/runtime/executor.hpp"

namespace nacelle::runtime {

/// A message of a type known at run time only, on the heap.
class AnyMessage {
 public:
  explicit AnyMessage(const msgs::MessageType& type)
      : type_(&type), memory_(::operator new (type.size, std::align_val_t{type.alignment})) {
    type.construct(memory_);
  }
  AnyMessage(AnyMessage&& other) noexcept : type_(other.type_), memory_(std::exchange(other.memory_, nullptr)) {}
  AnyMessage& operator=(AnyMessage&&) = delete;
  ~AnyMessage() {
    if (memory_ == nullptr) return;
    type_->destroy(memory_);
    ::operator delete (memory_, std::align_val_t{type_->alignment});
  }
  [[nodiscard]] void* get() const { return memory_; }
  [[nodiscard]] const msgs::MessageType& type() const { return *type_; }

 private:
  const msgs::MessageType* type_;
  void* memory_;
};

class ServerPort;

/// Takes the answers of calls. Threads: the server's, with locks held: only note it and return.
class AnswerTaker {
 public:
  virtual ~AnswerTaker() = default;
  /// A null response: there will be none.
  virtual void push(std::int64_t sequence, std::unique_ptr<AnyMessage> response) = 0;
};

/// Who waits for an answer. The pointer is null once nobody does any more.
struct Asker {
  std::weak_ptr<Guarded<AnswerTaker*>> client;
  std::int64_t sequence;
};

/// One request on its way; nothing in it belongs to a component.
struct Call {
  Asker asker;
  AnyMessage request;
};

/// "std_srvs/srv/SetBool" from its request's type.
[[nodiscard]] std::string service_type_of(const msgs::MessageType& request);

/// Who answers which service of the container. Threads: any.
class ServiceDirectory {
 public:
  void add(const std::string& name, ServerPort& server);
  void remove(const std::string& name, ServerPort& server);
  /// Hands the call to the server, or returns false if there is none that is open.
  [[nodiscard]] bool send(const std::string& name, const msgs::MessageType& request, Call call);
  [[nodiscard]] bool is_ready(const std::string& name, const msgs::MessageType& request) const;
  [[nodiscard]] bool is_ready(const std::string& name) const;
  /// Why a call would go nowhere: no such service, another type, a server that is not active.
  [[nodiscard]] Problem why_not(const std::string& name, const msgs::MessageType& request) const;

 private:
  Guarded<std::multimap<std::string, ServerPort*>> servers_;
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
  /// Answers a call that the callback left open: see ServiceHandle.
  bool send_response(std::int64_t call, void* response);
  /// Tells every client that waits that there will be no answer, also those whose calls are being worked on or were left open.
  void refuse_all();
  [[nodiscard]] bool is_open() const { return open_.load(std::memory_order_acquire); }
  [[nodiscard]] const msgs::MessageType& request_type() const { return request_; }
  /// Null if it is not measured: 4 KiB less.
  [[nodiscard]] const CallbackStats* stats() const { return stats_.get(); }

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
  struct Open {  // whose callback runs, or has left the answer for later
    std::int64_t last = 0;
    std::map<std::int64_t, Asker> calls;  // who takes one out answers it
  };
  bool answer_open(std::int64_t call, std::unique_ptr<AnyMessage> response);
  Guarded<std::list<Waiting>> calls_;
  Guarded<Open> open_calls_;
  std::atomic<std::size_t> waiting_{0};
  std::unique_ptr<CallbackStats> stats_;  // the latency under the lock of calls_
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
  /// After this no server reaches the port any more.
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
  CallbackStats stats_;  // the latency under the lock of answers_
};

}  // namespace nacelle::runtime
