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

// What an enclave may do, in ROS 2's words (SROS 2's policy files), and the same in DDS's (permissions, governance).
// Pure. Threads: any.
// Source: policy.xsd, policy.xml, permissions.xsl, governance.xml of sros2 (jazzy); OMG DDS-Security 1.1 section 9.4.1.

enum class Deed : std::uint8_t { Publish, Subscribe, Reply, Request, Call, Execute };

/// Full names ("/scan", "/arm/*") that may, or must not, be used in a way.
struct Permit {
  Deed deed = Deed::Publish;
  bool allowed = true;
  std::vector<std::string> names;
  friend bool operator==(const Permit&, const Permit&) = default;
};
using Policy = std::vector<Permit>;

/// What a new enclave may: everything.
[[nodiscard]] Policy everything();

/// A policy file's rules for an enclave. Relative and private names ("scan", "~/scan") are made full ones.
/// Errors: a PolicyFault, or SecurityFault::NoSuchEnclave; `where` is the file with its line.
[[nodiscard]] Result<Policy, Problem> read_policy(const std::string& xml, const std::string& file,
                                                  const std::string& enclave);

/// DDS Security's domains end earlier than DDS's: its plugins refuse a document with a higher one.
inline constexpr int kMostSecuredDomain = 230;

struct Validity {
  WallTime begins, ends;
};
/// The permissions of the owner of a certificate with this common name, in one domain. What is not allowed is denied, but
/// for ros_discovery_info, without which a participant is no ROS 2 node.
[[nodiscard]] std::string permissions_xml(const Policy& policy, const std::string& common_name,
                                          const Validity& validity, int domain);
/// Everybody needs a certificate, every topic has access control, everything is encrypted.
[[nodiscard]] std::string governance_xml(int domain);

/// What a node does: the lines of a policy file.
struct NodeProfile {
  std::string node_namespace, name;
  std::set<std::string> publishes, subscribes, replies, requests;  ///< Full names.
};
[[nodiscard]] std::string policy_xml(const std::string& enclave, const std::vector<NodeProfile>& profiles);

/// What a permissions document says of an owner of a certificate.
struct Grant {
  Validity validity;
  bool covers_domain = false;
};
/// Nothing: no grant is for this subject ("CN=/robot") as it is written, and names of several parts are among them, which DDS
/// takes in any order. Errors: a SecurityFault (NotADocument, WrongDate, OtherSubject).
[[nodiscard]] Result<std::optional<Grant>, Problem> find_grant(const std::string& permissions,
                                                               const std::string& subject, int domain);
/// Errors: SecurityFault::NotADocument.
[[nodiscard]] Result<bool, Problem> governs(const std::string& governance, int domain);

}  // namespace nacelle::security
