// SPDX-License-Identifier: Apache-2.0
// Any bytes as JSON and as XML: refused with words, or read into a value that can be copied, shown and destroyed.
#include <tinyxml2.h>

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "nacelle/base/json_text.hpp"
#include "nacelle/base/xml.hpp"

namespace {

void read_json(std::string_view text) {
  const auto parsed = nacelle::parse_json(text);
  if (parsed.has_value() == nacelle::parse_json_or_discard(text).is_discarded()) std::abort();
  if (!parsed) {
    if (parsed.error().what.empty()) std::abort();
    return;
  }
  const nlohmann::json copy = parsed.value();
  const std::string shown = copy.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  if (shown.empty() || !nacelle::parse_json(shown)) std::abort();
}

void read_xml(std::string_view text) {
  tinyxml2::XMLDocument document;
  const auto parsed = nacelle::parse_xml(document, text, "a.xml");
  if (!parsed) {
    if (parsed.error().what.empty()) std::abort();
    return;
  }
  if (document.RootElement() == nullptr) std::abort();
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text{reinterpret_cast<const char*>(data), size};
  read_json(text);
  read_xml(text);
  return 0;
}
