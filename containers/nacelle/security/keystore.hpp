// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::security {

// A keystore in SROS 2's layout, which ROS 2's programs read and `ros2 security` writes:
//
//   public/      ca.cert.pem; identity_ca.cert.pem and permissions_ca.cert.pem lead to it
//   private/     ca.key.pem; identity_ca.key.pem and permissions_ca.key.pem lead to it. Robots do not need this folder
//   enclaves/    governance.xml, governance.p7s, and for each enclave a folder:
//     robot/     cert.pem, key.pem, permissions.xml, permissions.p7s; identity_ca.cert.pem, permissions_ca.cert.pem and
//                governance.p7s lead to those above
//
// Keys and private/ are for their owner alone (0600, 0700). What is there is kept, unless a function says otherwise.
// Errors: a SecurityFault, a FileFault or a NameFault; `where` is the file. Threads: any, without a concurrent writer of the keystore.
// Source: sros2 (jazzy) keystore/_keystore.py, _enclave.py, _permission.py.

struct Change {
  enum class Kind : std::uint8_t { Made, Replaced, Kept };
  Kind kind = Kind::Made;
  std::string path;
};
using Changes = std::vector<Change>;
[[nodiscard]] const char* to_text(Change::Kind kind);  ///< "made", "replaced", "kept"

/// The authority, and governance of one domain. What is missing is made. Errors: it is complete already; an authority
/// without its key, or the other way round.
[[nodiscard]] Result<Changes, Problem> create_keystore(const std::filesystem::path& keystore, int domain, WallTime now);

struct EnclaveWish {
  std::filesystem::path keystore;
  std::string enclave;  ///< "/robot"
  int domain = 0;
  bool renew = false;  ///< Replace key and certificate, and let the permissions hold as long as they.
};
/// A key, a certificate, and permissions for everything. What is missing is made. Errors: new permissions for a domain that the
/// keystore does not govern.
[[nodiscard]] Result<Changes, Problem> create_enclave(const EnclaveWish& wish, WallTime now);
/// Replaces the permissions by what a policy file says of the enclave. Errors: as create_enclave().
[[nodiscard]] Result<Changes, Problem> create_permission(const EnclaveWish& wish, const std::filesystem::path& policy);
/// The enclaves that have a key, sorted.
[[nodiscard]] Result<std::vector<std::string>, Problem> list_enclaves(const std::filesystem::path& keystore);

/// How a keystore comes to govern one more domain, and loses none.
[[nodiscard]] std::string way_to_govern(const std::filesystem::path& keystore, int domain);
/// How an enclave is written whose name is none: "did you mean '/laptop'?"
[[nodiscard]] std::string way_to_name(const std::string& enclave);

/// Where an enclave's files lie; "/" is enclaves/ itself.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& keystore, const std::string& enclave);

}  // namespace nacelle::security
