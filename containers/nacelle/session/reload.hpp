// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "answers/robot.hpp"
#include "nacelle/base/bell.hpp"

namespace nacelle::session {

/// Reads the launch file and its parameter files again, and sets those parameters of running components that have other values
/// there. Nothing else of a plan can change while the robot runs; differences are reported.
///
/// A component that does not answer delays the end of the reload, not the robot.
/// Threads: the main thread.
class Reload {
 public:
  using Reread = std::function<Result<launch::Plan, std::vector<Problem>>()>;
  using Say = std::function<void(const std::string& line)>;
  /// `robot` and `clock` must outlive this object. An empty `reread`: there is no file.
  Reload(answers::Robot& robot, Reread reread, const Clock& clock, Say say);

  /// Begins a reload. Returns false if one is running.
  bool begin();
  /// Returns a descriptor to poll while a reload runs.
  [[nodiscard]] int descriptor() const { return bell_->descriptor(); }
  /// Returns when work() must run even if the descriptor is silent; nothing: no reload runs.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const { return due_; }
  /// Takes answers. Returns a summary, "2 parameters set, 1 refused", when the reload has ended.
  [[nodiscard]] std::optional<std::string> work();

 private:
  struct Call {
    std::string node;
    std::vector<std::string> names;
    std::unique_ptr<runtime::ServiceCall> call;
  };
  void compare(const launch::Plan& plan);
  void change(const launch::ComponentPlan& component, const runtime::ComponentInfo& info);
  void take(const Call& done);

  answers::Robot& robot_;
  const Reread reread_;
  const Clock& clock_;
  const Say say_;
  const std::shared_ptr<Bell> bell_ = std::make_shared<Bell>();  // calls may outlive the reload
  std::vector<Call> calls_;
  std::optional<MonotonicTime> due_;
  std::size_t set_ = 0, refused_ = 0;
  std::string failed_;  // why the files could not be read
};

}  // namespace nacelle::session
