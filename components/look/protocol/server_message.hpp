// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"

// What the server says in the Foxglove WebSocket protocol: texts, and the heads of binary frames.
// Source: github.com/foxglove/ws-protocol, docs/spec.md (version 1).
namespace nacelle::look {

struct ServerInfo {
  std::string name;
  std::vector<std::string> capabilities;
  std::map<std::string, std::string> metadata;
  std::string session;
};
[[nodiscard]] std::string server_info(const ServerInfo& info);

enum class StatusLevel : std::uint8_t { Info, Warning, Error };  // the protocol's numbers
[[nodiscard]] std::string status(StatusLevel level, std::string_view text);

/// A topic that viewers can subscribe to. `schema`: ros2msg.
struct ChannelInfo {
  std::uint32_t id = 0;
  std::string topic, type, schema;
};
[[nodiscard]] std::string advertise(const std::vector<ChannelInfo>& channels);
[[nodiscard]] std::string unadvertise(const std::vector<std::uint32_t>& channels);

/// A service that viewers can call. `request`, `response`: ros2msg.
struct ServiceInfo {
  std::uint32_t id = 0;
  std::string name, type, request, response;
};
[[nodiscard]] std::string advertise_services(const std::vector<ServiceInfo>& services);
[[nodiscard]] std::string unadvertise_services(const std::vector<std::uint32_t>& services);
[[nodiscard]] std::string service_call_failure(std::uint32_t service, std::uint32_t call, std::string_view text);

/// `parameters`: a list of {name, value, type}. `id`: of the question; empty: an update.
[[nodiscard]] std::string parameter_values(nlohmann::json parameters, std::string_view id);

/// Which nodes publish, subscribe and serve what.
struct ConnectionGraph {
  using Nodes = std::map<std::string, std::set<std::string>>;  ///< By topic or service.
  Nodes published, subscribed, services;
  friend bool operator==(const ConnectionGraph&, const ConnectionGraph&) = default;
};
/// What has changed since `before`.
[[nodiscard]] std::string connection_graph_update(const ConnectionGraph& before, const ConnectionGraph& now);

/// The head of a binary frame with a message, which follows. `time`: nanoseconds since the epoch.
[[nodiscard]] Bytes message_head(std::uint32_t subscription, std::uint64_t time);
inline constexpr std::size_t kMessageHead = 13;
/// Whole binary frames.
[[nodiscard]] Bytes time_frame(std::uint64_t time);
[[nodiscard]] Bytes service_response(std::uint32_t service, std::uint32_t call, std::string_view encoding,
                                     ByteView data);
[[nodiscard]] Bytes asset(std::uint32_t request, ByteView data);
[[nodiscard]] Bytes asset_failure(std::uint32_t request, std::string_view text);

}  // namespace nacelle::look
