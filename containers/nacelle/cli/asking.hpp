// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ask/nodes.hpp"
#include "cli/whom.hpp"
#include "control/client.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"

// Helpers of commands that query a container.
namespace nacelle::cli {

inline constexpr Duration kAnswerLimit = 10s;

/// Connects and runs `question`, which calls services of nodes. On success prints the answer's "warnings" to stderr,
/// then prints the answer as JSON or with `show`. `on_the_way`: how long a busy container may take to accept the
/// request. Returns the exit code.
int ask_nodes(const Whom& whom, bool as_json,
              const std::function<Result<nlohmann::json, Problem>(ask::Nodes&)>& question,
              const std::function<void(const nlohmann::json&)>& show, Duration on_the_way = 2s);

/// Returns the graph of the container or of the network (answers/graph_verbs.hpp). Errors: the exit code; the error has
/// been printed to stderr.
[[nodiscard]] Result<nlohmann::json, int> graph_of(const Whom& whom);

/// Returns "/scan" for "scan".
[[nodiscard]] std::string absolute(const std::string& name);
/// Prints an error if a topic name is invalid, and returns true then. Call it before any query.
[[nodiscard]] bool complain_of_topic_name(const std::string& name);
/// Returns "std_srvs/srv/Empty" for ros2's short "std_srvs/Empty"; `kind` is "msg" or "srv".
[[nodiscard]] std::string full_type_name(const std::string& type, const char* kind);
/// Returns whether a name is hidden: as in ros2, if one of its parts begins with '_'.
[[nodiscard]] bool is_hidden(const std::string& name);
/// Returns whether every node has this row of the graph (nacelle/host/standard_interfaces.hpp).
[[nodiscard]] bool is_standard(const nlohmann::json& row);
/// Prints to stderr how many standard rows are not shown, and the option that shows them. Prints nothing for 0.
void tell_left_out(std::size_t rows, const char* shown_by = "--all");
/// Returns the text under a key, or an empty text.
[[nodiscard]] std::string text_of(const nlohmann::json& row, const char* key);
/// Returns "code: text" of a fault, on one line.
[[nodiscard]] std::string fault_text(const nlohmann::json& fault);
/// Returns the distinct texts under a key of the rows for which `fits` returns true, sorted.
[[nodiscard]] std::vector<std::string> texts_of(const nlohmann::json& rows, const char* key,
                                                const std::function<bool(const nlohmann::json&)>& fits);
/// Returns the node of the graph with this full name, unique name without namespace, or id. Errors: the exit code; the
/// error has been printed to stderr, with the nearest name.
[[nodiscard]] Result<nlohmann::json, int> node_of(const nlohmann::json& graph, const std::string& name_or_id);
/// Reports an unknown name, and the nearest known one. Returns kFailed.
int complain_unknown(const std::string& what, const std::string& name, const std::vector<std::string>& names);

/// Prints one name per line, or only their number; as JSON a list or a number.
void print_names(const std::vector<std::string>& names, bool only_count, bool as_json);

}  // namespace nacelle::cli
