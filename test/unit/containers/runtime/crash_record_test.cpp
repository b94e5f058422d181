// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/crash_record.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
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

#include "executor_fixture.hpp"
#include "nacelle/runtime/executor.hpp"
#include "runtime/src/safe_stop.hpp"

namespace nacelle::runtime {
namespace {

using ::testing::HasSubstr;

constexpr std::uint8_t kFrame[] = {'S', 'T', 'O', 'P'};

struct CrashRecordTest : ::testing::Test {
  std::string folder = ::testing::TempDir() + "nacelle-crash-XXXXXX";
  CrashRecordTest() { EXPECT_NE(::mkdtemp(folder.data()), nullptr); }
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
  /// Runs it in a process of its own; returns the signal that ended that.
  int signal_of(const std::function<void()>& fatal) const {
    const pid_t child = ::fork();
    if (child == 0) {
      for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT})
        ::signal(number, SIG_DFL);  // a sanitizer's would exit
      const rlimit none{0, 0};
      ::setrlimit(RLIMIT_CORE, &none);
      const int nowhere = ::open("/dev/null", O_WRONLY);
      ::dup2(nowhere, STDERR_FILENO);
      const CrashHandler handler{folder + "/record", "box"};
      SafeStop stop{"/base"};
      stop.set(::open((folder + "/line").c_str(), O_WRONLY | O_CREAT, 0600), {kFrame, sizeof kFrame});
      fatal();
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }
};

// Runs a callback on an executor until the process ends.
void run_on_executor(const std::function<void()>& fatal) {
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
  EXPECT_EQ(text_of("/line"), "STOPSTOP") << "before and after the record";
  EXPECT_EQ(line("container"), "box");
  EXPECT_EQ(line("signal"), "SIGSEGV at address 0x0");
  EXPECT_EQ(line("thread"), "executor");
  EXPECT_EQ(line("safe stops written"), "1");
  EXPECT_EQ(line("component"), "/lidar");
  EXPECT_EQ(line("callback"), "subscription /scan");
  EXPECT_EQ(line("stream"), "/scan");
  EXPECT_THAT(line("library"), HasSubstr(" +0x"));
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

#ifndef NACELLE_SANITIZED
[[gnu::noinline]] std::uint64_t deeper(std::uint64_t depth) {
  volatile std::uint8_t room[4096];
  room[0] = 1;
  return depth == ~std::uint64_t{0} ? 0 : deeper(depth + 1) + room[0];
}

TEST_F(CrashRecordTest, a_stack_that_is_full_leaves_a_record_too) {
  EXPECT_EQ(signal_of([] { run_on_executor([] { static_cast<void>(deeper(0)); }); }), SIGSEGV);
  EXPECT_EQ(line("component"), "/lidar");
  EXPECT_EQ(text_of("/line"), "STOPSTOP") << "before and after the record";
}
#endif

TEST_F(CrashRecordTest, a_stderr_that_nobody_reads_does_not_keep_the_process_alive) {
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
