// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::transport_dds {

/// The files of an enclave that DDS Security reads, as absolute paths.
/// Source: OMG DDS-Security 1.1, tables 47 and 56; the names of the files are SROS 2's.
struct SecurityFiles {
  std::string identity_ca, certificate, private_key;    ///< identity_ca.cert.pem, cert.pem, key.pem
  std::string permissions_ca, governance, permissions;  ///< permissions_ca.cert.pem, governance.p7s, permissions.p7s
  friend bool operator==(const SecurityFiles&, const SecurityFiles&) = default;
};

/// A verified enclave of a keystore.
struct SecuredBy {
  std::string enclave;  ///< "/robot"
  SecurityFiles files;
  std::string subject;  ///< The certificate's subject: "CN=/robot".
  std::string ends;     ///< The certificate's last day, UTC: "2036-11-19".
};

}  // namespace nacelle::transport_dds
