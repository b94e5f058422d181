// SPDX-License-Identifier: Apache-2.0
// peers peer=zmq|deque|futex path=inline|asleep|busy [messages=1000]
// The same hand-overs of 44 bytes as programs do them that have no Nacelle.
#include <pthread.h>
#include <sched.h>
#include <zmq.h>

#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "nacelle/runtime/futex.hpp"
#include "support/arguments.hpp"
#include "support/usage.hpp"

namespace {

struct Message {
  unsigned char bytes[44];
};

// What most programs write first: a lock, a queue, a condition variable.
class DequeLink {
 public:
  void send() {
    auto message = std::make_unique<Message>();
    {
      const std::lock_guard lock(mutex_);
      queue_.push_back(std::move(message));
    }
    arrived_.notify_one();
  }
  void receive() {
    std::unique_lock lock(mutex_);
    arrived_.wait(lock, [this] { return !queue_.empty(); });
    const auto message = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<std::unique_ptr<Message>> queue_;
};

void must(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "peers: %s\n", what);
  std::exit(1);
}

class ZmqLink {
 public:
  explicit ZmqLink(const char* address) {
    static void* const context = zmq_ctx_new();
    in_ = zmq_socket(context, ZMQ_PAIR);
    out_ = zmq_socket(context, ZMQ_PAIR);
    const int unlimited = 0;
    zmq_setsockopt(in_, ZMQ_RCVHWM, &unlimited, sizeof unlimited);
    zmq_setsockopt(out_, ZMQ_SNDHWM, &unlimited, sizeof unlimited);
    must(zmq_bind(in_, address) == 0, "zmq_bind failed");
    must(zmq_connect(out_, address) == 0, "zmq_connect failed");
  }
  // zmq_msg_init_size is its way to hand memory over; what exceeds 33 bytes lies on the heap.
  void send() {
    zmq_msg_t message;
    must(zmq_msg_init_size(&message, sizeof(Message)) == 0, "zmq_msg_init_size failed");
    must(zmq_msg_send(&message, out_, 0) == sizeof(Message), "zmq_msg_send failed");
  }
  void receive() {
    zmq_msg_t message;
    zmq_msg_init(&message);
    must(zmq_msg_recv(&message, in_, 0) == sizeof(Message), "zmq_msg_recv failed");
    zmq_msg_close(&message);
  }

 private:
  void* in_ = nullptr;
  void* out_ = nullptr;
};

class FutexLink {
 public:
  void send() {
    word_.fetch_add(1, std::memory_order_release);
    nacelle::runtime::futex_wake(word_, 1);
  }
  void receive() {
    while (word_.load(std::memory_order_acquire) == seen_) nacelle::runtime::futex_wait(word_, seen_);
    ++seen_;
  }

 private:
  std::atomic<std::uint32_t> word_{0};
  std::uint32_t seen_ = 0;
};

template <typename Link>
void run_inline(Link& link, std::uint64_t messages) {
  for (std::uint64_t i = 0; i < messages; ++i) {
    link.send();
    link.receive();
  }
}

template <typename Link>
void run_busy(Link& link, std::uint64_t messages) {
  constexpr std::uint64_t kBurst = 500;
  for (std::uint64_t sent = 0; sent < messages; sent += kBurst) {
    for (std::uint64_t i = 0; i < kBurst; ++i) link.send();
    for (std::uint64_t i = 0; i < kBurst; ++i) link.receive();
  }
}

// As the two components of `handover` are.
void bind_to(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu, &set);
  pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

template <typename Link>
void run_asleep(Link& forth, Link& back, std::uint64_t messages) {
  std::thread answerer([&] {
    bind_to(1);
    for (std::uint64_t i = 0; i < messages / 2; ++i) {
      forth.receive();
      back.send();
    }
  });
  bind_to(0);
  for (std::uint64_t i = 0; i < messages / 2; ++i) {
    forth.send();
    back.receive();
  }
  answerer.join();
}

template <typename Link>
nacelle::bench::Usage run(const std::string& path, Link& forth, Link& back, std::uint64_t messages) {
  const auto go = [&](std::uint64_t count) {
    if (path == "asleep") {
      run_asleep(forth, back, count);
    } else if (path == "busy") {
      run_busy(forth, count);
    } else {
      run_inline(forth, count);
    }
  };
  go(500);
  const auto before = nacelle::bench::Usage::now();
  go(messages);
  return nacelle::bench::Usage::now() - before;
}

}  // namespace

int main(int count, char** words) {
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  const std::string peer = arguments.text("peer", "deque"), path = arguments.text("path", "inline");
  const std::uint64_t messages = arguments.number("messages", 1000);
  Usage used;
  if (peer == "zmq") {
    ZmqLink forth("inproc://forth"), back("inproc://back");
    used = run(path, forth, back, messages);
  } else if (peer == "futex") {
    FutexLink forth, back;
    used = run(path, forth, back, messages);
  } else {
    DequeLink forth, back;
    used = run(path, forth, back, messages);
  }
  print_figures({{"delivered", static_cast<double>(messages)},
                 {"mallocs", static_cast<double>(used.mallocs)},
                 {"switches", static_cast<double>(used.switches)},
                 {"ns", static_cast<double>(used.at.nanoseconds())}});
  std::fflush(stdout);
  std::_Exit(0);  // ZeroMQ's context waits for its sockets, which are not closed here
}
