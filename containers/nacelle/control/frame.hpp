// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/frame.hpp"

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

using Frame = FrameView<FrameKind>;

/// Why a peer cannot be understood any more; the connection ends.
enum class FrameFault : std::uint8_t {
  TooLong,      ///< The length is above what this side accepts.
  UnknownKind,  ///< Not one of FrameKind: another program, or another version.
};
[[nodiscard]] const char* to_text(FrameFault fault);

using FrameReader = nacelle::FrameReader<FrameKind, FrameFault>;
using nacelle::append_frame;

}  // namespace nacelle::control
