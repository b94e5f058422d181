// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace nacelle::test {

/// One size of chunks that the daemon offers.
struct ChunkPool {
  std::uint32_t bytes = 0;
  std::uint32_t count = 0;
};
/// 38 MB of chunks; the daemon's own tables, 66 MB, are compiled in. More than a test has messages: a port that is gone keeps its
/// last chunk until the daemon looks, ten times a second.
[[nodiscard]] inline std::vector<ChunkPool> small_pools() {
  return {{256, 1024}, {16'384, 64}, {65'536, 64}, {262'144, 32}, {1'052'672, 24}};
}

/// iceoryx's daemon for a test. There can be one on a machine: its socket, lock and shared memory have fixed names. Tests take turns
/// by a lock on the folder of shared memory (and, in CTest, by RESOURCE_LOCK roudi).
///
/// A keeper process starts the daemon. When the test ends, even by a crash, the keeper kills the daemon and removes its files.
/// The daemon is killed: on SIGTERM it would send SIGTERM to every process that has used it.
/// Threads: the first start() comes before the test has any. Errors: fatal ones end the test program with their words.
class RouDi {
 public:
  /// Waits for its turn. Null: there is none to be had, and why; the test is to be skipped with that reason.
  [[nodiscard]] static std::unique_ptr<RouDi> start(const std::vector<ChunkPool>& pools, std::string& why_not);
  /// The same with the text of a configuration file.
  [[nodiscard]] static std::unique_ptr<RouDi> start_configured(const std::string& configuration, std::string& why_not);
  ~RouDi();
  RouDi(const RouDi&) = delete;
  RouDi& operator=(const RouDi&) = delete;

  void kill();
  void start_again();
  /// The daemon is stopped: it lives and does not answer.
  void stop_answering();

 private:
  RouDi(int control, pid_t keeper) : control_(control), keeper_(keeper) {}
  void order(char word);

  int control_;
  pid_t keeper_;
};

}  // namespace nacelle::test
