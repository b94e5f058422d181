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

/// The number of ProgramSpec::inherited_descriptor in the started program.
inline constexpr int kInheritedDescriptor = 3;

/// A program to start beside the container.
struct ProgramSpec {
  std::string label;  ///< For messages.
  std::string path;   ///< Absolute, or a name to look for in PATH.
  std::vector<std::string> arguments;
  std::vector<std::pair<std::string, std::optional<std::string>>> environment;  ///< Set to, or unset.
  std::string working_directory;
  /// The program writes its process id to this file, as text, when it is ready. Empty: it counts as ready at once.
  std::string ready_file;
  bool required = false;          ///< If it ends, the robot is shut down.
  int inherited_descriptor = -1;  ///< Becomes the program's kInheritedDescriptor; -1: none.
  int output_descriptor = -1;     ///< For its stdout and stderr; -1: those of this process.
  Duration sigterm_after = 3s, sigkill_after = 2s;
};

/// A started program. It is a process group of its own, so that Ctrl-C in the terminal reaches this process only, which
/// then stops the program in order.
/// Threads: one. The destructor kills a running program.
class ForeignProgram {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ForeignProgram>, Problem> start(const ProgramSpec& spec);
  ForeignProgram(const ForeignProgram&) = delete;
  ForeignProgram& operator=(const ForeignProgram&) = delete;
  ~ForeignProgram();

  [[nodiscard]] const ProgramSpec& spec() const { return spec_; }
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Returns a descriptor (pidfd) that is readable when the program has ended; -1 after ended() has reaped it.
  [[nodiscard]] int descriptor() const { return pidfd_; }
  /// Returns how the program ended, such as "exited with 1"; empty while it runs. Reaps the program, and kills what is
  /// left of its process group.
  [[nodiscard]] std::string ended();
  /// Blocks until the program is ready. Errors: it ended; the limit passed; `stop_descriptor` became readable.
  [[nodiscard]] Result<void, Problem> wait_until_ready(Duration limit, int stop_descriptor, const Clock& clock);
  /// Blocks until the program ends. Returns false if it still runs after the limit.
  [[nodiscard]] bool wait_for_end(Duration limit, const Clock& clock);
  /// Sends SIGINT to the program, after ProgramSpec::sigterm_after SIGTERM to its group, and after
  /// ProgramSpec::sigkill_after SIGKILL. Blocks until it ends. Returns how it ended.
  std::string stop(const Clock& clock);

 private:
  ForeignProgram(ProgramSpec spec, pid_t pid, int pidfd);

  ProgramSpec spec_;
  pid_t pid_;
  int pidfd_;
  bool reaped_ = false;
  std::string how_;
};

/// Sends SIGKILL to the process groups that were started and not reaped, of which at most 64 are tracked. Threads: any;
/// async-signal-safe.
void kill_all_programs() noexcept;

/// Returns "exited with 3" or "killed by signal 9 (Killed)".
[[nodiscard]] std::string describe_exit(int status);

}  // namespace nacelle::process
