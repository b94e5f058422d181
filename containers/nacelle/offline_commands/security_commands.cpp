// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>

#include "cli/asking.hpp"
#include "cli/program.hpp"
#include "nacelle/base/network_names.hpp"
#include "networking/network_wish.hpp"
#include "offline_commands/commands.hpp"
#ifdef NACELLE_HAS_SECURITY
#include "security/files.hpp"
#include "security/keystore.hpp"
#include "security/policy.hpp"
#endif

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct SecurityWords {
  std::string keystore, enclave, policy;
  Whom whom;
  std::string domain;  ///< Empty: ROS_DOMAIN_ID's.
  bool renew = false, as_json = false;
};

#ifdef NACELLE_HAS_SECURITY

Result<int, Problem> domain_of(const SecurityWords& words) {
  transport_dds::Environment environment = networking::ros_environment();
  if (!words.domain.empty()) environment["ROS_DOMAIN_ID"] = words.domain;
  auto read = transport_dds::read_environment(environment);
  if (!read) {
    Problem problem = read.error();
    if (!words.domain.empty()) problem.where = "--domain";
    return err(std::move(problem));
  }
  const int domain = read.value().domain.value_or(0);
  if (domain <= security::kMostSecuredDomain) return domain;
  return err(Problem{words.domain.empty() ? "ROS_DOMAIN_ID" : "--domain",
                     "there is no security in domain " + std::to_string(domain),
                     "take one from 0 to " + std::to_string(security::kMostSecuredDomain)});
}

int show(const Result<security::Changes, Problem>& changes, bool as_json) {
  if (!changes) return complain(changes.error());
  json rows = json::array();
  for (const auto& change : changes.value()) {
    rows.push_back({{"path", change.path}, {"what", security::to_text(change.kind)}});
    if (!as_json) std::printf("%-8s %s\n", security::to_text(change.kind), change.path.c_str());
  }
  if (as_json) std::printf("%s\n", rows.dump(2).c_str());
  return kDone;
}

int make_keystore(const SecurityWords& words) {
  const auto domain = domain_of(words);
  if (!domain) return complain_of_usage(domain.error());
  return show(security::create_keystore(words.keystore, domain.value(), SystemClock{}.wall_now()), words.as_json);
}

int make_enclave(const SecurityWords& words) {
  const auto domain = domain_of(words);
  if (!domain) return complain_of_usage(domain.error());
  return show(
      security::create_enclave({words.keystore, words.enclave, domain.value(), words.renew}, SystemClock{}.wall_now()),
      words.as_json);
}

int make_permission(const SecurityWords& words) {
  const auto domain = domain_of(words);
  if (!domain) return complain_of_usage(domain.error());
  return show(security::create_permission({words.keystore, words.enclave, domain.value()}, words.policy),
              words.as_json);
}

int list_all(const SecurityWords& words) {
  const auto enclaves = security::list_enclaves(words.keystore);
  if (!enclaves) return complain(enclaves.error());
  print_names(enclaves.value(), false, words.as_json);
  return kDone;
}

std::vector<security::NodeProfile> profiles_of(const json& graph) {
  std::map<std::string, security::NodeProfile> nodes;
  const auto of = [&](const json& row) -> security::NodeProfile& {
    const std::string node = text_of(row, "node");
    const auto slash = node.rfind('/');
    security::NodeProfile& profile = nodes[node];
    profile.node_namespace = slash == 0 ? "/" : node.substr(0, slash);
    profile.name = node.substr(slash + 1);
    return profile;
  };
  for (const auto& end : graph["endpoints"])
    (end["publisher"].get<bool>() ? of(end).publishes : of(end).subscribes).insert(text_of(end, "topic"));
  for (const auto& service : graph["services"])
    (service["server"].get<bool>() ? of(service).replies : of(service).requests).insert(text_of(service, "name"));
  std::vector<security::NodeProfile> profiles;
  for (auto& [name, profile] : nodes) profiles.push_back(std::move(profile));
  return profiles;
}

