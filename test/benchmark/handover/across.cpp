// SPDX-License-Identifier: Apache-2.0
#include <std_msgs/msg/empty.hpp>

#include "handover/plan.hpp"
#include "handover/reader.hpp"
#include "support/rig.hpp"
#include "support/step_counter.hpp"

namespace nacelle::bench {
namespace {

// One of two players: answers each message with one, until it has sent `limit`.
class Player final : public Recipe {
 public:
  Player(const Plan& plan, std::string from, std::string to, bool serves)
      : plan_(plan), from_(std::move(from)), to_(std::move(to)), serves_(serves) {}

  std::shared_ptr<void> build(LifecycleNode& node) override {
    publisher_ = node.create_publisher<Small>(to_, QoS(10));
    auto heard = subscribe<Small>(node, from_, QoS(10), plan_.take, [this](const Small&) { send(); });
    if (!serves_) return keep(std::move(heard));
    return keep(std::move(heard), node.create_subscription<std_msgs::msg::Empty>(
                                      "/go", QoS(1), [this](const std_msgs::msg::Empty&) { send(); }));
  }
  Outcome wait() {
    ended_.wait();
    return outcome_;
  }
  void leave() { publisher_.reset(); }

 private:
  // Both send half of the messages; the server counts.
  void send() {
    const std::uint64_t warm = plan_.warm / 2, all = (plan_.warm + plan_.messages) / 2;
    if (serves_ && sent_ == warm) outcome_.used = Usage::now();
    if (serves_ && sent_ == all) {
      outcome_.used = Usage::now() - outcome_.used;
      outcome_.written = publisher_->counters();
      outcome_.delivered = 2 * (sent_ - warm);
      return ended_.set();
    }
    Loan<Small> message = publisher_->borrow();
    fill(*message, 0, sent_++);
    publisher_->publish(std::move(message));
  }

  const Plan plan_;
  const std::string from_, to_;
  const bool serves_;
  std::shared_ptr<Publisher<Small>> publisher_;
  std::uint64_t sent_ = 0;
  Outcome outcome_;
  Event ended_;
};

// Holds its executor in the first callback of a burst until the burst is complete.
class Busy final : public Recipe {
 public:
  explicit Busy(const Plan& plan) : plan_(plan) {}

  std::shared_ptr<void> build(LifecycleNode& node) override {
    publisher_ = node.create_publisher<Small>("/stream", QoS(kBurst + 12));
    return subscribe<Small>(node, "/stream", QoS(kBurst + 12), plan_.take, [this](const Small&) {
      if (delivered_ % kBurst == 0) {
        entered_.set();
        complete_.wait();
        complete_.clear();
      }
      if (++delivered_ % kBurst == 0) read_.set();
    });
  }
  // The publisher belongs to this thread from here on, as an I/O thread's.
  void send_burst() {
    for (std::uint64_t i = 0; i < kBurst; ++i) {
      Loan<Small> message = publisher_->borrow();
      fill(*message, 0, i);
      publisher_->publish(std::move(message));
      if (i == 0) entered_.wait();
    }
    entered_.clear();
    complete_.set();
    read_.wait();
    read_.clear();
  }
  [[nodiscard]] std::uint64_t delivered() const { return delivered_; }
  [[nodiscard]] WriterCounters counters() const { return publisher_->counters(); }
  void leave() { publisher_.reset(); }

 private:
  const Plan plan_;
  std::shared_ptr<Publisher<Small>> publisher_;
  std::uint64_t delivered_ = 0;
  Event entered_, complete_, read_;
};

}  // namespace

Outcome run_asleep(const Plan& plan) {
  Player server(plan, "/back", "/forth", true);
  Player answerer(plan, "/forth", "/back", false);
  Rig rig;
  // On one CPU the waker may be preempted before it sleeps, and is then found awake.
  rig.add("answerer", answerer, {.own = true, .cpus = {1}});
  rig.add("server", server, {.own = true, .cpus = {0}});
  const auto go =
      rig.container().transport().create_writer({"/go", &std_msgs::msg::Empty::message_type(), QoS(1), "/main"});
  go->publish(*go->borrow());
  const Outcome outcome = server.wait();
  server.leave();
  answerer.leave();
  return outcome;
}

Outcome run_busy(const Plan& plan) {
  Busy busy(plan);
  Rig rig(10s);  // under callgrind a burst takes longer than a callback may
  rig.add("busy", busy);
  for (std::uint64_t sent = 0; sent < plan.warm; sent += kBurst) busy.send_burst();
  const std::uint64_t warm = busy.delivered();
  Outcome outcome;
  outcome.used = Usage::now();
  for (std::uint64_t sent = 0; sent < plan.messages; sent += kBurst) busy.send_burst();
  outcome.used = Usage::now() - outcome.used;
  outcome.written = busy.counters();
  outcome.delivered = busy.delivered() - warm;
  busy.leave();
  return outcome;
}

}  // namespace nacelle::bench
