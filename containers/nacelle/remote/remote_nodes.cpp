// SPDX-License-Identifier: Apache-2.0
#include "remote/remote_nodes.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "control/client.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/names.hpp"
#include "remote/graph_rows.hpp"
#include "requests/publish_encoded.hpp"
#include "requests/service_verbs.hpp"

namespace nacelle::remote {
namespace {

using control::reply_of;
using nlohmann::json;
using requests::TapWish;
using transport_dds::RemoteEndpoint;
using Ends = std::vector<RemoteEndpoint>;

constexpr std::size_t kMeasuredDepth = 1000, kReadDepth = 10;
/// For the ends on both sides to meet, once one of them has been found.
constexpr Duration kEndsMeet = 500ms;

Ends ends_of(const RemoteNetwork& network, const std::string& topic) {
  return network.look([&](const auto& graph) { return graph.ends_of_topic(topic); });
}

std::set<std::string> types_of(const Ends& ends) {
  std::set<std::string> types;
  for (const auto& end : ends) types.insert(end.type);
  return types;
}

/// As ros2's tools choose it: what all publishers offer. Source: ros2topic, qos_profile of echo (jazzy).
QoS qos_for(const Ends& writers, std::size_t depth) {
  QoS qos{KeepLast{depth}};
  const auto all = [&](auto fits) { return !writers.empty() && std::ranges::all_of(writers, fits); };
  if (all([](const auto& end) { return end.qos.reliability() == Reliability::Reliable; })) {
    qos.reliable();
  } else {
    qos.best_effort();
  }
  if (all([](const auto& end) { return end.qos.durability() == Durability::TransientLocal; })) qos.transient_local();
  return qos;
}

}  // namespace

Result<std::string, Problem> node_named(RemoteNetwork& network, const std::string& name) {
  std::set<std::string> all, hits;
  const auto look = [&] {
    all = network.look([](const auto& graph) {
      std::set<std::string> names;
      for (const auto& node : graph.nodes()) names.insert(full_name(node.node_namespace, node.name));
      return names;
    });
    hits.clear();
    for (const auto& node : all) {
      if (node == name || (!name.starts_with('/') && node.ends_with("/" + name))) hits.insert(node);
    }
    return !hits.empty();
  };
  static_cast<void>(network.find(look));
  if (hits.size() == 1) return *hits.begin();
  if (hits.empty()) {
    return err(Problem{"node '" + name + "'", "is not there in " + network.where(),
                       all.empty() ? "no node at all was found" : suggestion(name, {all.begin(), all.end()}),
                       NameFault::Unknown, name});
  }
  return err(Problem{"node '" + name + "'", "could be any of " + join({hits.begin(), hits.end()}), "give the full name",
                     NameFault::Ambiguous, name});
}

bool offers(const RemoteNetwork& network, const std::string& service) {
  const Ends ends = network.look([&](const auto& graph) { return graph.ends_of_service(service); });
  return std::ranges::any_of(
      ends, [](const auto& end) { return !end.is_writer && end.kind == transport_dds::WireKind::Request; });
}

requests::Answer RemoteNodes::answer(const std::string& verb, const json& request) {
  if (verb == "graph") {
    // The answer must be complete, so wait the full time.
    network_.find_all();
    return network_.look(graph_rows);
  }
  if (verb == "service.call") {
    const auto start = [&](const std::string& name, const msgs::ServiceType& type, void* given,
                           std::function<void()> on_answer) {
      return network_.start_call(name, type, given, std::move(on_answer));
    };
    return requests::call_service(clock(), start, network_.types(), request, "");
  }
  if (verb == "service.prepare") {
    const json& services = request.at("services");
    for (const auto& one : services)
      static_cast<void>(network_.prepare(one["service"], one["type"].get_ref<const std::string&>().c_str()));
    const auto is_offered = [&](const json& one) { return offers(network_, one["service"]); };
    if (!std::ranges::all_of(services, is_offered)) network_.find_all();
    json offered = json::array();
    for (const auto& one : services) offered.push_back(is_offered(one));
    return json{{"ok", true}, {"offered", offered}};
  }
  if (verb == "node.find") {
    const auto node = node_named(network_, request.value("name", ""));
    if (!node) return reply_of(node.error());
    if (!request.value("with_container", false)) return json{{"ok", true}, {"node", node.value()}};
    // A node may be discovered before the services of its container are.
    std::string container;
    network_.find_all([&] { return !(container = container_of(network_, node.value())).empty(); });
    return json{{"ok", true}, {"node", node.value()}, {"container", container}};
  }
  if (verb == "container.find") {
    const auto container = container_named(network_, request.value("name", ""));
    if (!container) return reply_of(container.error());
    const std::string service = container.value() + "/_container/get_components";
    if (!offers(network_, service)) network_.find_all();
    return json{{"ok", true}, {"node", container.value()}, {"is_nacelle", offers(network_, service)}};
  }
  return reply_of(
      {"request '" + verb + "'", "cannot be asked of remote nodes", "ask the container itself, without --remote"});
}

// --- receiving -------------------------------------------------------------------------------------------------------

Result<const msgs::MessageType*, Problem> RemoteNodes::type_of(const TapWish& wish, const Ends& ends) {
  const auto first =
      std::ranges::find_if(ends, [&](const auto& end) { return wish.type.empty() || end.type == wish.type; });
  if (first == ends.end()) {
    const auto types = types_of(ends);
    return err(Problem{"topic " + wish.topic,
                       "has the type " + join({types.begin(), types.end()}, " and ") + ", not " + wish.type, "",
                       NameFault::OtherType, wish.topic});
  }
  if (wish.is_raw) return &network_.bytes_of(first->type, first->user_data.type_hash);
  auto known = network_.types().message(first->type);
  if (known) return known;
  if (!wish.needs_values) return &network_.bytes_of(first->type, first->user_data.type_hash);
  Problem problem = known.error();
  problem.way_out += (problem.way_out.empty() ? "" : "; ") + std::string{"--raw shows its bytes"};
  return err(problem);
}

Result<std::unique_ptr<requests::TopicTap>, Problem> RemoteNodes::tap(const TapWish& wish) {
  Ends ends;
  const auto is_published = [&] {
    ends = ends_of(network_, wish.topic);
    return std::ranges::any_of(
        ends, [&](const auto& end) { return end.is_writer && (wish.type.empty() || end.type == wish.type); });
  };
  static_cast<void>(network_.find(is_published));
  std::ranges::stable_sort(ends, std::ranges::greater{}, &RemoteEndpoint::is_writer);
  if (ends.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, types] : network_.look([](const auto& graph) { return graph.topics(); }))
      names.push_back(name);
    return err(Problem{"topic " + wish.topic, "no node publishes it or subscribes to it in " + network_.where(),
                       names.empty() ? "no topic at all was found there" : suggestion(wish.topic, names),
                       NameFault::Unknown, wish.topic});
  }
  auto type = type_of(wish, ends);
  if (!type) return err(type.error());
  std::erase_if(ends, [&](const auto& end) { return !end.is_writer || end.type != type.value()->name; });
  const QoS qos = qos_for(ends, wish.is_measured ? kMeasuredDepth : kReadDepth);
  auto tap =
      std::make_unique<requests::TopicTap>(network_.transport(), network_.spec_of(wish.topic, *type.value(), qos));
  static_cast<void>(network_.wait(clock().now() + kEndsMeet, [&] {
    return network_.problem_of(wish.topic) || tap->writer_count() >= ends.size();
  }));
  if (const auto problem = network_.problem_of(wish.topic)) return err(*problem);
  return tap;
}

