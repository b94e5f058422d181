// SPDX-License-Identifier: Apache-2.0
#include "text/message_csv.hpp"

#include <nlohmann/json.hpp>

#include "nacelle/base/json_text.hpp"

namespace nacelle::text {
namespace {

using Json = nlohmann::ordered_json;

void append_value(std::string& out, const Json& value, std::size_t longest) {
  std::size_t index = 0;
  const auto separate = [&] { out += index++ == 0 ? "" : ","; };
  if (value.is_object()) {
    for (const auto& [name, part] : value.items()) {
      separate();
      append_value(out, part, longest);
    }
  } else if (value.is_array()) {
    for (const Json& part : value) {
      separate();
      if (longest != 0 && index > longest) {
        out += "...";
        return;
      }
      append_value(out, part, longest);
    }
  } else if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    const bool cut = longest != 0 && text.size() > longest;
    out += cut ? text.substr(0, longest) + "..." : text;
  } else if (value.is_boolean()) {
    out += value.get<bool>() ? "True" : "False";
  } else {
    out += value.dump();
  }
}

}  // namespace

std::string csv_of_json(std::string_view json, std::size_t longest) {
  std::string out;
  const Json value = parse_json_or_discard<Json>(json);
  if (!value.is_discarded()) append_value(out, value, longest);
  return out;
}

}  // namespace nacelle::text
