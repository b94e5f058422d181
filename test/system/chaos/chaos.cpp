// SPDX-License-Identifier: Apache-2.0
// A component that goes wrong on command: what supervision must bear. The command is the text of a message on ~/do.
//
//   throw, fault        an exception in a callback; a reported fault
//   hang                a callback that does not return
//   thread              a reader thread ends by an exception
//   crash, abort        SIGSEGV; std::terminate in a thread of its own
//   blocked abort       abort() in a thread that blocks all signals
//   overflow            a thread that blocks all signals overflows its stack
//   exit, quick exit, _exit
//   leak                64 MiB that are never freed
//   flood               as many messages as fit into half a second, from a callback
//   lie                 a publisher of /scan with another type
//   spin                a callback that takes 100 ms of CPU, again and again
//   close               closes every descriptor of the process that is not its own
//   hoard               opens descriptors until there is none left
//   reset               calm again (where that is possible)
//
// Its service ~/answer echoes `data`; asked for false it does not return.
#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <semaphore>
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "nacelle/io/descriptor.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::test {
namespace {

using std_msgs::msg::String;

// A line that breaks in a way that its driver did not think of.
class BadLine final : public io::ByteStream {
 public:
  Result<ByteView, io::StreamFault> read_until(MonotonicTime) override {
    throw std::runtime_error("the decoder gave up");
  }
  Result<void, io::StreamFault> write(ByteView) override { return {}; }
  void interrupt() noexcept override {}
  Result<void, io::StreamFault> reopen() override { return err(io::StreamFault::NotFound); }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
};
class NoSink final : public io::ByteSink {
  void on_bytes(ByteView, MonotonicTime) override {}
  void on_silence(MonotonicTime) override {}
  void on_break(io::StreamFault, MonotonicTime) override {}
  void on_return(MonotonicTime) override {}
};

// As the threads of Cyclone DDS and iceoryx run.
void run_with_all_signals_blocked(void (*what)()) {
  sigset_t all;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
  std::thread{what}.join();
}

[[gnu::noinline]] std::uint64_t go_deeper(std::uint64_t depth) {
  volatile std::uint8_t room[1024];
  room[0] = 1;
  return depth == ~std::uint64_t{0} ? 0 : go_deeper(depth + 1) + room[0];
}

}  // namespace

class Chaos final : public LifecycleNode {
 public:
  explicit Chaos(const NodeOptions& options) : LifecycleNode("chaos", options) {
    declare_parameter("stop_file", "");  // makes an actuator of it: where its stop frame goes
    // "configure" or "activate" throws; "activated": a fault when it is; "crash" at once when it is activated;
    // "configure for ever", "deactivate for ever" do not return
    declare_parameter("fail_in", "");
    declare_parameter("note", "as launched");  // to be set at run time
    declare_parameter("share", 0.5,
                      {.description = "of nothing", .floating_point_range = FloatingPointRange{0.0, 1.0, 0.0}});
    declare_parameter("loose", 1, {.dynamic_typing = true});
    alive_ = create_publisher<String>("~/alive", QoS(10));
    beat_ = create_wall_timer(10ms, [this] { say(); });
    orders_ = create_subscription<String>("~/do", QoS(10), [this](const String& order) { obey(order.data); });
    answers_ = create_service<std_srvs::srv::SetBool>(
        "~/answer", [](const std_srvs::srv::SetBool::Request& request, std_srvs::srv::SetBool::Response& response) {
          if (!request.data) std::binary_semaphore{0}.acquire();
          response.success = true;
          response.message = "it's told";
        });
  }
  ~Chaos() override {
    if (stop_ >= 0) ::close(stop_);
  }

 private:
  CallbackReturn on_configure(const State&) override {
    if (get<std::string>("fail_in") == "configure for ever") std::binary_semaphore{0}.acquire();
    if (get<std::string>("fail_in") == "configure") throw std::runtime_error("cannot be configured");
    const auto file = get<std::string>("stop_file");
    if (file.empty()) return CallbackReturn::SUCCESS;
    stop_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (stop_ < 0) return refuse("the stop file cannot be opened");
    static constexpr std::uint8_t kFrame[] = {'S', 'T', 'O', 'P', '\n'};
    register_safe_stop(stop_, {kFrame, sizeof kFrame});
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_activate(const State&) override {
    if (get<std::string>("fail_in") == "activate") throw std::runtime_error("cannot be activated");
    if (get<std::string>("fail_in") == "crash") *nowhere_ = 1;
    if (get<std::string>("fail_in") == "activated") fault("TOLD_TO", "a fault on command");
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_deactivate(const State&) override {
    if (get<std::string>("fail_in") == "deactivate for ever") std::binary_semaphore{0}.acquire();
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_cleanup(const State&) override {
    reader_.reset();
    if (stop_ >= 0) {
      clear_safe_stop();
      ::close(std::exchange(stop_, -1));
    }
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_error(const State& state) override { return on_cleanup(state); }

  void say() {
    auto message = alive_->borrow();
    if (!message) return;
    message->data = get<std::string>("note");
    alive_->publish(std::move(message));
  }

  void obey(const std::string& order) {
    if (order == "throw") throw std::runtime_error("told to throw");
    if (order == "fault") return fault("TOLD_TO", "a fault on command");
    if (order == "hang") std::binary_semaphore{0}.acquire();
    if (order == "thread") {
      reader_ = std::make_unique<io::ReaderThread>(
          line_, steady_clock(), sink_,
          io::ReaderThread::Options{.name = "chaos_rx",
                                    .on_exception = [this](const std::string& text) { fault("READER_ENDED", text); }});
    }
    if (order == "crash") *nowhere_ = 1;
    if (order == "abort") std::thread{[] { throw std::runtime_error("uncaught on purpose"); }}.join();
    if (order == "blocked abort") run_with_all_signals_blocked([] { std::abort(); });
    if (order == "overflow") run_with_all_signals_blocked([] { static_cast<void>(go_deeper(0)); });
    if (order == "exit") std::exit(0);
    if (order == "quick exit") std::quick_exit(0);
    if (order == "_exit") ::_exit(0);
    if (order == "leak") leaked_.emplace_back(64UL << 20U, 'x');
    if (order == "flood") {
      const MonotonicTime until = steady_clock().now() + 500ms;
      while (steady_clock().now() < until) say();
    }
    if (order == "lie") lie_ = create_publisher<String>("/scan", QoS(10));
    if (order == "spin") {
      spin_ = create_wall_timer(1ms, [this] {
        const MonotonicTime until = steady_clock().now() + 100ms;
        while (steady_clock().now() < until) turns_ = turns_ + 1;
      });
    }
    if (order == "close") {
      for (int other = 3; other < 1024; ++other) {
        if (other != stop_) ::close(other);
      }
    }
    if (order == "hoard") {
      for (int more = 0; (more = ::open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0;) hoard_.emplace_back(more);
    }
    if (order == "reset") {
      hoard_.clear();
      spin_.reset();
      lie_.reset();
      leaked_.clear();
    }
  }

  Publisher<String>::SharedPtr alive_, lie_;
  Subscription<String>::SharedPtr orders_;
  Service<std_srvs::srv::SetBool>::SharedPtr answers_;
  Timer::SharedPtr beat_, spin_;
  BadLine line_;
  NoSink sink_;
  std::unique_ptr<io::ReaderThread> reader_;
  std::vector<std::string> leaked_;
  std::vector<io::Descriptor> hoard_;
  volatile int* nowhere_ = nullptr;
  volatile std::uint64_t turns_ = 0;
  int stop_ = -1;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Chaos)
