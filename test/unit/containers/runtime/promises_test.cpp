// SPDX-License-Identifier: Apache-2.0
// What design D4 promises of each message in the steady state, counted on the whole way from borrow() to the callback, in a
// container as the program runs it.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sensor_msgs/msg/image.hpp>
#include <string>
#include <utility>

#include "benchmark/support/recipe.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/allocation_guard.hpp"
#include "support/places.hpp"
#include "support/syscall_guard.hpp"

namespace nacelle::runtime {
namespace {

using sensor_msgs::msg::Image;

constexpr int kWarm = 200, kRounds = 2000;

struct Way {
  const char* name;
  bool across;       // the second player has a thread of its own
  const char* take;  // the callback's signature
};
void PrintTo(const Way& way, std::ostream* out) { *out << way.name; }

/// What the child has counted, in memory that the parent sees.
struct Counts {
  std::uint64_t mallocs, copies, messages;
};

/// Tells when the thread that supervises the executors has slept through a number of looks. It checks the executors when it starts, with
/// their locks held; on a busy machine it gets a core for that only after the game has begun, and if it loses the core again in those
/// 100 ns, the game waits for the lock by a system call.
class SupervisorAtRest {
 public:
  [[nodiscard]] bool look() {
    if (status_.empty()) find();
    std::ifstream file(status_);
    std::string now;
    bool sleeps = false;
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("State:")) sleeps = line.find('S', 6) != std::string::npos;
      if (line.find("ctxt_switches") != std::string::npos) now += line;
    }
    quiet_ = sleeps && now == before_ ? quiet_ + 1 : 0;
    before_ = now;
    return quiet_ >= kLooks;
  }

 private:
  static constexpr int kLooks = 50;
  static constexpr int kMostSearches = 100000;

  // A thread gives itself its name, when it first runs.
  void find() {
    if (++searches_ > kMostSearches) test::end_child(95);
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
      std::string name;
      std::ifstream(task.path() / "comm") >> name;
      if (name == "supervisor") status_ = task.path() / "status";
    }
  }

  std::filesystem::path status_;
  std::string before_;
  int quiet_ = 0;
  int searches_ = 0;
};

/// Plays each ball back: two of these keep one message under way.
class Player final : public bench::Recipe {
 public:
  Player(const Way& way, std::string from, std::string to, Counts* counts)
      : way_(way), from_(std::move(from)), to_(std::move(to)), counts_(counts) {}

  std::shared_ptr<void> build(LifecycleNode& node) override {
    to_publisher_ = node.create_publisher<Image>(to_, QoS(10));
    const std::string_view take = way_.take;
    if (take == "shared")
      return node.create_subscription<Image>(from_, QoS(10),
                                             [this](std::shared_ptr<const Image> m) { play(m->height); });
    if (take == "loan")
      return node.create_subscription<Image>(from_, QoS(10), [this](Loan<Image> m) { play(m->height); });
    return node.create_subscription<Image>(from_, QoS(10), [this](const Image& m) { play(m.height); });
  }

 private:
  void play(std::uint32_t round) {
    if (!steady_ && round >= kWarm && may_begin()) begin(round);
    if (counts_ != nullptr && steady_ && round >= begun_ + kRounds) end();
    Loan<Image> image = to_publisher_->borrow();
    image->height = round + 1;
    image->data.resize(std::size_t{640} * 480);
    to_publisher_->publish(std::move(image));
  }
  // One player looks, for both: the other one may share its thread, which can open no file once it has begun.
  bool may_begin() {
    static std::atomic<bool> supervisor_rests{false};
    if (counts_ != nullptr && supervisor_.look()) supervisor_rests = true;
    return supervisor_rests;
  }
  void begin(std::uint32_t round) {
    steady_ = true;
    begun_ = round;
    guard_.emplace();
    before_ = to_publisher_->counters();
    thread_local bool is_guarded = false;  // two players may share a thread
    if (std::exchange(is_guarded, true)) return;
    // Reading a thread's CPU clock is a system call: one callback in 128 or so is measured, and pays it.
    const bool filtered = way_.across ? test::allow_only_syscalls({SYS_clock_gettime, SYS_futex})
                                      : test::allow_only_syscalls({SYS_clock_gettime});
    if (!filtered) test::end_child(98);
  }
  void end() {
    const auto after = to_publisher_->counters();
    *counts_ = {guard_->count(), after.copies - before_.copies, after.published - before_.published};
    test::end_child(0);
  }

