// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "control/frame.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::control {

/// Longest payload that a client may send.
inline constexpr std::size_t kLongestRequest = 1U << 20U;

/// A connected client: its descriptor, what it sent and what it has not taken yet.
class Connection {
 public:
  explicit Connection(int descriptor);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// Begins anew with another peer, with the memory of the last one.
  void reuse_for(int descriptor);
  /// Takes in what has come. False when the peer is gone.
  [[nodiscard]] bool read_some();
  /// Sends what it can without waiting. False when the peer is gone.
  [[nodiscard]] bool write_some();
  /// Sends the reason for closing the connection, as far as the peer takes it without waiting.
  void say_farewell(std::string_view why);
  [[nodiscard]] bool wants_to_write() const { return sent_ < out.size(); }
  /// True while so much waits to be sent that no more should be made for this client.
  [[nodiscard]] bool is_slow() const { return out.size() - sent_ > kSlowBytes; }

  FrameReader in{kLongestRequest};
  std::string out;

 private:
  static constexpr std::size_t kSlowBytes = 256U << 10U;
  int descriptor_;
  std::size_t sent_ = 0;
};

/// A connection without a word, a writer, a subscription or a pending answer is closed after this time. The slowest commands
/// (`tf echo -r 0.001`) ask more often.
inline constexpr Duration kIdleLimit = std::chrono::hours{1};

/// Returns the maximum number of connections for each of the control thread and the main thread: an eighth of the process's limit
/// of open files, at least 4 and at most 64. The rest stays for the robot.
[[nodiscard]] std::size_t most_guests();

}  // namespace nacelle::control
