// SPDX-License-Identifier: Apache-2.0
// Whatever stands in the environment: a problem that says where, or settings whose configuration is well-formed.
//
//   input: lines NAME=value; of the names MODE, PEER and INTERFACE the value is the launch file's
#include <algorithm>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/expect.hpp"
#include "transport_dds/wire/cyclone_config.hpp"

namespace {

using namespace nacelle;
using namespace nacelle::transport_dds;

// Elements are closed in the order in which they were opened, and no value has a '<' or a quote in it.
bool is_well_formed(std::string_view xml) {
  std::vector<std::string_view> open;
  while (!xml.empty()) {
    const auto begin = xml.find('<'), end = xml.find('>', begin);
    if (begin == std::string_view::npos) return open.empty() && xml.find('"') == std::string_view::npos;
    if (end == std::string_view::npos || xml.substr(0, begin).find('"') != std::string_view::npos) return false;
    const std::string_view tag = xml.substr(begin + 1, end - begin - 1);
    xml.remove_prefix(end + 1);
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0 || tag.find('<') != std::string_view::npos) return false;
    if (tag.ends_with('/')) continue;
    if (!tag.starts_with('/')) open.push_back(tag);
    if (tag.starts_with('/')) {
      if (open.empty() || open.back() != tag.substr(1)) return false;
      open.pop_back();
    }
  }
  return open.empty();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  NetworkWish launch;
  Environment environment;
  std::string_view rest = as_text({data, size});
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    const auto equals = std::min(line.find('='), line.size());
    const std::string_view name = line.substr(0, equals), value = line.substr(std::min(equals + 1, line.size()));
    if (name == "PEER") launch.peers.emplace_back(value);
    if (name == "INTERFACE") launch.interfaces.emplace_back(value);
    if (name == "MODE") {
      if (const auto mode = parse_network_mode(value)) launch.mode = mode.value();
    }
    environment.insert_or_assign(std::string(name), std::string(value));
  }
  auto settings = network_settings(launch, environment);
  if (!settings) {
    NACELLE_EXPECT(!settings.error().where.empty() && !settings.error().what.empty(), "a problem says where and what");
    return 0;
  }
  for (const auto& remark : settings->remarks) NACELLE_EXPECT(!remark.where.empty(), "a remark says on what");
  NACELLE_EXPECT(settings->domain >= 0 && settings->domain <= kMostDomain, "a domain");
  NACELLE_EXPECT(network_line(*settings).starts_with("network: "), "a line about it");
  settings->cyclonedds_uri.clear();
  const bool is_on = settings->mode != NetworkMode::Off;
  if (is_on) NACELLE_EXPECT(is_well_formed(cyclone_config(*settings)), "a configuration that Cyclone can read");
  return 0;
}