// --- sending ---------------------------------------------------------------------------------------------------------

void RemoteNodes::take_frame(control::Connection& from, const control::Frame& frame) {
  using control::FrameKind;
  const auto refuse = [&](std::string_view why) { control::append_frame(from.out, FrameKind::Fault, why); };
  switch (frame.kind) {
    case FrameKind::OpenWriter: {
      const auto names = control::read_name_pair(frame.payload);
      auto opened = names ? open_writer(*names, from) : err(std::string{"it names no topic and type"});
      if (!opened) return refuse(opened.error());
      std::string handle;
      control::append_handle(handle, opened.value());
      return control::append_frame(from.out, FrameKind::Opened, handle);
    }
    case FrameKind::Publish: {
      const auto publication = control::read_publication(frame.payload);
      const auto why = publication ? publish(*publication) : std::optional<std::string>{"it is not a message"};
      return why ? refuse(*why) : void();
    }
    case FrameKind::Stats: {
      network_.find_all();
      return control::append_frame(from.out, FrameKind::Stats, json{{"streams", network_.look(topic_rows)}}.dump());
    }
    default: return refuse("remote nodes cannot be asked that");
  }
}

Result<std::uint16_t, std::string> RemoteNodes::open_writer(control::NamePair names, const control::Connection& owner) {
  if (auto valid = validate_full_topic_name(names.first); !valid) return err(valid.error().text());
  auto type = network_.types().message(names.second);
  if (!type) return err(type.error().text());
  const std::string topic{names.first};
  OpenWriter made{&owner, topic, type.value(), nullptr};
  made.writer = network_.transport().create_writer(network_.spec_of(topic, *type.value(), QoS{10}));
  // What is published before its readers have met it never reaches them.
  const auto is_read = [&] {
    const Ends ends = ends_of(network_, topic);
    const auto readers =
        std::ranges::count_if(ends, [&](const auto& end) { return !end.is_writer && end.type == type.value()->name; });
    return readers != 0 && made.writer->reader_count() >= static_cast<std::size_t>(readers);
  };
  const auto is_settled = [&] { return network_.problem_of(topic) || is_read(); };
  const bool settled = network_.find(is_settled);
  if (const auto problem = network_.problem_of(topic)) return err(problem->text());
  if (settled) {
    constexpr Duration kSettling = 100ms;  // DDS does not report when the other side has matched (docs/adr/0013)
    static_cast<void>(network_.wait(clock().now() + kSettling, [] { return false; }));
  }
  writers_.push_back(std::move(made));
  return static_cast<std::uint16_t>(writers_.size() - 1);
}

std::optional<std::string> RemoteNodes::publish(const control::Publication& publication) {
  if (publication.handle >= writers_.size() || !writers_[publication.handle].writer)
    return "no such handle; open the writer first";
  const OpenWriter& open = writers_[publication.handle];
  if (const auto problem = network_.problem_of(open.topic)) return problem->text();
  const char* const why = requests::publish_encoded(*open.writer, *open.type, publication.cdr);
  return why == nullptr ? std::nullopt : std::optional<std::string>{why};
}

void RemoteNodes::has_left(const control::Connection& connection) {
  for (OpenWriter& open : writers_) {
    if (open.owner == &connection) open = {};
  }
}

}  // namespace nacelle::remote
