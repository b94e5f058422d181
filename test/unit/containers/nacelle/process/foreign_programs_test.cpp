// SPDX-License-Identifier: Apache-2.0
#include "process/foreign_programs.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>

#include "../control/temporary_folder.hpp"

namespace nacelle::process {
namespace {

ProgramSpec shell(const std::string& script) {
  ProgramSpec spec;
  spec.label = "shell";
  spec.path = "/bin/sh";
  spec.arguments = {"-c", script};
  spec.sigterm_after = 300ms;
  spec.sigkill_after = 300ms;
  return spec;
}

class ForeignPrograms : public ::testing::Test {
 public:
  SystemClock clock_;
  TemporaryFolder folder_;
};

TEST_F(ForeignPrograms, are_distinguished_from_missing_ones) {
  ProgramSpec spec;
  spec.label = spec.path = "no-such-program-of-ours";
  auto started = ForeignProgram::start(spec);
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().text().find("no-such-program-of-ours"), std::string::npos);
}

TEST_F(ForeignPrograms, are_ready_when_they_say_so_with_their_own_number) {
  ProgramSpec spec = shell("echo 1 > ready; echo $$ > ready.new; mv ready.new ready; read forever < pipe");
  spec.working_directory = folder_.path();
  spec.ready_file = folder_.path() + "/ready";
  ASSERT_EQ(::mkfifo((folder_.path() + "/pipe").c_str(), 0600), 0);
  auto program = ForeignProgram::start(spec);
  ASSERT_TRUE(program);
  const auto ready = program.value()->wait_until_ready(10s, -1, clock_);
  EXPECT_TRUE(ready) << ready.error().text();
  EXPECT_EQ(program.value()->ended(), "");
  EXPECT_EQ(program.value()->stop(clock_), "killed by signal 2 (Interrupt)");
}

TEST_F(ForeignPrograms, that_end_before_they_are_ready_are_a_problem) {
  ProgramSpec spec = shell("exit 7");
  spec.ready_file = folder_.path() + "/ready";
  auto program = ForeignProgram::start(spec);
  ASSERT_TRUE(program);
  const auto ready = program.value()->wait_until_ready(10s, -1, clock_);
  ASSERT_FALSE(ready);
  EXPECT_NE(ready.error().what.find("exited with 7"), std::string::npos);
}

TEST_F(ForeignPrograms, that_ignore_every_wish_are_killed_with_their_children) {
  ProgramSpec spec =
      shell("trap '' INT TERM; echo $$ > ready.new; mv ready.new ready; while :; do read x < pipe; done");
  spec.working_directory = folder_.path();
  spec.ready_file = folder_.path() + "/ready";
  ASSERT_EQ(::mkfifo((folder_.path() + "/pipe").c_str(), 0600), 0);
  auto program = ForeignProgram::start(spec);
  ASSERT_TRUE(program);
  ASSERT_TRUE(program.value()->wait_until_ready(10s, -1, clock_));
  const pid_t group = program.value()->pid();
  EXPECT_EQ(program.value()->stop(clock_), "killed by signal 9 (Killed)");
  EXPECT_NE(::kill(-group, 0), 0) << "no process of its group is left";
}

TEST_F(ForeignPrograms, get_the_environment_that_was_asked_for) {
  ::setenv("NACELLE_TEST_GONE", "1", 1);
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  ProgramSpec spec = shell("echo \"$NACELLE_TEST_SET:$NACELLE_TEST_GONE:$HOME\"");
  spec.environment = {{"NACELLE_TEST_SET", "a b"}, {"NACELLE_TEST_GONE", std::nullopt}, {"HOME", "/nowhere"}};
  spec.output_descriptor = ends[1];
  auto program = ForeignProgram::start(spec);
  ::close(ends[1]);
  ASSERT_TRUE(program);
  std::string said;
  std::array<char, 100> room{};
  for (ssize_t got = 0; (got = ::read(ends[0], room.data(), room.size())) > 0;)
    said.append(room.data(), static_cast<std::size_t>(got));
  ::close(ends[0]);
  EXPECT_EQ(said, "a b::/nowhere\n");
}

TEST_F(ForeignPrograms, get_no_descriptor_that_is_not_meant_for_them) {
  // As a library opens its sockets that does not close them for programs.
  std::array<int, 2> leaky{};
  ASSERT_EQ(::pipe(leaky.data()), 0);
  auto program = ForeignProgram::start(shell("exec cat /dev/zero > /dev/null"));
  ASSERT_TRUE(program);
  ::close(leaky[1]);
  // The pipe ends only if no process has its other side any more.
  std::array<char, 1> room{};
  EXPECT_EQ(::read(leaky[0], room.data(), room.size()), 0);
  ::close(leaky[0]);
}

TEST_F(ForeignPrograms, do_not_outlive_their_object) {
  pid_t pid = 0;
  {
    auto program = ForeignProgram::start(shell("exec cat /dev/zero > /dev/null"));
    ASSERT_TRUE(program);
    pid = program.value()->pid();
    EXPECT_EQ(::kill(pid, 0), 0);
  }
  EXPECT_NE(::kill(pid, 0), 0);
}

}  // namespace
}  // namespace nacelle::process
