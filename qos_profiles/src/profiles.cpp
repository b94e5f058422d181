// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/profiles.hpp"

#include <algorithm>
#include <iterator>

#include "nacelle/base/files.hpp"
#include "nacelle/qos/presets.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle {
namespace {

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {}

  void read(const YamlNode& root) {
    if (!root.is_map())
      return report(root.line, std::string("expected a map with the key 'profiles', found ") + root.kind_text());
    for (const YamlNode& entry : root.items) {
      if (entry.key != "profiles") {
        report(entry.key_line, "unknown key '" + entry.key + "'", suggestion(entry.key, {"profiles"}));
      } else if (!entry.is_map()) {
        report(entry.line, std::string("'profiles' must be a map of names, not ") + entry.kind_text());
      } else {
        for (const YamlNode& profile : entry.items) read_profile(profile);
      }
    }
  }
  std::vector<Profile> profiles;
  std::vector<Problem> problems;

 private:
  void report(int line, std::string what, std::string way_out = {}) {
    problems.push_back({Place(file_, line), std::move(what), std::move(way_out)});
  }

  void read_profile(const YamlNode& node) {
    const auto same =
        std::find_if(profiles.begin(), profiles.end(), [&](const Profile& p) { return p.name == node.key; });
    if (same != profiles.end())
      return report(node.key_line, "the profile '" + node.key + "' is already at " + same->where);
    if (!node.is_map()) {
      return report(node.line, "the profile '" + node.key + "' must be a map of policies, not " + node.kind_text());
    }
    QosPatch patch;
    std::vector<std::string> seen;
    for (const YamlNode& policy : node.items) {
      if (std::find(seen.begin(), seen.end(), policy.key) != seen.end()) {
        report(policy.key_line, "the key '" + policy.key + "' stands here a second time");
      } else if (!policy.is_scalar()) {
        report(policy.line, "'" + policy.key + "' must be one value, not " + policy.kind_text());
      } else if (auto ok = set_policy(patch, policy.key, policy.text); !ok) {
        report(policy.key_line, ok.error().what, ok.error().way_out);
      }
      seen.push_back(policy.key);
    }
    auto qos = ProfileSet(profiles).apply(patch, QoS(10));
    if (!qos) return report(node.key_line, qos.error().what, qos.error().way_out);
    profiles.push_back({node.key, *qos, file_ + ":" + std::to_string(node.key_line)});
  }

  const std::string& file_;
};

}  // namespace

Result<QoS, Problem> ProfileSet::find(std::string_view name) const {
  for (const auto& profile : profiles_) {
    if (profile.name == name) return profile.qos;
  }
  if (const auto known = preset(name)) return *known;
  const std::string shown(name.substr(0, 60));
  return err(Problem{"", "no QoS profile has the name '" + shown + "'", suggestion(shown, names())});
}

Result<QoS, Problem> ProfileSet::apply(const QosPatch& patch, const QoS& base) const {
  if (!patch.profile) return patch.applied_to(base);
  auto start = find(*patch.profile);
  if (!start) return start;
  return patch.applied_to(*start);
}

std::vector<std::string> ProfileSet::names() const {
  std::vector<std::string> all;
  for (const auto& profile : profiles_) all.push_back(profile.name);
  all.insert(all.end(), preset_names().begin(), preset_names().end());
  return all;
}

Result<ProfileSet, std::vector<Problem>> parse_profiles(std::string_view text, const std::string& file_name) {
  const auto root = parse_yaml(text, file_name);
  if (!root) return err(std::vector<Problem>{root.error()});
  Reader reader(file_name);
  reader.read(*root);
  if (!reader.problems.empty()) return err(std::move(reader.problems));
  return ProfileSet(std::move(reader.profiles));
}

Result<ProfileSet, std::vector<Problem>> load_profiles(const std::string& path) {
  const auto text = read_regular_file(path, kMaxYamlBytes);
  if (!text) return err(std::vector<Problem>{text.error()});
  return parse_profiles(text.value(), path);
}

}  // namespace nacelle
