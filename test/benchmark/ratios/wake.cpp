// SPDX-License-Identifier: Apache-2.0
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <std_msgs/msg/empty.hpp>
#include <thread>

#include "handover/reader.hpp"
#include "nacelle/runtime/futex.hpp"
#include "ratios/ratio.hpp"
#include "support/rig.hpp"

namespace nacelle::bench {
namespace {

constexpr std::size_t kRounds = 500;  // per block

void bind_to(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu, &set);
  pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

// Sends, and times the answers.
class Caller final : public Recipe {
 public:
  Caller() { rounds_.reserve(kRounds); }
  std::shared_ptr<void> build(LifecycleNode& node) override {
    publisher_ = node.create_publisher<Small>("/forth", QoS(10));
    return keep(
        node.create_subscription<std_msgs::msg::Empty>("/go", QoS(1), [this](const std_msgs::msg::Empty&) { send(); }),
        node.create_subscription<Small>("/back", QoS(10), [this](const Small&) {
          rounds_.push_back((clock_.now() - sent_).count());
          send();
        }));
  }
  double block(Writer& go) {
    rounds_.clear();
    static_cast<void>(go.publish(*go.borrow()));
    done_.wait();
    done_.clear();
    return static_cast<double>(median(rounds_));
  }
  void leave() { publisher_.reset(); }

 private:
  void send() {
    if (rounds_.size() == kRounds) return done_.set();
    Loan<Small> message = publisher_->borrow();
    sent_ = clock_.now();
    fill(*message, 0, rounds_.size());
    publisher_->publish(std::move(message));
  }
  const SystemClock clock_;
  std::shared_ptr<Publisher<Small>> publisher_;
  std::vector<std::int64_t> rounds_;
  MonotonicTime sent_;
  Event done_;
};

class Answerer final : public Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    publisher_ = node.create_publisher<Small>("/back", QoS(10));
    return node.create_subscription<Small>("/forth", QoS(10), [this](const Small& heard) {
      Loan<Small> message = publisher_->borrow();
      fill(*message, 0, heard.stamp.nanosec);
      publisher_->publish(std::move(message));
    });
  }
  void leave() { publisher_.reset(); }

 private:
  std::shared_ptr<Publisher<Small>> publisher_;
};

// Two threads that wake each other through two words, and nothing else: what the kernel charges for a wake-up.
class Bare {
 public:
  Bare(int first_cpu, int second_cpu)
      : caller_([this, first_cpu] { call(first_cpu); }), answerer_([this, second_cpu] { answer(second_cpu); }) {}
  ~Bare() {
    stop_ = true;
    step(go_);
    step(forth_);
    caller_.join();
    answerer_.join();
  }
  double block() {
    step(go_);
    done_.wait();
    done_.clear();
    return static_cast<double>(median(rounds_));
  }

 private:
  using Word = std::atomic<std::uint32_t>;
  static void step(Word& word) {
    word.fetch_add(1, std::memory_order_release);
    runtime::futex_wake(word, 1);
  }
  static void wait_for_step(const Word& word, std::uint32_t& seen) {
    while (word.load(std::memory_order_acquire) == seen) runtime::futex_wait(word, seen);
    ++seen;
  }
  void call(int cpu) {
    bind_to(cpu);
    const SystemClock clock;
    std::uint32_t orders = 0, answers = 0;
    for (;;) {
      wait_for_step(go_, orders);
      if (stop_) return;
      rounds_.clear();
      for (std::size_t i = 0; i < kRounds; ++i) {
        const MonotonicTime sent = clock.now();
        step(forth_);
        wait_for_step(back_, answers);
        rounds_.push_back((clock.now() - sent).count());
      }
      done_.set();
    }
  }
  void answer(int cpu) {
    bind_to(cpu);
    std::uint32_t calls = 0;
    for (;;) {
      wait_for_step(forth_, calls);
      if (stop_) return;
      step(back_);
    }
  }

  std::atomic<bool> stop_{false};
  Word go_{0}, forth_{0}, back_{0};
  std::vector<std::int64_t> rounds_;
  Event done_;
  std::thread caller_, answerer_;
};

}  // namespace

Ratio compare_wake(int first_cpu, int second_cpu, std::uint64_t blocks) {
  Caller caller;
  Answerer answerer;
  Rig rig;
  rig.add("answerer", answerer, {.own = true, .cpus = {second_cpu}});
  rig.add("caller", caller, {.own = true, .cpus = {first_cpu}});
  const auto go =
      rig.container().transport().create_writer({"/go", &std_msgs::msg::Empty::message_type(), QoS(1), "/main"});
  Bare bare(first_cpu, second_cpu);
  const Ratio ratio = interleave(
      blocks, [&] { return caller.block(*go); }, [&] { return bare.block(); });
  caller.leave();
  answerer.leave();
  return ratio;
}

}  // namespace nacelle::bench
