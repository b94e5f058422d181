// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::security {

// Keys, certificates and signed documents in SROS 2's form, made with OpenSSL. Texts are PEM, documents S/MIME.
// Pure: the functions access no files. Threads: any.
// Errors: a SecurityFault without `where`, because the caller knows the file.
// Source: sros2 (jazzy) _utilities.py; OMG DDS-Security 1.1 sections 9.3.1 and 9.4.1.

/// An elliptic key (P-256) and the certificate of its owner.
struct KeyAndCertificate {
  std::string key, certificate;
};

inline constexpr Duration kValidity = std::chrono::hours(24) * 3650;
inline constexpr std::size_t kMaxCommonNameBytes = 64;  ///< X.509's ub-common-name.

/// Makes a self-signed certificate that can sign others, valid from `now` for kValidity.
[[nodiscard]] Result<KeyAndCertificate, Problem> make_authority(const std::string& common_name, WallTime now);
/// Makes a certificate signed by `authority`, valid from `now` for kValidity.
[[nodiscard]] Result<KeyAndCertificate, Problem> make_certificate(const std::string& common_name,
                                                                  const KeyAndCertificate& authority, WallTime now);

struct CertificateFacts {
  std::string subject;      ///< "CN=/robot"
  std::string common_name;  ///< "/robot"; empty if it has none.
  WallTime begins, ends;    ///< Whole seconds.
};
[[nodiscard]] Result<CertificateFacts, Problem> read_certificate(const std::string& certificate);
/// Checks that `key` is a private key and belongs to the certificate.
[[nodiscard]] Result<void, Problem> check_key(const std::string& key, const std::string& certificate);
/// Checks that the authority has signed the certificate. Ignores its times.
[[nodiscard]] Result<void, Problem> check_issuer(const std::string& certificate, const std::string& authority);

/// Returns the text in readable form, followed by a signature.
[[nodiscard]] Result<std::string, Problem> sign_document(const std::string& text, const KeyAndCertificate& signer);
/// Returns the text of a document that `authority` has signed, with line ends of '\n'. Ignores times.
[[nodiscard]] Result<std::string, Problem> read_signed_document(const std::string& document,
                                                                const std::string& authority);

/// Returns "2026-11-22T14:40:00", UTC.
[[nodiscard]] std::string utc_text(WallTime time);
/// Parses such a text. A following numeric zone ("+01:00") is applied; without one, or with "Z", the time is UTC.
/// Errors: no such date.
[[nodiscard]] Result<WallTime, Problem> read_utc(const std::string& text);

}  // namespace nacelle::security
