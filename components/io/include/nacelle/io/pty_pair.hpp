// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/io/byte_stream.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::io {

/// A pseudo-terminal: a serial line whose device end is this program. Raw, no echo.
///
/// The other end stays open here too, so that a program which closes and opens the line again does not hang it up.
/// Threads: one at a time.
class PtyPair {
 public:
  /// Errors: a Problem when the kernel has no pty left or /dev/pts is not mounted.
  [[nodiscard]] static Result<std::unique_ptr<PtyPair>, Problem> create();

  PtyPair(const PtyPair&) = delete;
  PtyPair& operator=(const PtyPair&) = delete;
  /// Removes the link, if it is still this pty's.
  ~PtyPair();

  /// Makes `link` point to the line, replacing an existing link. A file of another kind is not touched.
  /// Errors: a Problem that names the link.
  [[nodiscard]] Result<void, Problem> link_as(const std::string& link);

  /// "/dev/pts/7"
  [[nodiscard]] const std::string& path() const { return path_; }
  /// The device end, non-blocking: poll it for what the program wrote.
  [[nodiscard]] int device_end() const { return device_end_.number(); }

  /// Reads what the program wrote; empty when there is nothing. Valid until the next call.
  [[nodiscard]] Result<ByteView, StreamFault> read();
  /// Sends to the program without ever waiting; returns how many bytes the line took.
  ///
  /// A line that already holds `kFullBytes` unread ones takes none, like a receiver without flow control whose buffer
  /// is full: a program that starts late then finds little old data, not a minute of it.
  [[nodiscard]] std::size_t write_some(ByteView bytes);
  /// Bytes that were sent and not read yet.
  [[nodiscard]] std::size_t unread() const;
  /// Hangs the line up, as a pulled cable does. Nothing else works afterwards.
  void hang_up();

  static constexpr std::size_t kFullBytes = 3072;

 private:
  PtyPair(Descriptor device_end, Descriptor program_end, std::string path);

  Descriptor device_end_;
  Descriptor program_end_;
  std::string path_;
  std::string link_;
  std::array<std::uint8_t, 4096> buffer_{};
};

}  // namespace nacelle::io
