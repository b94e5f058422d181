// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <thread>

#include "cli/whom.hpp"
#include "nacelle/base/bell.hpp"
#include "process/key_mode.hpp"

namespace nacelle::cli {

/// The keys of `ros2 bag play` on a terminal: space pauses and resumes, the right arrow plays the next message, up and down change the rate by
/// a tenth. Without a terminal there are none.
///
/// Threads: one of its own, which asks the player over a connection of its own.
class PlayKeys {
 public:
  /// `player`: the name of its node.
  PlayKeys(Whom whom, std::string player);
  PlayKeys(const PlayKeys&) = delete;
  PlayKeys& operator=(const PlayKeys&) = delete;
  ~PlayKeys();
  [[nodiscard]] bool is_on() const { return mode_.is_on(); }

 private:
  void run();

  const Whom whom_;
  const std::string player_;
  const process::KeyMode mode_;
  Bell end_;
  std::thread thread_;
};

}  // namespace nacelle::cli
