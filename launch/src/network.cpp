// SPDX-License-Identifier: Apache-2.0
// `network:` of a launch file, and the command line's `network:=MODE`.
#include <algorithm>

#include "builder.hpp"
#include "nacelle/base/network_names.hpp"

namespace nacelle::launch {
namespace {

const std::vector<std::string> kModes{"off", "local", "export"};
const std::vector<std::string> kStrategies{"Enforce", "Permissive"};
// Above any robot's needs.
constexpr double kMostHz = 1e6;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40U;

}  // namespace

const char* to_text(NetworkMode mode) { return kModes[static_cast<std::size_t>(mode)].c_str(); }

Result<NetworkMode, Problem> parse_network_argument(const std::string& value) {
  const auto found = std::find(kModes.begin(), kModes.end(), value);
  if (found != kModes.end()) return static_cast<NetworkMode>(found - kModes.begin());
  const std::string shown = value.substr(0, 80);
  return err(Problem{"network:=" + shown, "'" + shown + "' is not a mode of the network", suggestion(shown, kModes),
                     LaunchFault::WrongValue});
}

void Builder::network(const Element& element, Scope& scope) {
  NetworkPlan& made = plan_.network;
  if (made.declared) {
    return report(at(element.line), LaunchFault::Twice, "a second 'network'; the first is at " + made.where.text(),
                  "a container has one network: put both into one, or give them `if`");
  }
  made.declared = true;
  made.where = at(element.line);
  if (const auto mode = word(element, "mode", kModes, scope)) made.mode = static_cast<NetworkMode>(*mode);
  if (const auto domain = count(element, "domain_id", kMostDomain, scope)) made.domain_id = static_cast<int>(*domain);
  made.allow_load = flag(element, "allow_load", false, scope);
  made.remote_control = flag(element, "remote_control", false, scope);
  const auto take = [&](const char* key, auto validate, std::vector<std::string>& into) {
    for (const auto& one : words_of(element, key, scope)) {
      if (const auto valid = validate(one); !valid) {
        report(at(element.find(key)->line), valid.error());
      } else if (std::find(into.begin(), into.end(), one) == into.end()) {
        into.push_back(one);
      }
    }
  };
  take("interfaces", validate_interface, made.interfaces);
  take("peers", validate_peer, made.peers);
  if (const Attribute* const list = element.find("export"); list != nullptr && list->is_list && list->values.empty())
    report(at(list->line), LaunchFault::WrongValue, "an empty list of exports shows nothing",
           "leave it out to export every topic, or take mode: local");
  for (const auto& topic : words_of(element, "export", scope)) {
    add_export({topic, 0, 0, false, at(element.find("export")->line)}, scope);
  }
  for (const auto& child : element.children) {
    if (child.name == "security") {
      read_security(child, scope);
    } else {
      read_export(child, scope);
    }
  }
}

void Builder::read_security(const Element& element, Scope& scope) {
  SecurityPlan made;
  made.where = at(element.line);
  if (const auto folder = text(element, "keystore", scope)) made.keystore = beside_file(*folder);
  if (const auto enclave = text(element, "enclave", scope)) {
    if (const auto valid = validate_namespace(*enclave); !valid)
      return report(at(element.find("enclave")->line), LaunchFault::WrongValue, "as an enclave: " + valid.error().what);
    made.enclave = *enclave;
  }
  if (const auto strategy = word(element, "strategy", kStrategies, scope)) made.enforced = *strategy == 0;
  plan_.network.security = std::move(made);
}

void Builder::read_export(const Element& element, Scope& scope) {
  const auto topic = text(element, "topic", scope);
  if (!topic) return;
  ExportPlan made{*topic, 0, 0, flag(element, "compressed_only", false, scope), at(element.line)};
  if (const auto hz = text(element, "max_hz", scope)) {
    const auto number = value_of_type(*hz, ForcedType::Float);
    const double* const value = number ? std::get_if<double>(&*number) : nullptr;
    if (value == nullptr || !(*value > 0 && *value <= kMostHz)) {
      return report(at(element.find("max_hz")->line), LaunchFault::WrongValue,
                    "'max_hz' must be a number above 0, not '" + hz->substr(0, 60) + "'",
                    "leave it out for every message");
    }
    made.max_hz = *value;
  }
  if (const auto bytes = count(element, "max_bytes", kMostBytes, scope)) {
    if (*bytes == 0) {
      return report(at(element.find("max_bytes")->line), LaunchFault::WrongValue,
                    "'max_bytes' of 0 lets nothing through", "leave the topic out of the list, or leave the limit out");
    }
    made.max_bytes_per_s = *bytes;
  }
  add_export(std::move(made), scope);
}

void Builder::add_export(ExportPlan made, const Scope& scope) {
  made.topic = join_namespaces(scope.namespace_, made.topic);
  if (const auto valid = validate_full_topic_name(made.topic); !valid) return report(made.where, valid.error());
  for (const auto& other : plan_.network.exports) {
    if (other.topic != made.topic) continue;
    return report(made.where, LaunchFault::Twice,
                  "the topic '" + made.topic + "' is exported a second time; the first is at " + other.where.text());
  }
  plan_.network.exports.push_back(std::move(made));
}

// The bring-up's last line suggests this argument, so it works with every file that does not use the name otherwise.
void Builder::apply_network_argument() {
  const auto given = arguments_.find(kNetworkArgument);
  if (given == arguments_.end() || declared_.count(kNetworkArgument) != 0) return;
  const auto mode = parse_network_argument(given->second);
  if (!mode) return problems_.push_back(mode.error());
  plan_.network.mode = *mode;
  plan_.network.mode_by_argument = true;
}

}  // namespace nacelle::launch