int write_policy(const SecurityWords& words) {
  if (std::filesystem::exists(words.policy))
    return complain({words.policy, "it is there already", "name another file, and take over what is new"});
  auto graph = graph_of(words.whom);
  if (!graph) return graph.error();
  const auto profiles = profiles_of(graph.value());
  const auto done =
      security::write_file(words.policy, security::policy_xml(words.enclave, profiles), security::Secrecy::Public);
  if (!done) return complain(done.error());
  if (words.as_json) {
    std::printf("%s\n", json{{"path", words.policy}, {"nodes", profiles.size()}}.dump(2).c_str());
  } else {
    std::printf("made     %s: what %zu nodes do\n", words.policy.c_str(), profiles.size());
  }
  return kDone;
}

#else

int refuse(const SecurityWords&) { return complain(networking::security_is_not_built_in("security")); }
constexpr auto make_keystore = refuse, make_enclave = refuse, make_permission = refuse, list_all = refuse,
               write_policy = refuse;

#endif

/// ros2's own spelling works too.
void add_command(Command& group, const std::string& name, const std::string& what, int (*run)(const SecurityWords&),
                 const std::function<void(Command&, SecurityWords&)>& describe) {
  std::string with_underscores = name;
  std::replace(with_underscores.begin(), with_underscores.end(), '-', '_');
  for (const auto& spelling : {name, with_underscores}) {
    auto words = std::make_shared<SecurityWords>();
    Command& command = group.add(spelling, what);
    if (spelling != name) command.hidden();
    describe(command, *words);
    command.flag("--json", words->as_json, "print JSON");
    command.runs([words, run] { return run(*words); });
  }
}

void add_keystore(Command& command, SecurityWords& words) {
  command.option("keystore", words.keystore, "the keystore's folder").required().names_a(Names::File);
}

void add_enclave(Command& command, SecurityWords& words) {
  command.option("enclave", words.enclave, "its name: /robot").required();
}

void add_domain(Command& command, SecurityWords& words) {
  command.option("--domain", words.domain, "the domain of the documents (default: ROS_DOMAIN_ID, else 0)").value("ID");
}

}  // namespace

void add_security_commands(Command& root) {
  Command& group = root.add("security", "create keys and permissions for DDS Security");
  add_command(
      group, "create-keystore", "create a certificate authority and the governance document of a domain", make_keystore,
      [](Command& command, SecurityWords& words) {
        add_keystore(command, words);
        add_domain(command, words);
        command.note(
            "The layout is SROS 2's. The folder private/ is the certificate authority: keep it off the robots.");
      });
  add_command(group, "create-enclave", "create key, certificate and permissions of a participant", make_enclave,
              [](Command& command, SecurityWords& words) {
                add_keystore(command, words);
                add_enclave(command, words);
                add_domain(command, words);
                command.flag("--renew", words.renew,
                             "replace key and certificate; the permissions hold as long as they");
                command.note("Existing files are kept. A new enclave may use every topic, service and action.");
              });
  add_command(group, "create-permission", "replace an enclave's permissions with those of a policy file",
              make_permission, [](Command& command, SecurityWords& words) {
                add_keystore(command, words);
                add_enclave(command, words);
                command.option("policy", words.policy, "SROS 2's policy file").required().names_a(Names::File);
                add_domain(command, words);
              });
  add_command(group, "list-enclaves", "list the enclaves of a keystore", list_all, add_keystore);
  add_command(
      group, "generate-policy", "write a policy file that allows what a running robot does", write_policy,
      [](Command& command, SecurityWords& words) {
        command.option("policy", words.policy, "the file; it must not exist yet").required().names_a(Names::File);
        words.enclave = "/";
        command.option("--enclave", words.enclave, "the enclave of the policy").with_default();
        add_container_option(command, words.whom.container);
      });
}

}  // namespace nacelle::cli
