// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/receive_buffer.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::control {

/// What a frame on the control socket means. Letters, so that a trace can be read.
enum class FrameKind : std::uint8_t {
  // For rare requests, served by the container's main thread: JSON texts.
  Request = 'j',  ///< client: one request; what follows on this connection belongs to it
  Reply = 'r',    ///< container: the final answer to it
  Item = 'i',     ///< container: one of many (topic echo)
  // For periodic requests, served by the control thread without allocating.
  OpenWriter = 'w',  ///< client: topic 0 type
  Opened = 'o',      ///< container: u16 handle
  Publish = 'p',     ///< client: u16 handle, CDR bytes; no answer unless it is refused
  Lookup = 't',      ///< client: target frame 0 source frame
  Transform = 'x',   ///< container: see wire.hpp
  Stats = 's',       ///< client: nothing; container: a JSON text
  Shutdown = 'q',    ///< client: stop the robot in order; container: the same, as soon as it begins
  Fault = 'f',       ///< container: why the last frame was refused
};
[[nodiscard]] bool is_known(FrameKind kind);

/// One frame; the payload lies in the reader's buffer and stays there until the reader is fed again.
struct Frame {
  FrameKind kind{};
  ByteView payload;
};

/// Why a peer cannot be understood any more; the connection ends.
enum class FrameFault : std::uint8_t {
  TooLong,      ///< The length is above what this side accepts.
  UnknownKind,  ///< Not one of FrameKind: another program, or another version.
};
[[nodiscard]] const char* to_text(FrameFault fault);

inline constexpr std::size_t kFrameHeaderBytes = 5;

/// Cuts a stream of bytes into frames.
///
///   offset  bytes  field
///        0      4  length of the payload, little-endian
///        4      1  kind
///        5      n  payload
///
/// Threads: one at a time. Allocates: until its buffer has the size of the longest frame seen; never more than the limit.
class FrameReader {
 public:
  explicit FrameReader(std::size_t longest_payload)
      : longest_payload_(longest_payload), buffer_(kFrameHeaderBytes + longest_payload) {}

  /// Where the next bytes go; never empty. Call filled() with how many came.
  [[nodiscard]] ByteSpan room() { return buffer_.room(); }
  void filled(std::size_t bytes) { buffer_.filled(bytes); }
  /// The next whole frame, or nothing if more bytes are needed. After a fault nothing is readable any more.
  [[nodiscard]] Result<std::optional<Frame>, FrameFault> next();
  /// Drops what has come; the memory stays.
  void forget() { buffer_.clear(); }
  /// Bytes of a frame that has begun.
  [[nodiscard]] std::size_t pending() const { return buffer_.waiting().size(); }

 private:
  std::size_t longest_payload_;
  ReceiveBuffer buffer_;
};

/// Appends a frame to bytes that are to be sent. Allocates: if `out` must grow.
void append_frame(std::string& out, FrameKind kind, std::string_view payload);
/// The two halves of append_frame() for a payload that is written in place: begin, append to `out`, end.
[[nodiscard]] std::size_t begin_frame(std::string& out, FrameKind kind);
void end_frame(std::string& out, std::size_t begin);

}  // namespace nacelle::control
