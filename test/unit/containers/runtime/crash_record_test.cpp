// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/crash_record.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <semaphore>
#include <sstream>
#include <thread>

#include "executor_fixture.hpp"
#include "nacelle/runtime/executor.hpp"
#include "nacelle/runtime/thread_guard.hpp"
#include "runtime/src/safe_stop.hpp"

namespace nacelle::runtime {
namespace {

using ::testing::HasSubstr;

constexpr std::uint8_t kFrame[] = {'S', 'T', 'O', 'P'};
// Before and after the record, and when the process has ended.
constexpr const char* kThreeStops = "STOPSTOPSTOP";

struct CrashRecordTest : ::testing::Test {
  std::string folder = ::testing::TempDir() + "nacelle-crash-XXXXXX";
  CrashRecordTest() {
    static_cast<void>(guard_threads());
    EXPECT_NE(::mkdtemp(folder.data()), nullptr);
  }
  ~CrashRecordTest() override {
    for (const char* name : {"/record", "/line"}) ::unlink((folder + name).c_str());
    ::rmdir(folder.c_str());
  }
  [[nodiscard]] std::string text_of(const std::string& name) const {
    std::ifstream file(folder + name);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  [[nodiscard]] std::string line(const char* key) const { return crash_record_line(text_of("/record"), key); }
  /// Runs it in a process of its own; returns the signal that ended that, once the watcher of that process has ended, too.
  int signal_of(const std::function<void()>& fatal) const { return WTERMSIG(status_of(fatal)); }
  /// The same, as waitpid() has it.
  int status_of(const std::function<void()>& fatal) const {
    std::array<int, 2> lives{};  // the other end is open for as long as one of the two processes lives
    EXPECT_EQ(::pipe2(lives.data(), O_CLOEXEC), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT})
        ::signal(number, SIG_DFL);  // a sanitizer's would exit
      const rlimit none{0, 0};
      ::setrlimit(RLIMIT_CORE, &none);
      ::close(lives[0]);
      const int nowhere = ::open("/dev/null", O_WRONLY);
      ::dup2(nowhere, STDERR_FILENO);
      const CrashHandler handler{folder + "/record", "box"};
      SafeStop stop{"/base"};
      stop.set(::open((folder + "/line").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), {kFrame, sizeof kFrame});
      fatal();
      ::_exit(0);
    }
    ::close(lives[1]);
    char none = 0;
    EXPECT_EQ(::read(lives[0], &none, 1), 0);
    ::close(lives[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    return status;
  }
};

// Runs a callback on an executor until the process ends.
void run_on_executor(const std::function<void()>& fatal) {
  const SafeStop known{"/lidar"};
  const SystemClock clock;
  Executor executor{"executor", clock, {}};
  NodeGroups node{executor, "/lidar", [](const auto&...) {}};
  CallbackGroup group{node};
  executor.open(node);
  Callable callback(group, fatal);
  callback.describe_as("subscription", "/scan");
  executor.post(callback);
  std::binary_semaphore{0}.acquire();
}

TEST_F(CrashRecordTest, names_component_callback_stream_and_place_after_the_wheels_are_stopped) {
  const int number = signal_of([] {
    run_on_executor([] {
      volatile std::uintptr_t zero = 0;  // which no tool takes for a mistake
      *std::bit_cast<volatile int*>(std::uintptr_t{zero}) = 1;
    });
  });

  EXPECT_EQ(number, SIGSEGV);
  EXPECT_EQ(text_of("/line"), kThreeStops);
  EXPECT_EQ(line("container"), "box");
  EXPECT_EQ(line("signal"), "SIGSEGV at address 0x0");
  EXPECT_EQ(line("thread"), "executor");
  EXPECT_EQ(line("safe stops written"), "1");
  EXPECT_EQ(line("component"), "/lidar");
  EXPECT_EQ(line("callback"), "subscription /scan");
  EXPECT_EQ(line("stream"), "/scan");
  EXPECT_THAT(line("library"), HasSubstr(" +0x"));
  EXPECT_THAT(line("component age"), ::testing::MatchesRegex("[0-9]+ ms since it was loaded"));
  EXPECT_THAT(text_of("/record"), HasSubstr("\nend\n"));
}

TEST_F(CrashRecordTest, an_abort_and_a_signal_from_outside_take_their_course) {
  EXPECT_EQ(signal_of([] { std::abort(); }), SIGABRT);
  EXPECT_EQ(line("signal"), "SIGABRT");
  EXPECT_EQ(line("component"), "") << "no component ran";
  EXPECT_EQ(signal_of([] { ::kill(::getpid(), SIGBUS); }), SIGBUS);
  EXPECT_THAT(line("signal"), HasSubstr("SIGBUS"));
  EXPECT_EQ(signal_of([] { ::raise(SIGFPE); }), SIGFPE);
}

TEST_F(CrashRecordTest, a_call_of_exit_writes_the_stops_and_a_record_and_fails) {
  const int ended = status_of([] { run_on_executor([] { std::exit(0); }); });
  EXPECT_TRUE(WIFEXITED(ended));
  EXPECT_EQ(WEXITSTATUS(ended), 1) << "the container that starts it anew must see a failure";
  EXPECT_EQ(line("signal"), "exit(0) was called");
  EXPECT_EQ(line("component"), "/lidar");
  EXPECT_EQ(line("callback"), "subscription /scan");
  EXPECT_EQ(text_of("/line"), kThreeStops);
#ifndef NACELLE_SANITIZED  // that build has no guard, and at_quick_exit() does not pass the status
  EXPECT_EQ(WEXITSTATUS(status_of([] { std::quick_exit(3); })), 3);
  EXPECT_EQ(line("signal"), "quick_exit(3) was called");
#endif
}

TEST_F(CrashRecordTest, a_process_that_is_forked_off_may_call_exit) {
  const int ended = status_of([] {
    const pid_t forked = ::fork();
    if (forked == 0) std::quick_exit(0);
    ::waitpid(forked, nullptr, 0);
  });
  EXPECT_EQ(ended, 0);
  EXPECT_EQ(text_of("/record"), "");
}

TEST_F(CrashRecordTest, the_watcher_stops_the_wheels_when_no_handler_runs) {
  EXPECT_EQ(signal_of([] { ::raise(SIGKILL); }), SIGKILL);
  EXPECT_EQ(text_of("/line"), "STOP");
  ::unlink((folder + "/line").c_str());
  EXPECT_EQ(status_of([] { run_on_executor([] { ::_exit(0); }); }), 0);
  EXPECT_EQ(text_of("/line"), "STOP");
  EXPECT_EQ(text_of("/record"), "") << "only the watcher knew";
}

TEST_F(CrashRecordTest, the_watcher_writes_every_frame_of_a_component) {
  EXPECT_EQ(status_of([this] {
              SafeStop wheels{"/wheels"};
              for (const char* wheel : {"/left", "/right"})
                wheels.set(::open((folder + wheel).c_str(), O_WRONLY | O_CREAT, 0600), {kFrame, sizeof kFrame});
              ::raise(SIGKILL);
            }),
            SIGKILL);
  EXPECT_EQ(text_of("/left"), "STOP");
  EXPECT_EQ(text_of("/right"), "STOP");
}

TEST_F(CrashRecordTest, the_watcher_writes_no_frame_that_was_cleared_and_ends_with_its_handler) {
  EXPECT_EQ(status_of([this] {
              SafeStop gone{"/gone"};
              gone.set(::open((folder + "/line").c_str(), O_WRONLY), {kFrame, 2});
              gone.clear();
              { const SafeStop again{"/again"}; }
              ::raise(SIGKILL);
            }),
            SIGKILL);
  EXPECT_EQ(text_of("/line"), "STOP");
  { const CrashHandler handler{"", "box"}; }
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG | __WALL), -1) << "its process is gone";
}

#ifndef NACELLE_SANITIZED
// As a library's threads begin that leave all signals to the main thread (Cyclone DDS, iceoryx).
void run_with_all_signals_blocked(const std::function<void()>& fatal) {
  sigset_t all;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
  std::thread thread{fatal};
  thread.join();
}

TEST_F(CrashRecordTest, a_thread_that_blocks_all_signals_leaves_a_record) {
  EXPECT_EQ(signal_of([] { run_with_all_signals_blocked([] { std::abort(); }); }), SIGABRT);
  EXPECT_EQ(line("signal"), "SIGABRT");
  EXPECT_EQ(text_of("/line"), kThreeStops);
  EXPECT_EQ(signal_of([] {
              run_with_all_signals_blocked([] {
                sigset_t all;
                sigfillset(&all);
                ::sigprocmask(SIG_BLOCK, &all, nullptr);
                volatile std::uintptr_t zero = 0;
                *std::bit_cast<volatile int*>(std::uintptr_t{zero}) = 1;
              });
            }),
            SIGSEGV);
  EXPECT_EQ(line("signal"), "SIGSEGV at address 0x0");
}

TEST_F(CrashRecordTest, a_thread_that_the_guard_does_not_reach_is_the_watchers) {
  EXPECT_EQ(signal_of([] {
              std::uint64_t all = ~std::uint64_t{0};
              ::syscall(SYS_rt_sigprocmask, SIG_SETMASK, &all, nullptr, sizeof all);
              volatile std::uintptr_t zero = 0;
              *std::bit_cast<volatile int*>(std::uintptr_t{zero}) = 1;
            }),
            SIGSEGV);
  EXPECT_EQ(text_of("/line"), "STOP");
  EXPECT_EQ(text_of("/record"), "");
}

[[gnu::noinline]] std::uint64_t deeper(std::uint64_t depth) {
  volatile std::uint8_t room[4096];
  room[0] = 1;
  return depth == ~std::uint64_t{0} ? 0 : deeper(depth + 1) + room[0];
}

TEST_F(CrashRecordTest, a_stack_that_is_full_leaves_a_record_too) {
  EXPECT_EQ(signal_of([] { run_on_executor([] { static_cast<void>(deeper(0)); }); }), SIGSEGV);
  EXPECT_EQ(line("component"), "/lidar");
  EXPECT_EQ(text_of("/line"), kThreeStops);
}

TEST_F(CrashRecordTest, a_full_stack_of_a_foreign_thread_leaves_a_record_too) {
  EXPECT_EQ(signal_of([] { run_with_all_signals_blocked([] { static_cast<void>(deeper(0)); }); }), SIGSEGV);
  EXPECT_EQ(text_of("/line"), kThreeStops);
  EXPECT_THAT(line("symbol"), HasSubstr("deeper")) << text_of("/record");
  EXPECT_EQ(signal_of([] { static_cast<void>(deeper(0)); }), SIGSEGV) << "the main thread";
  EXPECT_EQ(text_of("/line"), kThreeStops);
}
#endif

TEST_F(CrashRecordTest, a_blocked_stderr_does_not_keep_the_process_alive) {
  EXPECT_EQ(signal_of([] {
              std::array<int, 2> ends{};
              if (::pipe(ends.data()) != 0) ::_exit(1);
              ::fcntl(ends[1], F_SETFL, O_NONBLOCK);
              while (::write(ends[1], "x", 1) == 1) {}
              ::fcntl(ends[1], F_SETFL, 0);
              ::dup2(ends[1], STDERR_FILENO);
              // As threads of a library may do that leave all signals to the main thread.
              sigset_t all;
              sigfillset(&all);
              if (!guard_threads()) sigdelset(&all, SIGABRT);  // abort() of glibc 2.41 would not reach the handler
              ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
              std::abort();
            }),
            SIGALRM);
  EXPECT_EQ(text_of("/line").substr(0, 4), "STOP");
}

TEST_F(CrashRecordTest, the_handlers_from_before_come_back) {
  struct sigaction before {
  }, after{};
  ::sigaction(SIGSEGV, nullptr, &before);
  { const CrashHandler handler{"", "box"}; }
  ::sigaction(SIGSEGV, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
}

TEST(CrashRecordLine, is_what_stands_behind_the_word) {
  const std::string record = "nacelle crash record\nsignal: SIGSEGV\ncomponent: \nlibrary: a +0x1";
  EXPECT_EQ(crash_record_line(record, "signal"), "SIGSEGV");
  EXPECT_EQ(crash_record_line(record, "component"), "");
  EXPECT_EQ(crash_record_line(record, "library"), "a +0x1");
  EXPECT_EQ(crash_record_line(record, "stream"), "");
  EXPECT_EQ(crash_record_line("", "signal"), "");
}

TEST(SafeStops, all_of_the_process_are_written_and_those_that_are_cleared_are_not) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  SafeStop one{"/one"}, two{"/two"};
  one.set(ends[1], {kFrame, 2});
  two.set(ends[1], {kFrame, 4});

  EXPECT_EQ(write_all_safe_stops(), 2U);
  two.clear();
  EXPECT_EQ(write_all_safe_stops(), 1U);

  char text[16] = {};
  EXPECT_EQ(::read(ends[0], text, sizeof text), 8);
  EXPECT_TRUE(two.was_ever_set());
  ::close(ends[0]);
  ::close(ends[1]);
}

// PWM channels of the kernel are files, one a wheel.
TEST(SafeStops, a_component_with_several_descriptors_has_a_frame_for_each) {
  int ends[2], others[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::pipe(others), 0);
  const auto said = [](int end) {
    char text[16] = {};
    ::fcntl(end, F_SETFL, O_NONBLOCK);
    return std::string(text, static_cast<std::size_t>(std::max<ssize_t>(::read(end, text, sizeof text), 0)));
  };
  {
    SafeStop base{"/base"};
    base.set(ends[1], {kFrame, 2});
    base.set(others[1], {kFrame, 2});
    base.set(ends[1], {kFrame, 4});
    EXPECT_EQ(write_all_safe_stops(), 2U);
    EXPECT_EQ(said(ends[0]), "STOP") << "in place of the earlier one";
    EXPECT_EQ(said(others[0]), "ST");
    base.write();
    EXPECT_EQ(said(ends[0]) + said(others[0]), "STOPST");
    base.clear();
    EXPECT_EQ(write_all_safe_stops(), 0U);
    base.set(others[1], {kFrame, 4});
    EXPECT_EQ(write_all_safe_stops(), 1U);
    EXPECT_EQ(said(others[0]), "STOP");
    base.set(ends[1], {kFrame, 4});
  }
  EXPECT_EQ(write_all_safe_stops(), 0U) << "its entries are free again";
  for (const int end : {ends[0], ends[1], others[0], others[1]}) ::close(end);
}

// A CAN socket takes one frame a write, and refuses two in one: a base with a board a wheel would stop one wheel, or none.
TEST(SafeStops, a_frame_of_several_writes_is_written_piece_by_piece) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends), 0);
  const auto next = [&] {
    char text[16] = {};
    const ssize_t count = ::recv(ends[0], text, sizeof text, MSG_DONTWAIT);
    return std::string(text, count > 0 ? static_cast<std::size_t>(count) : 0);
  };
  SafeStop base{"/base"};
  base.set(ends[1], {kFrame, 4}, 2);
  EXPECT_EQ(write_all_safe_stops(), 1U);
  EXPECT_EQ(next(), "ST");
  EXPECT_EQ(next(), "OP");
  EXPECT_EQ(next(), "");

  base.set(ends[1], {kFrame, 4});
  EXPECT_EQ(write_all_safe_stops(), 1U);
  EXPECT_EQ(next(), "STOP") << "in one write where the descriptor is no CAN socket";
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST(SafeStops, an_entry_is_given_back_and_used_again) {
  const auto count = [] {
    std::size_t n = 0;
    for (const CrashEntry* entry = first_crash_entry(); entry != nullptr; entry = entry->next) ++n;
    return n;
  };
  { const SafeStop warm{"/warm"}; }
  const std::size_t before = count();
  for (int i = 0; i < 100; ++i) const SafeStop again{"/again"};
  EXPECT_EQ(count(), before);
}

}  // namespace
}  // namespace nacelle::runtime
