// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/transition_log.hpp"

#include <fmt/format.h>

namespace nacelle::session {

TransitionLog::TransitionLog(const std::string& file, const Clock& clock)
    : steps_(file, std::ios::trunc), times_(file + ".times", std::ios::trunc), begin_(clock.now()) {}

Result<std::unique_ptr<TransitionLog>, Problem> TransitionLog::open(const std::string& file, const Clock& clock) {
  std::unique_ptr<TransitionLog> log{new TransitionLog(file, clock)};
  if (log->steps_ && log->times_) return log;
  return err(Problem{file, "the log of transitions cannot be written", "is the folder there, and yours?"});
}

void TransitionLog::add(const lifecycle_manager::Step& step) {
  const std::string line = fmt::format("{} {}", nacelle::to_text(step.transition), step.node);
  steps_ << line;
  if (!step.success) steps_ << " FAILED: " << step.reason;
  steps_ << std::endl;
  times_ << fmt::format("{:.3f} ms {} took {:.3f} ms", to_milliseconds(step.ended - begin_), line,
                        to_milliseconds(step.took))
         << std::endl;
}

}  // namespace nacelle::session
