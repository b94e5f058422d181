// SPDX-License-Identifier: Apache-2.0
#include "cli/asking.hpp"

#include <algorithm>
#include <cstdio>
#include <set>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/base/printable.hpp"

namespace nacelle::cli {

using nlohmann::json;

int ask_nodes(const Whom& whom, bool as_json, const std::function<Result<json, Problem>(ask::Nodes&)>& question,
              const std::function<void(const json&)>& show, Duration on_the_way) {
  auto client = connect(whom);
  if (!client) return client.error();
  // A container that loads another component meanwhile answers when that is done.
  constexpr Duration kNodesLimit = 8s;
  ask::Nodes nodes{client.value(), kNodesLimit, on_the_way};
  const auto answer = question(nodes);
  if (!answer) return complain(answer.error());
  for (const auto& warning : answer.value().value("warnings", json::array()))
    std::fprintf(stderr, "nacelle: warning: %s\n", printable_entry(warning.get<std::string>()).c_str());
  if (as_json) {
    std::printf("%s\n", answer.value().dump().c_str());
  } else {
    show(answer.value());
  }
  return kDone;
}

Result<json, int> graph_of(const Whom& whom) {
  auto client = connect(whom);
  if (!client) return err(client.error());
  auto reply = ask::Nodes{client.value()}.graph();
  if (!reply) return err(complain(reply.error()));
  return std::move(reply).value();
}

std::string absolute(const std::string& name) { return name.rfind('/', 0) == 0 ? name : "/" + name; }

bool complain_of_topic_name(const std::string& name) {
  const auto valid = validate_full_topic_name(absolute(name));
  if (!valid) complain(valid.error());
  return !valid;
}

std::string full_type_name(const std::string& type, const char* kind) {
  if (std::ranges::count(type, '/') != 1) return type;
  const auto slash = type.find('/');
  return type.substr(0, slash + 1) + kind + type.substr(slash);
}

bool is_hidden(const std::string& name) { return name.find("/_") != std::string::npos; }

bool is_standard(const json& row) { return row.value("standard", false); }

void tell_left_out(std::size_t rows, const char* shown_by) {
  if (rows != 0) std::fprintf(stderr, "(and %zu that nodes have by standard: %s shows them)\n", rows, shown_by);
}

std::string text_of(const json& row, const char* key) { return row.value(key, ""); }

std::string fault_text(const json& fault) {
  return printable_line(text_of(fault, "code") + ": " + text_of(fault, "text"));
}

std::vector<std::string> texts_of(const json& rows, const char* key, const std::function<bool(const json&)>& fits) {
  std::set<std::string> texts;
  for (const auto& row : rows) {
    if (fits(row)) texts.insert(text_of(row, key));
  }
  return {texts.begin(), texts.end()};
}

Result<json, int> node_of(const json& graph, const std::string& name_or_id) {
  std::vector<json> hits;
  for (const auto& row : graph["nodes"]) {
    const std::string node = text_of(row, "node");
    if (node == name_or_id) return json(row);
    const auto id = row["id"].get<std::uint64_t>();
    if (node.substr(node.rfind('/') + 1) == name_or_id || (id != 0 && std::to_string(id) == name_or_id))
      hits.push_back(row);
  }
  if (hits.size() == 1) return std::move(hits.front());
  if (hits.empty())
    return err(
        complain_unknown("node", name_or_id, texts_of(graph["nodes"], "node", [](const json&) { return true; })));
  std::vector<std::string> choices;
  choices.reserve(hits.size());
  for (const auto& hit : hits) choices.push_back(text_of(hit, "node"));
  return err(complain({"node '" + name_or_id + "'", "could be any of " + join(choices), "give the full name or the id",
                       NameFault::Ambiguous, name_or_id}));
}

int complain_unknown(const std::string& what, const std::string& name, const std::vector<std::string>& names) {
  return complain({what + " '" + name + "'", "is not there",
                   names.empty() ? "there is none at all" : suggestion(name, names), NameFault::Unknown, name});
}

void print_names(const std::vector<std::string>& names, bool only_count, bool as_json) {
  if (as_json) {
    std::printf("%s\n", (only_count ? json(names.size()) : json(names)).dump().c_str());
  } else if (only_count) {
    print_text("%zu\n", names.size());
  } else {
    for (const auto& name : names) print_text("%s\n", name.c_str());
  }
}

}  // namespace nacelle::cli
