// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// What a viewer says in the Foxglove WebSocket protocol.
// Source: github.com/foxglove/ws-protocol, docs/spec.md (version 1).
namespace nacelle::look {

/// A JSON text of the operation "subscribe", and so on.
struct Subscribe {
  struct One {
    std::uint32_t subscription = 0;  ///< The viewer's own number.
    std::uint32_t channel = 0;
  };
  std::vector<One> all;
};
struct Unsubscribe {
  std::vector<std::uint32_t> subscriptions;
};
struct Advertise {
  struct One {
    std::uint32_t channel = 0;  ///< The viewer's own number.
    std::string topic, encoding, type;
  };
  std::vector<One> all;
};
struct Unadvertise {
  std::vector<std::uint32_t> channels;
};
struct GetParameters {
  std::vector<std::string> names;  ///< "/node.parameter"; none: all.
  std::string id;
};
struct SetParameters {
  struct One {
    std::string name, type;
    nlohmann::json value;  ///< null: it is to be unset.
  };
  std::vector<One> all;
  std::string id;
};
struct WatchParameters {
  std::vector<std::string> names;  ///< None: all.
  bool on = true;
};
struct WatchGraph {
  bool on = true;
};
struct FetchAsset {
  std::string uri;
  std::uint32_t request = 0;
};

/// A binary frame: a message of a topic that the viewer publishes. The bytes are the frame's.
struct Publication {
  std::uint32_t channel = 0;
  ByteView data;
};
/// A binary frame: a request to a service. The bytes are the frame's.
struct ServiceCall {
  std::uint32_t service = 0, call = 0;
  std::string encoding;
  ByteView data;
};

using ClientMessage = std::variant<Subscribe, Unsubscribe, Advertise, Unadvertise, GetParameters, SetParameters,
                                   WatchParameters, WatchGraph, FetchAsset, Publication, ServiceCall>;

/// Reads a text frame, or a binary one. Errors: LookFault::BadMessage, and ::TooMany for lists of more than 1,000 entries.
[[nodiscard]] Result<ClientMessage, Problem> read_text(std::string_view text);
[[nodiscard]] Result<ClientMessage, Problem> read_binary(ByteView frame);

}  // namespace nacelle::look
