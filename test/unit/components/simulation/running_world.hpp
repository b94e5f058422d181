// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <thread>

#include "nacelle/io/descriptor.hpp"
#include "simulation/component/run_world.hpp"

namespace nacelle::simulation {

/// A world on a thread of this process, with real ptys, ended through its stop descriptor.
class RunningWorld {
 public:
  explicit RunningWorld(const std::string& name, const WorldSettings& settings = {})
      : directory_(::testing::TempDir() + "world_" + std::to_string(getpid()) + "_" + name) {
    WorldOptions options;
    options.directory = directory_;
    options.settings = settings;
    options.stop_descriptor = stop_.descriptor();
    thread_ = std::thread{[this, options] {
      auto report = run_world(options, clock_);
      if (report) {
        report_ = report.value();
      } else {
        problem_ = report.error();
      }
    }};
    // Only a broken world takes so long.
    const MonotonicTime deadline = clock_.now() + 30s;
    while (!std::filesystem::exists(path("ready")) && clock_.now() < deadline) std::this_thread::yield();
    EXPECT_TRUE(std::filesystem::exists(path("ready")));
  }
  RunningWorld(const RunningWorld&) = delete;
  RunningWorld& operator=(const RunningWorld&) = delete;
  ~RunningWorld() {
    stop();
    std::filesystem::remove_all(directory_);
  }

  void stop() {
    stop_.ring();
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] const std::string& directory() const { return directory_; }
  [[nodiscard]] std::string path(const std::string& file) const { return directory_ + "/" + file; }
  [[nodiscard]] const SystemClock& clock() const { return clock_; }
  /// After stop().
  [[nodiscard]] const WorldReport& report() const { return report_; }
  [[nodiscard]] const Problem& problem() const { return problem_; }

 private:
  SystemClock clock_;
  std::string directory_;
  Bell stop_;
  WorldReport report_;
  Problem problem_;
  std::thread thread_;
};

}  // namespace nacelle::simulation
