// SPDX-License-Identifier: Apache-2.0
// Any bytes as a xacro file in a world where every file that it includes holds the same bytes: a text or a problem, soon.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "nacelle/description/xacro.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle;
  const std::string text(reinterpret_cast<const char*>(data), size);
  description::XacroEnvironment environment;
  environment.read_file = [&text](const std::string&) -> Result<std::string, Problem> { return text; };
  environment.find_package = [](const std::string& package) { return "/share/" + package; };
  const auto expanded = description::expand_xacro("/robot.xacro", {{"sim", "true"}}, environment);
  if (!expanded && expanded.error().what.empty()) std::abort();
  return 0;
}
