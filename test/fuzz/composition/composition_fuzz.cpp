// SPDX-License-Identifier: Apache-2.0
// A foreign state file, or half of one: refused with a reason, or taken and written as the same again.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "session/composition.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace nacelle::session;
  const auto parsed = parse_composition({reinterpret_cast<const char*>(data), size}, "state");
  if (!parsed) {
    if (parsed.error().what.empty()) std::abort();
    return 0;
  }
  const auto again = parse_composition(to_text(parsed.value()), "state");
  if (!again || to_text(again.value()) != to_text(parsed.value())) std::abort();
  static_cast<void>(resumed({}, parsed.value(), "state"));
  return 0;
}
