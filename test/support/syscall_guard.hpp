// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>

namespace nacelle::test {

/// From here on this thread may make these system calls and exit_group(2), and no other: the kernel kills the process (SIGSYS).
/// A promise about system calls is tested so, in a forked child, and without a debugger. Cannot be undone.
/// Errors: false if the kernel refuses the filter.
[[nodiscard]] bool allow_only_syscalls(std::initializer_list<long> numbers);

/// Runs `what` in a child process, which it ends with end_child(), and waits. Returns "" for 0, else how the child ended.
/// Threads: the caller's process must have no other.
[[nodiscard]] std::string run_in_child(const std::function<void()>& what);
/// Ends a child without cleaning up: no further system call.
[[noreturn]] void end_child(int code);

}  // namespace nacelle::test
