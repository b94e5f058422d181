// SPDX-License-Identifier: Apache-2.0
// Permissions and governance: DDS's words.
#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>

#include "nacelle/base/xml.hpp"
#include "security/certificate.hpp"
#include "security/policy.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

using tinyxml2::XMLElement;
using Topics = std::vector<std::string>;

constexpr const char* kNamespace =
    "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
    "xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-SECURITY/20170901/";

/// The topics that a deed writes to, or reads from.
Topics topics_of(const Permit& permit, bool writes) {
  const auto service = [&](Topics& into, const std::string& name, bool request) {
    into.push_back(request ? "rq" + name + "Request" : "rr" + name + "Reply");
  };
  const auto action = [&](Topics& into, const std::string& name, bool request) {
    for (const char* const part : {"cancel_goal", "get_result", "send_goal"})
      service(into, name + "/_action/" + part, request);
    if (request) return;
    into.push_back("rt" + name + "/_action/feedback");
    into.push_back("rt" + name + "/_action/status");
  };
  Topics topics;
  for (const auto& name : permit.names) {
    switch (permit.deed) {
      case Deed::Publish:
      case Deed::Subscribe:
        if (writes == (permit.deed == Deed::Publish)) topics.push_back("rt" + name);
        break;
      case Deed::Request: service(topics, name, writes); break;
      case Deed::Reply: service(topics, name, !writes); break;
      case Deed::Call: action(topics, name, writes); break;
      case Deed::Execute: action(topics, name, !writes); break;
    }
  }
  return topics;
}

/// Those of all such permits, in SROS 2's order, each once.
Topics topics_of(const Policy& policy, bool allowed, bool writes) {
  std::vector<Topics> groups;
  for (const auto& permit : policy) {
    if (permit.allowed != allowed) continue;
    if (Topics group = topics_of(permit, writes); !group.empty()) groups.push_back(std::move(group));
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Topics& a, const Topics& b) { return a.front() < b.front(); });
  Topics all;
  for (auto& group : groups) {
    for (auto& topic : group) {
      if (std::find(all.begin(), all.end(), topic) == all.end()) all.push_back(std::move(topic));
    }
  }
  return all;
}

std::string section(const char* name, const Topics& topics) {
  if (topics.empty()) return {};
  std::string text = fmt::format("        <{}>\n          <topics>\n", name);
  for (const auto& topic : topics) text += "            <topic>" + xml_escaped(topic) + "</topic>\n";
  return text + fmt::format("          </topics>\n        </{}>\n", name);
}

std::string rule(const char* name, int domain, const Topics& published, const Topics& subscribed) {
  if (published.empty() && subscribed.empty()) return {};
  return fmt::format("      <{0}>\n        <domains>\n          <id>{1}</id>\n        </domains>\n{2}{3}      </{0}>\n",
                     name, domain, section("publish", published), section("subscribe", subscribed));
}

bool covers(const XMLElement& rule, int domain) {
  const XMLElement* const domains = rule.FirstChildElement("domains");
  if (domains == nullptr) return false;
  for (auto* one = domains->FirstChildElement(); one != nullptr; one = one->NextSiblingElement()) {
    if (one->Name() == std::string_view("id") && one->IntText(-1) == domain) return true;
    if (one->Name() != std::string_view("id_range")) continue;
    const XMLElement *const least = one->FirstChildElement("min"), *const most = one->FirstChildElement("max");
    const bool above = least == nullptr || least->IntText(0) <= domain;
    if (above && (most == nullptr || most->IntText(0) >= domain)) return true;
  }
  return false;
}

/// <dds><`name`> of a document.
Result<const XMLElement*, Problem> content_of(tinyxml2::XMLDocument& document, const std::string& xml,
                                              const char* name) {
  if (auto parsed = parse_xml(document, xml, "XML"); !parsed) {
    Problem problem = parsed.error();
    problem.code = SecurityFault::NotADocument;
    return err(std::move(problem));
  }
  const XMLElement* const found = document.RootElement()->FirstChildElement(name);
  if (found == nullptr)
    return err(Problem{"", std::string("it has no <") + name + ">", "", SecurityFault::NotADocument});
  return found;
}

