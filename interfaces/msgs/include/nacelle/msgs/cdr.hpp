// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/reflection.hpp"

#include <cstddef>
#include <cstdint>

// The wire form of a message: XCDR1, as ROS 2's middlewares write it.
//
//   offset  bytes  field           on the wire
//        0      2  representation  00 01 little-endian (what is written), 00 00 big-endian (read too)
//        2      2  options         00 00 when written, ignored when read
//        4      n  body            members in order; a number is aligned to its size, counted from offset 4
//      4+n    0-3  padding         accepted when read
//
//   string    u32 length with its NUL, bytes, NUL (length 0 is read as empty)
//   wstring   u32 number of UTF-16 code units, each as 4 bytes, no terminator (a ROS 2 peculiarity)
//   sequence  u32 count, elements
//   array     elements
// Source: OMG DDSI-RTPS 2.3 section 10, OMG CORBA CDR 15.3; rmw_cyclonedds_cpp (jazzy) for wstring and the empty
//         string.
namespace nacelle::msgs {

inline constexpr std::size_t kEncapsulationSize = 4;
/// Trailing bytes that a decoder accepts: DDS pads a payload to a multiple of four.
inline constexpr std::size_t kMostPadding = 3;

/// Why bytes are not a message of the type. The message then holds a mixture of old and new values.
enum class DecodeFault : std::uint8_t {
  Truncated,        ///< The bytes end before the message does.
  UnknownEncoding,  ///< The first two bytes are neither 00 01 nor 00 00: not plain XCDR1.
  ImpossibleCount,  ///< A sequence announces more elements than the bytes left can hold. Nothing was allocated for it.
  BoundExceeded,    ///< More elements or characters than the definition allows.
  TextNotTerminated,  ///< A string does not end in NUL.
  BadCharacter,       ///< A wide character above U+10FFFF.
  TrailingBytes,      ///< More than three bytes are left behind the message: another type, most likely.
  OutOfMemory,        ///< The process has no memory for a message of that size.
};

/// "a sequence announces more elements than the bytes can hold"
[[nodiscard]] const char* explain(DecodeFault fault);

/// What one step of a message's encoding does. Nested messages are flattened into their parent's steps, and
/// neighbouring numbers of one size into one step, so that a pose with its covariance is one memcpy.
enum class StepKind : std::uint8_t {
  Numbers,    ///< `count` numbers of `width` bytes that lie side by side, in memory as on the wire.
  Bools,      ///< `count` bools.
  Texts,      ///< `count` std::string.
  WideTexts,  ///< `count` std::u16string.
  Messages,   ///< `count` messages of one type (a fixed array).
  NumberSequence,
  BoolSequence,
  TextSequence,
  WideTextSequence,
  MessageSequence,
};

struct Step {
  StepKind kind;
  std::uint8_t width;
  std::uint32_t offset;
  std::uint32_t count;
  std::uint32_t bound;       ///< Most elements of a sequence; 0 is no bound.
  std::uint32_t text_bound;  ///< Most characters of each text; 0 is no bound.
  MessageTypeFunction message;
  const SequenceAccess* sequence;
};

/// The exact number of bytes that encode() writes, encapsulation included. Allocates: nothing.
[[nodiscard]] std::size_t encoded_size(const MessageType& type, const void* message);
/// Writes encoded_size() bytes. Bounds of bounded types are not checked here. Allocates: nothing.
void encode(const MessageType& type, const void* message, std::uint8_t* out);
/// Reads a message from hostile bytes into one that may have been used before: capacity is reused, every field is set.
///
/// Allocates: at most 64 bytes for each byte given, and nothing when the message has the capacity.
/// Threads:   pure.
[[nodiscard]] Result<void, DecodeFault> decode(const MessageType& type, ByteView bytes, void* message);

}  // namespace nacelle::msgs
