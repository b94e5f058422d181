// SPDX-License-Identifier: Apache-2.0
#include "robot_commands/component_reference.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/runtime/plugin_fault.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "reference/declarations.hpp"
#include "reference/markdown.hpp"

namespace nacelle::cli {

using nlohmann::json;

int component_reference(const std::string& plugin, bool as_json) {
  set_log_level(LogLevel::Error);  // warnings of constructors about their defaults
  const SystemClock clock;
  const auto places = program_places();
  runtime::PluginIndex index{places.component_folders};
  std::vector<runtime::PluginEntry> wanted;
  if (plugin.empty()) {
    wanted = index.entries();
    if (wanted.empty()) return complain_of_no_plugins(places);
  } else if (auto found = index.find(plugin)) {
    wanted.push_back(std::move(*found));
  } else {
    return complain({plugin, "there is no plugin " + plugin + " in " + join(places.component_folders, ":"),
                     suggestion(plugin, index.class_names()), runtime::PluginFault::UnknownClass, plugin});
  }
  json rows = json::array();
  int outcome = kDone;
  const char* between = "";
  for (const auto& entry : wanted) {
    auto declared = reference::declarations_of(entry, places, clock);
    if (!declared) {  // the others are printed nevertheless
      outcome = complain(declared.error());
    } else if (as_json) {
      rows.push_back(std::move(declared).value());
    } else {
      print_text("%s%s", between, reference::markdown_of(declared.value()).c_str());
      between = "\n";
    }
  }
  if (as_json) std::printf("%s\n", rows.dump(2).c_str());
  return outcome;
}

}  // namespace nacelle::cli
