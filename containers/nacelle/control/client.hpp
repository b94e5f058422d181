// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "control/frame.hpp"
#include "control/wire.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::control {

/// A connection to a container's control socket, for programs outside of it.
///
/// Errors: a Problem when the container has ended, its answer is invalid, or it takes longer than the time limit.
/// Threads: one at a time.
class Client {
 public:
  /// Connects to a control socket. Errors: no listener; a listener that is not trusted (may_answer()); a timeout of 10
  /// s.
  [[nodiscard]] static Result<Client, Problem> connect(const std::string& path);
  /// Takes ownership of a connected socket whose peer is this process instead of a container. Its refusals are returned
  /// verbatim. `patience` is added to the time limit of every answer.
  [[nodiscard]] static Client over(int descriptor, Duration patience);
  Client(Client&& other) noexcept;
  Client& operator=(Client&& other) noexcept;
  ~Client();

  /// Sends one request and returns its reply. Errors: also the Problem of a reply `{"ok": false, "problem": ...}`.
  [[nodiscard]] Result<nlohmann::json, Problem> call(const nlohmann::json& request, Duration limit);
  [[nodiscard]] Result<void, Problem> send(FrameKind kind, std::string_view payload);
  /// Returns the next frame, or nothing after the time limit or when a signal interrupts the wait. The frame stays
  /// valid until the next call.
  [[nodiscard]] Result<std::optional<Frame>, Problem> receive(Duration limit);

  /// Opens a writer. Returns its handle for publish().
  [[nodiscard]] Result<std::uint16_t, Problem> open_writer(std::string_view topic, std::string_view type,
                                                           Duration limit);
  [[nodiscard]] Result<void, Problem> publish(std::uint16_t handle, ByteView cdr);
  [[nodiscard]] Result<TransformAnswer, Problem> lookup(std::string_view target, std::string_view source,
                                                        Duration limit);
  /// Returns the live figures as JSON text.
  [[nodiscard]] Result<std::string, Problem> stats(Duration limit);

  [[nodiscard]] int descriptor() const { return fd_; }
  /// Returns the text of a frame of kind Fault.
  [[nodiscard]] Problem problem_of(const Frame& fault) const;

 private:
  explicit Client(int fd);
  [[nodiscard]] Result<Frame, Problem> expect(FrameKind kind, Duration limit);

  int fd_ = -1;
  [[nodiscard]] Problem gone(const char* what) const;
  /// Returns why the container ended the connection, if it has sent a reason.
  [[nodiscard]] Problem farewell(const char* what);
  /// Returns the problem of a container whose process is suspended by a signal or a debugger, or nothing.
  [[nodiscard]] std::optional<Problem> is_stopped() const;

  Duration patience_{};
  int process_ = 0;  // of the container; 0: unknown
  bool is_container_ = true;
  FrameReader reader_;
  std::string out_;
};

/// Returns the reply that reports a problem: {"ok": false, "problem": ...}.
[[nodiscard]] nlohmann::json reply_of(const Problem& problem);

}  // namespace nacelle::control