  const Way way_;
  const std::string from_, to_;
  Counts* const counts_;  // of the player that ends the game
  std::shared_ptr<Publisher<Image>> to_publisher_;
  bool steady_ = false;
  std::uint32_t begun_ = 0;
  SupervisorAtRest supervisor_;
  std::optional<test::AllocationGuard> guard_;
  WriterCounters before_;
};

void play_in_a_container(const Way& way, Counts* counts) {
  const SystemClock clock;
  ContainerOptions options;
  options.component_path = {test::component_folder()};
  // A busy machine must not make a callback look late: taking its place is a call to another thread.
  options.handover_after = options.hang_after = 1h;
  Container container{options, clock};
  Player first{way, "/pong", "/ping", counts}, second{way, "/ping", "/pong", nullptr};
  for (auto* player : {&first, &second}) {
    LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = player == &first ? "first" : "second";
    request.parameters = {
        {"recipe", static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(static_cast<bench::Recipe*>(player)))}};
    request.thread.own = way.across && player == &second;
    const auto loaded = container.load(request);
    if (!loaded) test::end_child(97);
    for (const auto transition : {Transition::Configure, Transition::Activate}) {
      if (!container.trigger(loaded.value().id, transition).success) test::end_child(96);
    }
  }
  const auto server = container.transport().create_writer({"/pong", &Image::message_type(), QoS(10), "/server"});
  server->publish(*server->borrow());
  for (;;) ::pause();
}

#ifdef NACELLE_SANITIZED
constexpr bool kUnderSanitizer = true;
#else
constexpr bool kUnderSanitizer = false;
#endif

class Promises : public ::testing::TestWithParam<Way> {};

TEST_P(Promises, a_message_costs_no_malloc_no_copy_and_no_system_call_but_to_sleep_and_wake) {
  if (kUnderSanitizer) GTEST_SKIP() << "a sanitizer's heap and system calls are its own";
  const std::string refused = test::run_in_child([] { test::end_child(test::allow_only_syscalls({}) ? 0 : 98); });
  if (!refused.empty())
    GTEST_SKIP() << "SKIPPED, NOTHING WAS TESTED: this kernel refuses seccomp filters: the child " << refused;
  auto* const counts =
      static_cast<Counts*>(::mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(counts, MAP_FAILED);
  EXPECT_EQ(test::run_in_child([&] { play_in_a_container(GetParam(), counts); }), "");
  EXPECT_GE(counts->messages, static_cast<std::uint64_t>(kRounds) / 2);
  EXPECT_EQ(counts->mallocs, 0U);
  EXPECT_EQ(counts->copies, 0U);
  ::munmap(counts, sizeof(Counts));
}

INSTANTIATE_TEST_SUITE_P(OnEveryWay, Promises,
                         ::testing::Values(Way{"inline_const_ref", false, "const_ref"},
                                           Way{"inline_shared", false, "shared"}, Way{"inline_loan", false, "loan"},
                                           Way{"across_const_ref", true, "const_ref"},
                                           Way{"across_shared", true, "shared"}, Way{"across_loan", true, "loan"}),
                         [](const auto& way) { return std::string(way.param.name); });

TEST(SyscallGuard, catches_one_call) {
  if (kUnderSanitizer) GTEST_SKIP() << "a sanitizer's system calls are its own";
  EXPECT_EQ(test::run_in_child([] {
              if (!test::allow_only_syscalls({})) test::end_child(98);
              ::syscall(SYS_getppid);
              test::end_child(0);
            }),
            "made a system call that was not allowed");
  EXPECT_EQ(test::run_in_child([] {
              if (!test::allow_only_syscalls({SYS_getppid})) test::end_child(98);
              ::syscall(SYS_getppid);
              test::end_child(0);
            }),
            "");
}

}  // namespace
}  // namespace nacelle::runtime
