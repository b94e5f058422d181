// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::security {

// The rights of an enclave in ROS 2's terms (SROS 2's policy files) and in DDS's (permissions, governance).
// Pure. Threads: any.
// Source: policy.xsd, policy.xml, permissions.xsl, governance.xml of sros2 (jazzy); OMG DDS-Security 1.1 section 9.4.1.

enum class Deed : std::uint8_t { Publish, Subscribe, Reply, Request, Call, Execute };

/// Full names ("/scan", "/arm/*") whose use in one way is allowed or denied.
struct Permit {
  Deed deed = Deed::Publish;
  bool allowed = true;
  std::vector<std::string> names;
  friend bool operator==(const Permit&, const Permit&) = default;
};
using Policy = std::vector<Permit>;

/// Returns the policy of a new enclave, which allows everything.
[[nodiscard]] Policy everything();

/// Returns a policy file's rules for an enclave. Relative and private names ("scan", "~/scan") become full names.
/// Errors: a PolicyFault, or SecurityFault::NoSuchEnclave; `where` is the file with its line.
[[nodiscard]] Result<Policy, Problem> read_policy(const std::string& xml, const std::string& file,
                                                  const std::string& enclave);

/// The highest domain that DDS Security's plugins accept; DDS itself has more.
inline constexpr int kMostSecuredDomain = 230;

struct Validity {
  WallTime begins, ends;
};
/// Returns the permissions document of a certificate's common name, for one domain. Everything that is not allowed is
/// denied, except ros_discovery_info, which a participant needs to be a ROS 2 node.
[[nodiscard]] std::string permissions_xml(const Policy& policy, const std::string& common_name,
                                          const Validity& validity, int domain);
/// Returns a governance document: every participant needs a certificate, every topic has access control, discovery and
/// data are encrypted, and RTPS messages are signed.
[[nodiscard]] std::string governance_xml(int domain);

/// The names that a node uses, for the lines of a policy file.
struct NodeProfile {
  std::string node_namespace, name;
  std::set<std::string> publishes, subscribes, replies, requests;  ///< Full names.
};
[[nodiscard]] std::string policy_xml(const std::string& enclave, const std::vector<NodeProfile>& profiles);

/// The grant of a permissions document for one certificate.
struct Grant {
  Validity validity;
  bool covers_domain = false;
};
/// Returns the grant for a subject ("CN=/robot"). Returns nothing if no subject matches literally and one of the names
/// has several parts, whose order DDS ignores. Errors: a SecurityFault (NotADocument, WrongDate, OtherSubject).
[[nodiscard]] Result<std::optional<Grant>, Problem> find_grant(const std::string& permissions,
                                                               const std::string& subject, int domain);
/// Returns whether a governance document covers a domain. Errors: SecurityFault::NotADocument.
[[nodiscard]] Result<bool, Problem> governs(const std::string& governance, int domain);

}  // namespace nacelle::security
