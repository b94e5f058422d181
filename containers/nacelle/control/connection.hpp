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

/// A connected client: its descriptor, received bytes and pending output.
class Connection {
 public:
  explicit Connection(int descriptor);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// Closes the descriptor and serves another peer with the same memory.
  void reuse_for(int descriptor);
  /// Reads the available bytes. Returns false if the peer has closed the connection.
  [[nodiscard]] bool read_some();
  /// Sends what it can without waiting. Returns false if the peer has closed the connection.
  [[nodiscard]] bool write_some();
  /// Sends the reason for closing the connection, as far as the peer accepts it without waiting.
  void say_farewell(std::string_view why);
  [[nodiscard]] bool wants_to_write() const { return sent_ < out.size(); }
  /// Returns true while so much output is pending that no more should be produced for this client.
  [[nodiscard]] bool is_slow() const { return out.size() - sent_ > kSlowBytes; }

  FrameReader in{kLongestRequest};
  std::string out;

 private:
  static constexpr std::size_t kSlowBytes = 256U << 10U;
  int descriptor_;
  std::size_t sent_ = 0;
};

/// A connection without a writer, a subscription or a pending answer is closed after this time without a request. The
/// slowest commands (`tf echo -r 0.001`) send requests more often.
inline constexpr Duration kIdleLimit = std::chrono::hours{1};

/// Returns the maximum number of connections for each of the control thread and the main thread: an eighth of the
/// process's limit of open files, at least 4 and at most 64. The remaining files stay available to the robot.
[[nodiscard]] std::size_t most_guests();

}  // namespace nacelle::control
