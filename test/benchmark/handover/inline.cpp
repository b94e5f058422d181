// SPDX-License-Identifier: Apache-2.0
#include <std_msgs/msg/empty.hpp>
#include <vector>

#include "handover/plan.hpp"
#include "handover/reader.hpp"
#include "support/rig.hpp"
#include "support/step_counter.hpp"

namespace nacelle::bench {
namespace {

// Publishes on request; everything runs on the shared executor.
template <typename T>
class Sender final : public Recipe {
 public:
  explicit Sender(const Plan& plan) : plan_(plan) {}

  std::shared_ptr<void> build(LifecycleNode& node) override {
    publisher_ = node.create_publisher<T>("/stream", QoS(10));
    return keep(
        node.create_subscription<std_msgs::msg::Empty>("/go", QoS(1), [this](const std_msgs::msg::Empty&) { send(); }));
  }
  // The readers call this when the last of them has seen the message.
  void send() {
    if (sent_ == plan_.warm) begin();
    if (sent_ == plan_.warm + plan_.messages) return end();
    Loan<T> message = publisher_->borrow();
    fill(*message, plan_.bytes, sent_++);
    publisher_->publish(std::move(message));
  }
  [[nodiscard]] Outcome wait() {
    ended_.wait();
    publisher_.reset();
    return outcome_;
  }

 private:
  void begin() {
    before_ = publisher_->counters();
    outcome_.used = Usage::now();
    mark_steps();
  }
  void end() {
    mark_steps();
    outcome_.used = Usage::now() - outcome_.used;
    outcome_.written = publisher_->counters();
    outcome_.written.copies -= before_.copies;
    outcome_.written.bytes_copied -= before_.bytes_copied;
    ended_.set();
  }

  const Plan plan_;
  std::shared_ptr<Publisher<T>> publisher_;
  std::uint64_t sent_ = 0;
  WriterCounters before_;
  Outcome outcome_;
  Event ended_;
};

template <typename T>
class Receiver final : public Recipe {
 public:
  Receiver(std::string take, Sender<T>& sender, std::uint64_t readers, std::uint64_t& delivered)
      : take_(std::move(take)), sender_(sender), readers_(readers), delivered_(delivered) {}

  std::shared_ptr<void> build(LifecycleNode& node) override {
    return subscribe<T>(node, "/stream", QoS(10), take_, [this](const T&) {
      if (++delivered_ % readers_ == 0) sender_.send();
    });
  }

 private:
  const std::string take_;
  Sender<T>& sender_;
  const std::uint64_t readers_;
  std::uint64_t& delivered_;
};

template <typename T>
Outcome run(const Plan& plan, Duration patience) {
  const std::uint64_t all = plan.readers + plan.owners;
  std::uint64_t delivered = 0;
  Sender<T> sender(plan);
  std::vector<std::unique_ptr<Receiver<T>>> receivers;
  Rig rig(patience);
  rig.add("sender", sender);
  for (std::uint64_t i = 0; i < all; ++i) {
    receivers.push_back(std::make_unique<Receiver<T>>(i < plan.readers ? plan.take : "loan", sender, all, delivered));
    rig.add("receiver" + std::to_string(i), *receivers.back());
  }
  const auto go =
      rig.container().transport().create_writer({"/go", &std_msgs::msg::Empty::message_type(), QoS(1), "/main"});
  go->publish(*go->borrow());
  Outcome outcome = sender.wait();
  outcome.delivered = delivered - plan.warm * all;
  return outcome;
}

}  // namespace

Outcome run_inline(const Plan& plan, Duration patience) {
  return plan.bytes == 0 ? run<Small>(plan, patience) : run<Large>(plan, patience);
}

}  // namespace nacelle::bench
