// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/frame.hpp"

namespace nacelle::control {

/// The kind of a frame on the control socket. Kinds are letters, so that a trace is readable.
enum class FrameKind : std::uint8_t {
  // For rare requests, served by the container's main thread: JSON texts.
  Request = 'j',  ///< client: one request; the connection then serves requests only
  Reply = 'r',    ///< container: the final answer to it
  Item = 'i',     ///< container: one of many (topic echo)
  // For periodic requests, served by the control thread without allocating.
  OpenWriter = 'w',  ///< client: topic 0 type
  Opened = 'o',      ///< container: u16 handle
  Publish = 'p',     ///< client: u16 handle, CDR bytes; no answer unless it is refused
  Lookup = 't',      ///< client: target frame 0 source frame
  Transform = 'x',   ///< container: see wire.hpp
  Stats = 's',       ///< client: nothing; container: a JSON text
  Shutdown = 'q',    ///< client: shut the robot down in order; container: confirms that request
  Fault = 'f',       ///< container: the reason for a refusal
};
[[nodiscard]] bool is_known(FrameKind kind);

using Frame = FrameView<FrameKind>;

/// Why the bytes of a peer cannot be parsed. The connection is closed.
enum class FrameFault : std::uint8_t {
  TooLong,      ///< The length is above what this side accepts.
  UnknownKind,  ///< Not one of FrameKind: another program, or another version.
};
[[nodiscard]] const char* to_text(FrameFault fault);

using FrameReader = nacelle::FrameReader<FrameKind, FrameFault>;
using nacelle::append_frame;

}  // namespace nacelle::control
