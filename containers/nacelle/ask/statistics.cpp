// SPDX-License-Identifier: Apache-2.0
#include "ask/statistics.hpp"

namespace nacelle::ask {

using nlohmann::json;

Result<json, Problem> statistics(Nodes& nodes, const std::string& container) {
  auto answer = nodes.ask_container(container, "get_statistics", "nacelle_interfaces/srv/GetStatistics");
  if (!answer) return answer;
  for (json& row : answer.value()["components"]) {
    const bool has_executor = !row["executor"].get_ref<const std::string&>().empty(), has_process = row["process"] != 0;
    if (!has_executor)
      for (const char* const key : {"executor", "own_threads", "callbacks", "samples"}) row.erase(key);
    if (!has_process)
      for (const char* const key : {"process", "rss_bytes"}) row.erase(key);
    if (!has_executor && !has_process) row.erase("cpu_us");
  }
  return answer;
}

}  // namespace nacelle::ask
