// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/reversed.hpp"

namespace nacelle::description {

/// Ends the expansion; caught in expand_xacro().
struct Failure {
  Problem problem;
};

/// Where the expansion is: a line of a file, and the includes and macros that led there.
class Trail {
 public:
  struct Step {
    std::string file, reason;  // "in macro 'wheel', called at robot.xacro:30"
  };
  /// One step further; back at its end, to the line where it began.
  class Frame {
   public:
    Frame(Trail& trail, const std::string& file, std::string reason) : trail_(trail), line_(trail.line) {
      if (trail.steps_.size() >= kMaxDepth) trail.fail("macros and includes are nested too deeply");
      trail.steps_.push_back({file, std::move(reason)});
    }
    ~Frame() {
      trail_.steps_.pop_back();
      trail_.line = line_;
    }
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

   private:
    Trail& trail_;
    int line_;
  };
  static constexpr std::size_t kMaxDepth = 60;

  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }
  [[nodiscard]] const std::string& file() const { return steps_.back().file; }
  [[nodiscard]] std::string place() const { return fmt::format("{}:{}", file(), line); }

  /// The user needs to know how the place was reached.
  [[noreturn]] void fail(std::string what, std::string way_out = {}) const {
    for (const auto& step : reversed(steps_)) {
      if (!step.reason.empty()) (way_out.empty() ? what : way_out) += "\n  " + step.reason;
    }
    throw Failure{{steps_.empty() ? Place{} : Place{file(), line}, std::move(what), std::move(way_out)}};
  }

  int line = 0;

 private:
  std::vector<Step> steps_;
};

}  // namespace nacelle::description
