// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "nacelle/launch/parameter_file.hpp"

// The law: a file's values, each of which survives being written and read again, or a problem; never a crash.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle::launch;
  const auto file = parse_parameter_file({reinterpret_cast<const char*>(data), size}, "fuzz.yaml");
  if (!file) {
    if (file.error().empty()) std::abort();
    return 0;
  }
  for (const auto& section : file->sections()) static_cast<void>(matches_node(section.pattern, "/a/b"));
  for (const auto& parameter : file->parameters_for("/a/b")) {
    const std::string text = to_text(parameter.value);
    const auto back = value_of_text(text);
    // Texts compare, not values: .nan differs from itself.
    if (!back || to_text(*back) != text) std::abort();
  }
  return 0;
}
