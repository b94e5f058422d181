// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "process/foreign_programs.hpp"

namespace nacelle::cli {

/// An empty container in a process of its own, as `nacelle container` is, which ends with this object.
class PlayContainer {
 public:
  /// Waits until it accepts connections. Errors: it has ended; it takes longer than 20 s.
  [[nodiscard]] static Result<std::unique_ptr<PlayContainer>, Problem> start();
  PlayContainer(const PlayContainer&) = delete;
  PlayContainer& operator=(const PlayContainer&) = delete;
  ~PlayContainer();
  /// As --container takes it.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  PlayContainer(std::string name, std::unique_ptr<process::ForeignProgram> program)
      : name_(std::move(name)), program_(std::move(program)) {}

  const SystemClock clock_;
  const std::string name_;
  std::unique_ptr<process::ForeignProgram> program_;
};

}  // namespace nacelle::cli
