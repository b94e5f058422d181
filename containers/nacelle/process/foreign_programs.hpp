// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::process {

/// Where a started program finds ProgramSpec::inherited_descriptor.
inline constexpr int kInheritedDescriptor = 3;

/// A program to start beside the container.
struct ProgramSpec {
  std::string label;  ///< For messages.
  std::string path;   ///< Absolute, or a name to look for in PATH.
  std::vector<std::string> arguments;
  std::vector<std::pair<std::string, std::optional<std::string>>> environment;  ///< Set to, or unset.
  std::string working_directory;
  /// Written by the program when it can be used, with its process id as text; empty: it counts as ready at once.
  std::string ready_file;
  bool required = false;          ///< Its end is the robot's end.
  int inherited_descriptor = -1;  ///< Is the program's kInheritedDescriptor; -1: none.
  int output_descriptor = -1;     ///< Where its stdout and stderr go; -1: where ours go.
  Duration sigterm_after = 3s, sigkill_after = 2s;
};

/// A started program: a process group of its own, so that a Ctrl-C of the terminal reaches us only, and we end it in order.
/// Threads: one. The destructor kills what still runs.
class ForeignProgram {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ForeignProgram>, Problem> start(const ProgramSpec& spec);
  ForeignProgram(const ForeignProgram&) = delete;
  ForeignProgram& operator=(const ForeignProgram&) = delete;
  ~ForeignProgram();

  [[nodiscard]] const ProgramSpec& spec() const { return spec_; }
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Readable when the program has ended (a pidfd); -1 afterwards.
  [[nodiscard]] int descriptor() const { return pidfd_; }
  /// "exited with 1", "killed by SIGSEGV"; empty while it runs. Reaps it.
  [[nodiscard]] std::string ended();
  /// Waits until it is ready. Errors: it ended, the limit passed, or `stop_descriptor` became readable.
  [[nodiscard]] Result<void, Problem> wait_until_ready(Duration limit, int stop_descriptor, const Clock& clock);
  /// False: it still runs after the limit.
  [[nodiscard]] bool wait_for_end(Duration limit, const Clock& clock);
  /// SIGINT as from a terminal, then SIGTERM, then SIGKILL to the group; waits for the end. Returns how it ended.
  std::string stop(const Clock& clock);

 private:
  ForeignProgram(ProgramSpec spec, pid_t pid, int pidfd);

  ProgramSpec spec_;
  pid_t pid_;
  int pidfd_;
  bool reaped_ = false;
  std::string how_;
};

/// SIGKILL to every process group that was started and not reaped. Threads: any; async-signal-safe.
void kill_all_programs() noexcept;

/// "exited with 3", "killed by signal 9 (Killed)".
[[nodiscard]] std::string describe_exit(int status);

}  // namespace nacelle::process
