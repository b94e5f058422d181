// SPDX-License-Identifier: Apache-2.0
#include "syscall_guard.hpp"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdlib>

namespace nacelle::test {

bool allow_only_syscalls(std::initializer_list<long> numbers) {
  // Load the call's number; for each that is allowed: if it is this one, go to the last line. Source: seccomp(2).
  std::array<sock_filter, 32> lines{};
  std::size_t n = 0;
  const std::size_t calls = numbers.size() + 1;
  if (calls + 3 > lines.size()) return false;
  lines[n++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
  const auto allow = [&](long number) {
    const auto to_end = static_cast<std::uint8_t>(calls + 1 - n);
    lines[n++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(number), to_end, 0);
  };
  for (const long number : numbers) allow(number);
  allow(SYS_exit_group);
  lines[n++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS);
  lines[n++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  const sock_fprog program{static_cast<unsigned short>(n), lines.data()};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

void end_child(int code) {
  ::syscall(SYS_exit_group, code);
  std::abort();
}

std::string run_in_child(const std::function<void()>& what) {
  const pid_t child = ::fork();
  if (child < 0) return "fork() failed";
  if (child == 0) {
    what();
    end_child(99);
  }
  int status = 0;
  if (::waitpid(child, &status, 0) != child) return "waitpid() failed";
  if (WIFSIGNALED(status)) {
    return WTERMSIG(status) == SIGSYS ? "made a system call that was not allowed"
                                      : "ended by signal " + std::to_string(WTERMSIG(status));
  }
  return WEXITSTATUS(status) == 0 ? "" : "ended with code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace nacelle::test
