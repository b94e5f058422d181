// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"

namespace nacelle::session {

/// Logs the steps of each component, in the plan's order: a line "activate /lidar" or "activate /lidar FAILED: why" for
/// each step. The same plan always gives the same bytes. FILE.times beside it records when each line's step ended, in
/// milliseconds of the monotonic clock since the log was opened, and how long it took.
///
/// Threads: one. When add() returns, the kernel has the line: it survives a crash of the process, but not of the
/// machine.
class TransitionLog {
 public:
  /// Errors: a file that cannot be written.
  [[nodiscard]] static Result<std::unique_ptr<TransitionLog>, Problem> open(const std::string& file,
                                                                            const Clock& clock);
  /// Errors: a disk that is full.
  [[nodiscard]] Result<void, Problem> add(const lifecycle_manager::Step& step);

 private:
  TransitionLog(const std::string& file, const Clock& clock);

  const std::string file_;
  std::ofstream steps_, times_;
  MonotonicTime begin_;
};

}  // namespace nacelle::session
