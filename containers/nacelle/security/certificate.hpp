// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::security {

// Keys, certificates and signed documents as SROS 2 makes them, by OpenSSL's library. Texts are PEM, documents S/MIME.
// Pure: what is read and written is given. Threads: any. Errors: a SecurityFault without `where`; the caller knows the file.
// Source: sros2 (jazzy) _utilities.py; OMG DDS-Security 1.1 sections 9.3.1 and 9.4.1.

/// An elliptic key (P-256), and what an authority says of its owner.
struct KeyAndCertificate {
  std::string key, certificate;
};

inline constexpr Duration kValidity = std::chrono::hours(24) * 3650;
inline constexpr std::size_t kMaxCommonNameBytes = 64;  ///< X.509's ub-common-name.

/// A certificate that signs others, signed by itself, valid from `now` on.
[[nodiscard]] Result<KeyAndCertificate, Problem> make_authority(const std::string& common_name, WallTime now);
/// A certificate signed by `authority`.
[[nodiscard]] Result<KeyAndCertificate, Problem> make_certificate(const std::string& common_name,
                                                                  const KeyAndCertificate& authority, WallTime now);

struct CertificateFacts {
  std::string subject;      ///< "CN=/robot"
  std::string common_name;  ///< "/robot"; empty if it has none.
  WallTime begins, ends;    ///< Whole seconds.
};
[[nodiscard]] Result<CertificateFacts, Problem> read_certificate(const std::string& certificate);
/// The key is one, and the certificate's.
[[nodiscard]] Result<void, Problem> check_key(const std::string& key, const std::string& certificate);
/// The authority has signed it. Its times are not looked at.
[[nodiscard]] Result<void, Problem> check_issuer(const std::string& certificate, const std::string& authority);

/// The text, readable, with a signature behind it.
[[nodiscard]] Result<std::string, Problem> sign_document(const std::string& text, const KeyAndCertificate& signer);
/// The text of a document that `authority` has signed, with line ends of its own. Times are not looked at.
[[nodiscard]] Result<std::string, Problem> read_signed_document(const std::string& document,
                                                                const std::string& authority);

/// "2026-11-22T14:40:00", UTC.
[[nodiscard]] std::string utc_text(WallTime time);
/// The way back; a zone behind it ("Z", "+01:00") is obeyed. Errors: no such date.
[[nodiscard]] Result<WallTime, Problem> read_utc(const std::string& text);

}  // namespace nacelle::security
