// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/buffer.hpp"
#include "nacelle/msgs/cdr.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

// The wire form between processes that share memory: CDR as in cdr.hpp, but the numbers of long sequences are not among the
// other bytes. Their count is; the numbers follow neither it nor its padding, they are a part, and lie where the carrier puts
// them: where the writer has written them in the first place, and where the reader may go on reading them.
//
//   Which sequences: those of numbers (no bools, texts, messages) of kLeastPartBytes bytes or more, the first kMostParts of them
//   in the order of encoding. Both sides follow this rule, so nothing in the bytes says which sequence is apart.
namespace nacelle::msgs {

/// Below this a copy costs less than what goes with lending.
inline constexpr std::size_t kLeastPartBytes = 4096;
inline constexpr std::size_t kMostParts = 16;

/// Numbers that are not among a message's other bytes.
struct Part {
  const void* numbers = nullptr;  ///< In the message.
  std::size_t bytes = 0;
  const Step* step = nullptr;  ///< How the sequence is reached from the message that holds it.
};

struct PartList {
  std::array<Part, kMostParts> parts;
  std::size_t count = 0;
};

/// Memory in which a decoder finds a part.
struct LentPart {
  void* memory = nullptr;  ///< Aligned for its numbers. Never written to by the decoder.
  std::size_t bytes = 0;
  /// Set: the message may keep the memory until it runs the hook, and the decoder empties this one. Null: it must copy.
  ReleaseHook hook;
};

/// The exact number of bytes that encode_apart() writes; lists the parts that it leaves out. Allocates: nothing.
[[nodiscard]] std::size_t encoded_size_apart(const MessageType& type, const void* message, PartList& parts);
/// Writes encoded_size_apart() bytes. Allocates: nothing.
void encode_apart(const MessageType& type, const void* message, std::uint8_t* out);
/// As decode(), with the long sequences from `parts`. A hook that is still set afterwards was not needed: it is the caller's.
/// Errors: as decode(); a part of another size than its sequence is ImpossibleCount, one too many TrailingBytes.
[[nodiscard]] Result<void, DecodeFault> decode_apart(const MessageType& type, ByteView bytes, std::span<LentPart> parts,
                                                     void* message);

}  // namespace nacelle::msgs
