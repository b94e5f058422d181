// SPDX-License-Identifier: Apache-2.0
// What design D4 promises of each message in the steady state, counted on the whole way from borrow() to the callback, in a
// container as the program runs it.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <bit>
#include <optional>
#include <sensor_msgs/msg/image.hpp>
#include <utility>

#include "benchmark/support/recipe.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/allocation_guard.hpp"
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
    if (!steady_ && round >= kWarm) begin();
    if (counts_ != nullptr && round >= kWarm + kRounds) end();
    Loan<Image> image = to_publisher_->borrow();
    image->height = round + 1;
    image->data.resize(std::size_t{640} * 480);
    to_publisher_->publish(std::move(image));
  }
  void begin() {
    steady_ = true;
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
  std::optional<test::AllocationGuard> guard_;
  WriterCounters before_;
};

void play_in_a_container(const Way& way, Counts* counts) {
  const SystemClock clock;
  ContainerOptions options;
  options.component_path = {NACELLE_TEST_PLUGINS};
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
  // What the code does is done each time. What a starved machine does is not: the thread that looks after the others holds a
  // lock for a moment, and if it loses its core then (1 of 150 runs beside six busy loops), the game waits for it.
  std::string trouble = "was never run";
  for (int attempt = 0; attempt < 3 && !trouble.empty(); ++attempt)
    trouble = test::run_in_child([&] { play_in_a_container(GetParam(), counts); });
  EXPECT_EQ(trouble, "");
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