std::string text_of(const XMLElement* element) {
  return element == nullptr || element->GetText() == nullptr ? "" : element->GetText();
}

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin);
}

/// One part, "CN=/robot", as SROS 2 makes them: the plugin has no other way to compare it than text.
bool is_of_one_part(const std::string& subject) {
  return subject.starts_with("CN=") && subject.find_first_of(",+\\|=", 3) == std::string::npos;
}

}  // namespace

std::string permissions_xml(const Policy& policy, const std::string& common_name, const Validity& validity,
                            int domain) {
  const Topics graph{"ros_discovery_info"};
  const std::string name = xml_escaped(common_name);
  return fmt::format(
             "<dds {}omg_shared_ca_permissions.xsd\">\n  <permissions>\n    <grant name=\"{}\">\n"
             "      <subject_name>CN={}</subject_name>\n      <validity>\n        <not_before>{}</not_before>\n"
             "        <not_after>{}</not_after>\n      </validity>\n",
             kNamespace, name, name, utc_text(validity.begins), utc_text(validity.ends)) +
         rule("deny_rule", domain, topics_of(policy, false, true), topics_of(policy, false, false)) +
         rule("allow_rule", domain, topics_of(policy, true, true), topics_of(policy, true, false)) +
         rule("allow_rule", domain, graph, graph) +
         "      <default>DENY</default>\n    </grant>\n  </permissions>\n</dds>\n";
}

std::string governance_xml(int domain) {
  return fmt::format(
      R"(<dds {}omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains>
        <id>{}</id>
      </domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)",
      kNamespace, domain);
}

Result<std::optional<Grant>, Problem> find_grant(const std::string& permissions, const std::string& subject,
                                                 int domain) {
  tinyxml2::XMLDocument document;
  const auto grants = content_of(document, permissions, "permissions");
  if (!grants) return err(grants.error());
  std::vector<std::string> others;
  for (auto* one = grants.value()->FirstChildElement("grant"); one != nullptr; one = one->NextSiblingElement("grant")) {
    if (const auto name = trimmed(text_of(one->FirstChildElement("subject_name"))); name != subject) {
      others.push_back(name);
      continue;
    }
    const XMLElement* const validity = one->FirstChildElement("validity");
    if (validity == nullptr)
      return err(Problem{"", "the grant for " + subject + " has no <validity>", "", SecurityFault::NotADocument});
    const auto begins = read_utc(text_of(validity->FirstChildElement("not_before")));
    const auto ends = read_utc(text_of(validity->FirstChildElement("not_after")));
    if (!begins) return err(begins.error());
    if (!ends) return err(ends.error());
    Grant grant{{begins.value(), ends.value()}, false};
    for (auto* rule = one->FirstChildElement("allow_rule"); rule != nullptr;
         rule = rule->NextSiblingElement("allow_rule"))
      grant.covers_domain = grant.covers_domain || covers(*rule, domain);
    return std::optional(grant);
  }
  if (!is_of_one_part(subject) || !std::all_of(others.begin(), others.end(), is_of_one_part))
    return std::optional<Grant>{};
  const std::string whose = others.empty() ? "it has no <grant>" : "it is for " + others.front().substr(0, 80);
  return err(Problem{"", whose + ", and the certificate is for " + subject, "", SecurityFault::OtherSubject, subject});
}

Result<bool, Problem> governs(const std::string& governance, int domain) {
  tinyxml2::XMLDocument document;
  const auto rules = content_of(document, governance, "domain_access_rules");
  if (!rules) return err(rules.error());
  for (auto* one = rules.value()->FirstChildElement("domain_rule"); one != nullptr;
       one = one->NextSiblingElement("domain_rule")) {
    if (covers(*one, domain)) return true;
  }
  return false;
}

}  // namespace nacelle::security
