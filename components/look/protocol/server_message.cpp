// SPDX-License-Identifier: Apache-2.0
#include "look/protocol/server_message.hpp"

#include <utility>

namespace nacelle::look {
namespace {

using nlohmann::json;

/// Bytes of names that are no UTF-8 appear as U+FFFD.
std::string written(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

template <typename Number>
void append(Bytes& out, Number value) {
  for (std::size_t i = 0; i < sizeof value; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8U * i)));
}
void append(Bytes& out, ByteView bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }

/// The entries of `now` that `before` has not, or has otherwise.
json changed(const ConnectionGraph::Nodes& before, const ConnectionGraph::Nodes& now, const char* ids) {
  json list = json::array();
  for (const auto& [name, nodes] : now) {
    const auto found = before.find(name);
    if (found == before.end() || found->second != nodes) list.push_back({{"name", name}, {ids, nodes}});
  }
  // Without entry it would stay as it was.
  for (const auto& [name, nodes] : before) {
    if (!now.contains(name)) list.push_back({{"name", name}, {ids, json::array()}});
  }
  return list;
}

}  // namespace

std::string server_info(const ServerInfo& info) {
  return written({{"op", "serverInfo"},
                  {"name", info.name},
                  {"capabilities", info.capabilities},
                  {"supportedEncodings", {"cdr", "json"}},
                  {"metadata", info.metadata},
                  {"sessionId", info.session}});
}

std::string status(StatusLevel level, std::string_view text) {
  return written({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}});
}

std::string advertise(const std::vector<ChannelInfo>& channels) {
  json list = json::array();
  for (const ChannelInfo& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", "cdr"},
                    {"schemaName", channel.type},
                    {"schema", channel.schema},
                    {"schemaEncoding", "ros2msg"}});
  }
  return written({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string unadvertise(const std::vector<std::uint32_t>& channels) {
  return written({{"op", "unadvertise"}, {"channelIds", channels}});
}

std::string advertise_services(const std::vector<ServiceInfo>& services) {
  json list = json::array();
  const auto half = [](const std::string& name, const std::string& schema) {
    return json{{"encoding", "cdr"}, {"schemaName", name}, {"schemaEncoding", "ros2msg"}, {"schema", schema}};
  };
  for (const ServiceInfo& service : services) {
    list.push_back({{"id", service.id},
                    {"name", service.name},
                    {"type", service.type},
                    {"request", half(service.type + "_Request", service.request)},
                    {"response", half(service.type + "_Response", service.response)},
                    {"requestSchema", service.request},
                    {"responseSchema", service.response}});
  }
  return written({{"op", "advertiseServices"}, {"services", std::move(list)}});
}

std::string unadvertise_services(const std::vector<std::uint32_t>& services) {
  return written({{"op", "unadvertiseServices"}, {"serviceIds", services}});
}

std::string service_call_failure(std::uint32_t service, std::uint32_t call, std::string_view text) {
  return written({{"op", "serviceCallFailure"}, {"serviceId", service}, {"callId", call}, {"message", text}});
}

std::string parameter_values(json parameters, std::string_view id) {
  json object{{"op", "parameterValues"}, {"parameters", std::move(parameters)}};
  if (!id.empty()) object["id"] = id;
  return written(object);
}

std::string connection_graph_update(const ConnectionGraph& before, const ConnectionGraph& now) {
  std::set<std::string> removed_topics, removed_services;
  for (const auto* const topics : {&before.published, &before.subscribed}) {
    for (const auto& [name, nodes] : *topics) {
      if (!now.published.contains(name) && !now.subscribed.contains(name)) removed_topics.insert(name);
    }
  }
  for (const auto& [name, nodes] : before.services) {
    if (!now.services.contains(name)) removed_services.insert(name);
  }
  return written({{"op", "connectionGraphUpdate"},
                  {"publishedTopics", changed(before.published, now.published, "publisherIds")},
                  {"subscribedTopics", changed(before.subscribed, now.subscribed, "subscriberIds")},
                  {"advertisedServices", changed(before.services, now.services, "providerIds")},
                  {"removedTopics", removed_topics},
                  {"removedServices", removed_services}});
}

Bytes message_head(std::uint32_t subscription, std::uint64_t time) {
  Bytes out{1};
  append(out, subscription);
  append(out, time);
  return out;
}

Bytes time_frame(std::uint64_t time) {
  Bytes out{2};
  append(out, time);
  return out;
}

Bytes service_response(std::uint32_t service, std::uint32_t call, std::string_view encoding, ByteView data) {
  Bytes out{3};
  append(out, service);
  append(out, call);
  append(out, static_cast<std::uint32_t>(encoding.size()));
  append(out, as_bytes(encoding));
  append(out, data);
  return out;
}

Bytes asset(std::uint32_t request, ByteView data) {
  Bytes out{4};
  append(out, request);
  append(out, std::uint8_t{0});
  append(out, std::uint32_t{0});
  append(out, data);
  return out;
}

Bytes asset_failure(std::uint32_t request, std::string_view text) {
  Bytes out{4};
  append(out, request);
  append(out, std::uint8_t{1});
  append(out, static_cast<std::uint32_t>(text.size()));
  append(out, as_bytes(text));
  return out;
}

}  // namespace nacelle::look
