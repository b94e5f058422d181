// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::record {

/// What is wrong with the bytes of an MCAP file. Problem::where is the file, with the offset of the record in `value`.
enum class McapFault : std::uint8_t {
  NoMagic,    ///< The file does not begin as an MCAP file does.
  Truncated,  ///< It ends inside a record, or before the footer: the writer was killed, or the copy is incomplete.
  BadRecord,  ///< A field reaches beyond its record, or an opcode is 0.
  TooLarge,   ///< A record or an uncompressed chunk has more bytes than this reader accepts.
  UnknownCompression,  ///< A chunk's compression is none of "", "lz4", "zstd".
  BadCompression,      ///< A chunk cannot be uncompressed to the size that it states.
  BadCrc,              ///< A checksum does not match.
  BadIndex,            ///< An index points to something else than it says, or counts something else.
  UnknownChannel,      ///< A message of a channel, or a channel of a schema, that no record describes.
  Conflict,            ///< Two records give one id different meanings.
  BadPayload,          ///< A message's bytes are no message of its type.
  NoDefinition,        ///< A topic's type is defined neither in the recording nor in an installed package.
  Unreadable,          ///< The file could not be read.
};
[[nodiscard]] constexpr const char* code_text(McapFault fault) {
  switch (fault) {
    case McapFault::NoMagic: return "mcap.no_magic";
    case McapFault::Truncated: return "mcap.truncated";
    case McapFault::BadRecord: return "mcap.bad_record";
    case McapFault::TooLarge: return "mcap.too_large";
    case McapFault::UnknownCompression: return "mcap.unknown_compression";
    case McapFault::BadCompression: return "mcap.bad_compression";
    case McapFault::BadCrc: return "mcap.bad_crc";
    case McapFault::BadIndex: return "mcap.bad_index";
    case McapFault::UnknownChannel: return "mcap.unknown_channel";
    case McapFault::Conflict: return "mcap.conflict";
    case McapFault::BadPayload: return "mcap.bad_payload";
    case McapFault::NoDefinition: return "mcap.no_definition";
    case McapFault::Unreadable: return "mcap.unreadable";
  }
  return "";
}

/// A fault and where in the file it is.
struct McapProblem {
  McapFault fault{};
  std::uint64_t offset = 0;  ///< Of the record, in bytes from the start of the file.
  const char* what = "";     ///< "the chunk's CRC is not that of its records"; lives for ever.
};

}  // namespace nacelle::record
