// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::security {

// A keystore in SROS 2's layout, which ROS 2's programs read and `ros2 security` writes (-> is a symbolic link):
//
//   public/      ca.cert.pem; identity_ca.cert.pem and permissions_ca.cert.pem -> ca.cert.pem
//   private/     ca.key.pem; identity_ca.key.pem and permissions_ca.key.pem -> ca.key.pem. Robots do not need it
//   enclaves/    governance.xml, governance.p7s, and for each enclave a folder:
//     robot/     cert.pem, key.pem, permissions.xml, permissions.p7s; identity_ca.cert.pem, permissions_ca.cert.pem and
//                governance.p7s -> those above
//
// Only the owner can read keys and private/ (0600, 0700). Existing files are kept, unless a function says otherwise.
// Errors: a SecurityFault, a FileFault or a NameFault; `where` is the file.
// Threads: any, without a concurrent writer of the keystore.
// Source: sros2 (jazzy) keystore/_keystore.py, _enclave.py, _permission.py.

struct Change {
  enum class Kind : std::uint8_t { Made, Replaced, Kept };
  Kind kind = Kind::Made;
  std::string path;
};
using Changes = std::vector<Change>;
[[nodiscard]] const char* to_text(Change::Kind kind);  ///< "made", "replaced", "kept"

/// Makes the missing parts of a keystore: the authority, and the governance document of one domain.
/// Errors: the keystore is complete already; an authority has a key without a certificate, or a certificate without a
/// key.
[[nodiscard]] Result<Changes, Problem> create_keystore(const std::filesystem::path& keystore, int domain, WallTime now);

struct EnclaveWish {
  std::filesystem::path keystore;
  std::string enclave;  ///< "/robot"
  int domain = 0;
  bool renew = false;  ///< Replace key and certificate, and adapt the permissions' times.
};
/// Makes the missing parts of an enclave: a key, a certificate, and permissions for everything.
/// Errors: new permissions for a domain that the keystore does not govern.
[[nodiscard]] Result<Changes, Problem> create_enclave(const EnclaveWish& wish, WallTime now);
/// Replaces the permissions by those of a policy file for the enclave. Errors: as create_enclave(); the enclave does
/// not exist.
[[nodiscard]] Result<Changes, Problem> create_permission(const EnclaveWish& wish, const std::filesystem::path& policy);
/// Returns the enclaves that have a key, sorted.
[[nodiscard]] Result<std::vector<std::string>, Problem> list_enclaves(const std::filesystem::path& keystore);

/// Returns the instructions for adding a domain to a keystore's governance.
[[nodiscard]] std::string way_to_govern(const std::filesystem::path& keystore, int domain);
/// Returns the hint for an invalid enclave name: "did you mean '/laptop'?"
[[nodiscard]] std::string way_to_name(const std::string& enclave);

/// Returns the folder of an enclave's files; for "/" it is enclaves/ itself.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& keystore, const std::string& enclave);

}  // namespace nacelle::security
