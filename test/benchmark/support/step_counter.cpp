// SPDX-License-Identifier: Apache-2.0
#include "support/step_counter.hpp"

#include <elf.h>
#include <sys/auxv.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <unordered_map>

namespace nacelle::bench {
namespace {

std::atomic<int> marks_to{-1};  // the child's end of the pipe that carries the traced thread's id
std::atomic<bool> marked{false};

enum class Kind : std::uint8_t { Plain, Locked, Syscall };

#if defined(__x86_64__)
// Source: Intel SDM volume 2, 2.1 (instruction format): legacy prefixes, REX, opcode.
Kind kind_of(const unsigned char* bytes) {
  int at = 0;
  bool lock = false;
  for (; at < 14; ++at) {
    const unsigned char b = bytes[at];
    if (b == 0xF0) lock = true;
    const bool prefix = b == 0xF0 || b == 0xF2 || b == 0xF3 || b == 0x66 || b == 0x67 || b == 0x2E || b == 0x36 ||
                        b == 0x3E || b == 0x26 || b == 0x64 || b == 0x65;
    if (!prefix) break;
  }
  if ((bytes[at] & 0xF0) == 0x40) ++at;
  if (lock) return Kind::Locked;
  if (bytes[at] == 0x0F && bytes[at + 1] == 0x05) return Kind::Syscall;
  // XCHG with memory locks without being asked to.
  if ((bytes[at] == 0x86 || bytes[at] == 0x87) && bytes[at + 1] < 0xC0) return Kind::Locked;
  return Kind::Plain;
}
std::uint64_t instruction_pointer(pid_t thread) {
  user_regs_struct registers{};
  iovec where{&registers, sizeof registers};
  ptrace(PTRACE_GETREGSET, thread, NT_PRSTATUS, &where);
  return registers.rip;
}
#elif defined(__aarch64__)
// Source: Arm ARM C4.1, "Loads and stores": exclusive loads, compare and swap, atomic memory operations.
Kind kind_of(const unsigned char* bytes) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes, sizeof word);
  if ((word & 0xFFE0001F) == 0xD4000001) return Kind::Syscall;
  const bool exclusive_load = (word & 0x3FE00000) == 0x08400000;
  const bool compare_and_swap = (word & 0x3FA07C00) == 0x08A07C00;
  const bool memory_operation = (word & 0x3F200C00) == 0x38200000;
  return exclusive_load || compare_and_swap || memory_operation ? Kind::Locked : Kind::Plain;
}
std::uint64_t instruction_pointer(pid_t thread) {
  user_pt_regs registers{};
  iovec where{&registers, sizeof registers};
  ptrace(PTRACE_GETREGSET, thread, NT_PRSTATUS, &where);
  return registers.pc;
}
#endif

Kind kind_at(pid_t thread, std::uint64_t address) {
  unsigned char bytes[16] = {};
  // Word by word: 16 bytes at once would fail where an instruction is the last of its page.
  for (int i = 0; i < 2; ++i) {
    errno = 0;
    const long word = ptrace(PTRACE_PEEKTEXT, thread, address + static_cast<std::uint64_t>(i) * sizeof(long), nullptr);
    if (errno == 0) std::memcpy(bytes + static_cast<std::size_t>(i) * sizeof(long), &word, sizeof word);
  }
  return kind_of(bytes);
}

// The kernel's own library has one address in parent and child: a fork copies the map.
bool is_in_vdso(std::uint64_t address) {
  constexpr std::uint64_t kVdsoBytes = 16384;
  static const std::uint64_t begin = getauxval(AT_SYSINFO_EHDR);
  return begin != 0 && address >= begin && address < begin + kVdsoBytes;
}

Steps follow(pid_t thread) {
  Steps steps;
  bool was_in_vdso = false;
  int status = 0;
  if (waitpid(thread, &status, __WALL) != thread || !WIFSTOPPED(status)) return steps;
  std::unordered_map<std::uint64_t, Kind> known;
  for (;;) {
    const std::uint64_t at = instruction_pointer(thread);
    auto [entry, is_new] = known.try_emplace(at, Kind::Plain);
    if (is_new) entry->second = kind_at(thread, at);
    if (ptrace(PTRACE_SINGLESTEP, thread, nullptr, nullptr) != 0) return steps;
    if (waitpid(thread, &status, __WALL) != thread || !WIFSTOPPED(status)) return steps;
    if (WSTOPSIG(status) == SIGSTOP) break;
    ++steps.instructions;
    if (entry->second == Kind::Locked) ++steps.locked;
    if (entry->second == Kind::Syscall) ++steps.syscalls;
    const bool in_vdso = is_in_vdso(at);
    if (in_vdso && !was_in_vdso) ++steps.clock_reads;
    was_in_vdso = in_vdso;
  }
  steps.ok = true;
  ptrace(PTRACE_DETACH, thread, nullptr, nullptr);
  return steps;
}

}  // namespace

void mark_steps() {
  const int pipe_end = marks_to.load();
  if (pipe_end < 0) return;
  const auto thread = static_cast<pid_t>(syscall(SYS_gettid));
  if (!marked.exchange(true)) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(3);
    if (write(pipe_end, &thread, sizeof thread) != sizeof thread) _exit(3);
  }
  syscall(SYS_tgkill, getpid(), thread, SIGSTOP);
}

Steps count_steps(const std::function<void()>& work) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    marks_to = ends[1];
    work();
    _exit(0);
  }
  close(ends[1]);
  Steps steps;
  pid_t thread = 0;
  if (child > 0 && read(ends[0], &thread, sizeof thread) == sizeof thread) steps = follow(thread);
  close(ends[0]);
  if (child > 0) {
    kill(child, SIGKILL);  // it has reported its result
    waitpid(child, nullptr, 0);
  }
  return steps;
}

}  // namespace nacelle::bench
