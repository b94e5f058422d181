// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::look {

/// Why a viewer's message is not carried out. The viewer gets it as a status of the Foxglove protocol.
enum class LookFault : std::uint8_t {
  BadMessage,  ///< No JSON object, no known operation, a field that is missing or of another kind, a frame that is too short.
  TooMany,  ///< More of something than one viewer may have: subscriptions, topics that it publishes, calls on their way.
  UnknownChannel,  ///< A channel, or a topic that the viewer publishes, that there is not.
  UnknownService,  ///< No service has this number.
  UnknownType,     ///< A message type that is not installed.
  BadEncoding,     ///< Neither cdr nor json, or bytes that are no message of their type.
  NotAllowed,      ///< It asks for the right to operate.
  NoSuchFile,      ///< An asset that is not in a folder of assets, or that cannot be read.
  NoAnswer,        ///< A service that went away, or a node that did not answer in time.
};
[[nodiscard]] constexpr const char* code_text(LookFault fault) {
  switch (fault) {
    case LookFault::BadMessage: return "look.bad_message";
    case LookFault::TooMany: return "look.too_many";
    case LookFault::UnknownChannel: return "look.unknown_channel";
    case LookFault::UnknownService: return "look.unknown_service";
    case LookFault::UnknownType: return "look.unknown_type";
    case LookFault::BadEncoding: return "look.bad_encoding";
    case LookFault::NotAllowed: return "look.not_allowed";
    case LookFault::NoSuchFile: return "look.no_such_file";
    case LookFault::NoAnswer: return "look.no_answer";
  }
  return "";
}

}  // namespace nacelle::look
