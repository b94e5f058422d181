// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace nacelle::test {

/// A program beside the test, which reads the lines that it prints. Dies with the test; its standard error is the
/// test's.
class PeerProcess {
 public:
  PeerProcess(const std::string& program, const std::vector<std::string>& arguments,
              const std::map<std::string, std::string>& environment);
  ~PeerProcess();
  PeerProcess(const PeerProcess&) = delete;
  PeerProcess& operator=(const PeerProcess&) = delete;

  /// The next line, without its end; empty when the program has ended, or has said nothing for so long.
  [[nodiscard]] std::string line(std::chrono::milliseconds limit = std::chrono::minutes{1});
  /// Writes an empty line to its standard input.
  void go();
  /// Ends its standard input and waits for it: its exit code, -signal when it died of one, -1000 when it did not end.
  [[nodiscard]] int end();
  void stop();  ///< As Ctrl-Z: it keeps its sockets and does nothing.
  void go_on();
  void kill_hard();  ///< It has no time to say goodbye.

 private:
  pid_t id_ = -1;
  int input_ = -1, output_ = -1;
  std::string read_;
};

}  // namespace nacelle::test
