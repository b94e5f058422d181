// SPDX-License-Identifier: Apache-2.0
#include "session/transition_log.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>

namespace nacelle::session {
namespace {

Problem cannot_be_written(const std::string& file) {
  return {file, fmt::format("the log of transitions cannot be written: {}", std::strerror(errno)),
          "give another place"};
}

}  // namespace

TransitionLog::TransitionLog(const std::string& file, const Clock& clock)
    : file_(file), steps_(file, std::ios::trunc), times_(file + ".times", std::ios::trunc), begin_(clock.now()) {}

Result<std::unique_ptr<TransitionLog>, Problem> TransitionLog::open(const std::string& file, const Clock& clock) {
  errno = 0;
  std::unique_ptr<TransitionLog> log{new TransitionLog(file, clock)};
  if (log->steps_ && log->times_) return log;
  return err(cannot_be_written(file));
}

Result<void, Problem> TransitionLog::add(const lifecycle_manager::Step& step) {
  errno = 0;
  const std::string line = fmt::format("{} {}", nacelle::to_text(step.transition), step.node);
  steps_ << line;
  if (!step.success) steps_ << " FAILED: " << step.reason;
  steps_ << std::endl;
  times_ << fmt::format("{:.3f} ms {} took {:.3f} ms", to_milliseconds(step.ended - begin_), line,
                        to_milliseconds(step.took))
         << std::endl;
  if (!steps_ || !times_) return err(cannot_be_written(file_));
  return {};
}

}  // namespace nacelle::session
