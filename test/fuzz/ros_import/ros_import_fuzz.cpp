// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "nacelle/launch/parameter_file.hpp"
#include "ros_import/ros_import.hpp"

// The law: a problem, or a parameter file that reads as one and a word on every key; never a crash.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle;
  const std::string_view text{reinterpret_cast<const char*>(data), size};
  ros_import::Imported imported;
  const auto done = ros_import::import_file(text, "fuzz.yaml", imported);
  if (!done) {
    if (done.error().empty()) std::abort();
    return 0;
  }
  std::size_t keys = 0;
  const auto file = launch::parse_parameter_file(text, "fuzz.yaml");
  if (!file) std::abort();
  for (const auto& section : file.value().sections()) keys += section.parameters.size();
  if (imported.notes.size() < keys) std::abort();
  for (const auto& note : imported.notes) {
    if (note.text.empty()) std::abort();
  }
  const std::string yaml = imported.yaml();
  if (!yaml.empty() && !launch::parse_parameter_file(yaml, "out.yaml")) std::abort();
  return 0;
}
