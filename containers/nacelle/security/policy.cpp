// SPDX-License-Identifier: Apache-2.0
// Policy files: read and written.
#include "security/policy.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "nacelle/base/xml.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

using tinyxml2::XMLElement;

struct DeedWord {
  Deed deed;
  const char *list, *item, *word;
};
constexpr std::array<DeedWord, 6> kDeeds{{{Deed::Publish, "topics", "topic", "publish"},
                                          {Deed::Subscribe, "topics", "topic", "subscribe"},
                                          {Deed::Request, "services", "service", "request"},
                                          {Deed::Reply, "services", "service", "reply"},
                                          {Deed::Call, "actions", "action", "call"},
                                          {Deed::Execute, "actions", "action", "execute"}}};

std::string shown(std::string_view text) {
  std::string out = "'";
  for (const char c : text.substr(0, 80)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + "'";
}

std::string full_name(const std::string& name, const std::string& node_namespace, const std::string& node) {
  const std::string prefix = node_namespace.ends_with('/') ? node_namespace : node_namespace + "/";
  if (name.starts_with('/')) return name;
  return name.starts_with('~') ? prefix + node + name.substr(1) : prefix + name;
}

/// Names of ROS 2, and the pattern's characters of DDS.
bool is_expression(std::string_view name) {
  constexpr std::string_view kMarks = "/_*?[]!-~";
  const auto fits = [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || kMarks.find(c) != kMarks.npos;
  };
  return !name.empty() && std::all_of(name.begin(), name.end(), fits);
}

class PolicyReader {
 public:
  explicit PolicyReader(const std::string& file) : file_(file) {}

  Result<Policy, Problem> read(const std::string& xml, const std::string& enclave) {
    tinyxml2::XMLDocument document;
    if (auto parsed = parse_xml(document, xml, file_); !parsed) {
      Problem problem = parsed.error();
      problem.code = PolicyFault::Malformed;
      return err(std::move(problem));
    }
    const XMLElement* const policy = document.RootElement();
    const XMLElement* const enclaves = policy == nullptr ? nullptr : policy->FirstChildElement("enclaves");
    if (enclaves == nullptr || policy->Name() != std::string_view("policy"))
      return err(Problem{at(0), "this is not a policy file: it has no <policy><enclaves>", "see docs/security.md",
                         PolicyFault::NotAPolicy});
    const XMLElement* const found = find(*enclaves, enclave);
    if (found == nullptr)
      return err(Problem{at(0), "it has no enclave with the path " + shown(enclave), suggestion(enclave, paths_),
                         SecurityFault::NoSuchEnclave, enclave});
    return profiles_of(*found);
  }

 private:
  [[nodiscard]] Place at(int line) const { return {file_, line}; }

  const XMLElement* find(const XMLElement& enclaves, const std::string& path) {
    for (auto* one = enclaves.FirstChildElement("enclave"); one != nullptr; one = one->NextSiblingElement("enclave")) {
      const char* const named = one->Attribute("path");
      if (named == nullptr) continue;
      if (path == named) return one;
      paths_.emplace_back(named);
    }
    return nullptr;
  }

  Result<Policy, Problem> profiles_of(const XMLElement& enclave) {
    for (auto* group = enclave.FirstChildElement(); group != nullptr; group = group->NextSiblingElement()) {
      if (auto fits = expect(*group, {"profiles"}); !fits) return err(fits.error());
      for (auto* profile = group->FirstChildElement(); profile != nullptr; profile = profile->NextSiblingElement()) {
        if (profile->Name() == std::string_view("metadata")) continue;
        if (auto fits = expect(*profile, {"profile"}); !fits) return err(fits.error());
        if (auto read = read_profile(*profile); !read) return err(read.error());
      }
    }
    return std::move(policy_);
  }

  Result<void, Problem> read_profile(const XMLElement& profile) {
    const char *const node_namespace = profile.Attribute("ns"), *const node = profile.Attribute("node");
    if (node_namespace == nullptr || node == nullptr)
      return err(
          Problem{at(profile.GetLineNum()), "a profile needs 'ns' and 'node'", "", PolicyFault::MissingAttribute});
    for (auto* list = profile.FirstChildElement(); list != nullptr; list = list->NextSiblingElement()) {
      if (auto fits = expect(*list, {"topics", "services", "actions"}); !fits) return fits;
      if (auto read = read_list(*list, node_namespace, node); !read) return read;
    }
    return {};
  }

  Result<void, Problem> read_list(const XMLElement& list, const std::string& node_namespace, const std::string& node) {
    std::vector<std::string> names;
    for (auto* item = list.FirstChildElement(); item != nullptr; item = item->NextSiblingElement()) {
      const std::string singular = std::string(list.Name()).substr(0, std::string_view(list.Name()).size() - 1);
      if (auto fits = expect(*item, {singular}); !fits) return fits;
      const std::string name = item->GetText() == nullptr ? "" : item->GetText();
      if (!is_expression(name))
        return err(Problem{at(item->GetLineNum()), shown(name) + " is not a name of a " + singular,
                           "/scan, scan, ~/scan or /*", PolicyFault::WrongValue, name});
      names.push_back(full_name(name, node_namespace, node));
    }
    for (auto* word = list.FirstAttribute(); word != nullptr; word = word->Next()) {
      if (word->Name() == std::string_view("xml:base")) continue;
      if (auto taken = take(list, *word, names); !taken) return taken;
    }
    return {};
  }

  Result<void, Problem> take(const XMLElement& list, const tinyxml2::XMLAttribute& word,
                             const std::vector<std::string>& names) {
    std::vector<std::string> known;
    for (const auto& deed : kDeeds) {
      if (list.Name() != std::string_view(deed.list)) continue;
      known.emplace_back(deed.word);
      if (word.Name() != std::string_view(deed.word)) continue;
      const std::string_view value = word.Value();
      if (value != "ALLOW" && value != "DENY")
        return err(Problem{at(list.GetLineNum()), "'" + known.back() + "' cannot be " + shown(value), "ALLOW or DENY",
                           PolicyFault::WrongValue, std::string(value)});
      policy_.push_back({deed.deed, value == "ALLOW", names});
      return {};
    }
    return err(Problem{at(list.GetLineNum()), std::string("'") + list.Name() + "' has no " + shown(word.Name()),
                       suggestion(word.Name(), known), PolicyFault::UnknownAttribute, word.Name()});
  }

  Result<void, Problem> expect(const XMLElement& found, const std::vector<std::string>& names) const {
    if (std::find(names.begin(), names.end(), found.Name()) != names.end()) return {};
    const bool includes = std::string_view(found.Name()).find("include") != std::string_view::npos;
    return err(Problem{at(found.GetLineNum()), "unexpected element " + shown(found.Name()),
                       includes ? "includes are written <xi:include href=.../>" : suggestion(found.Name(), names),
                       PolicyFault::UnknownElement, found.Name()});
  }

  const std::string& file_;
  Policy policy_;
  std::vector<std::string> paths_;
};

std::string list_of(const DeedWord& deed, const std::set<std::string>& names) {
  if (names.empty()) return {};
  std::string text = fmt::format("          <{} {}=\"ALLOW\">\n", deed.list, deed.word);
  for (const auto& name : names) text += fmt::format("            <{0}>{1}</{0}>\n", deed.item, name);
  return text + fmt::format("          </{}>\n", deed.list);
}

}  // namespace

Policy everything() {
  Policy all;
  for (const auto& deed : kDeeds) all.push_back({deed.deed, true, {"/*"}});
  return all;
}

Result<Policy, Problem> read_policy(const std::string& xml, const std::string& file, const std::string& enclave) {
  return PolicyReader{file}.read(xml, enclave);
}

std::string policy_xml(const std::string& enclave, const std::vector<NodeProfile>& profiles) {
  std::string text =
      fmt::format("<policy version=\"0.2.0\">\n  <enclaves>\n    <enclave path=\"{}\">\n      <profiles>\n", enclave);
  for (const auto& profile : profiles) {
    text += fmt::format("        <profile node=\"{}\" ns=\"{}\">\n", profile.name, profile.node_namespace);
    text += list_of(kDeeds[3], profile.replies) + list_of(kDeeds[2], profile.requests) +
            list_of(kDeeds[1], profile.subscribes) + list_of(kDeeds[0], profile.publishes);
    text += "        </profile>\n";
  }
  return text + "      </profiles>\n    </enclave>\n  </enclaves>\n</policy>\n";
}

}  // namespace nacelle::security
