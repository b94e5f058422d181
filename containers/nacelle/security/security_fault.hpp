// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/problem.hpp"

namespace nacelle::security {

/// What is wrong with a keystore, an enclave or one of its files.
enum class SecurityFault : std::uint8_t {
  NoKeystoreName,     ///< No keystore is named.
  NotAKeystore,       ///< The folder is not a keystore, or an incomplete one.
  KeystoreExists,     ///< A complete keystore is there already.
  KeystoreDamaged,    ///< The authority's key or its certificate is missing.
  NoSuchEnclave,      ///< The keystore or the policy file has no such enclave; Problem::value is its name.
  DomainTooHigh,      ///< DDS Security ends at kMostSecuredDomain; Problem::value is the domain.
  DomainNotGoverned,  ///< The governance document does not cover the domain, which is Problem::value.
  DomainNotAllowed,   ///< The enclave's permissions do not cover the domain, which is Problem::value.
  NotACertificate,    ///< The text is not a certificate.
  NotAKey,            ///< The text is not a private key that can be read without a pass phrase.
  KeyDiffers,         ///< The key is not the certificate's.
  NotSigned,          ///< The authority did not sign the certificate, or did not sign the document as it is.
  NotADocument,       ///< The text is not a signed document, or lacks elements of permissions or governance.
  OtherSubject,       ///< The permissions are for another certificate; Problem::value is this certificate's subject.
  WrongCommonName,    ///< No certificate can have this common name; Problem::value is the name.
  WrongDate,          ///< The text is not a date; it is Problem::value.
  Expired,            ///< The certificate or the grant is no longer valid.
  NotYetValid,        ///< The certificate or the grant is not valid yet by this machine's clock.
  EndsSoon,           ///< The certificate ends within 30 days (a remark).
  KeyExposed,         ///< Other users of this machine may read or write the private key (a remark).
};
[[nodiscard]] constexpr const char* code_text(SecurityFault fault) {
  switch (fault) {
    case SecurityFault::NoKeystoreName: return "security.no_keystore_name";
    case SecurityFault::NotAKeystore: return "security.not_a_keystore";
    case SecurityFault::KeystoreExists: return "security.keystore_exists";
    case SecurityFault::KeystoreDamaged: return "security.keystore_damaged";
    case SecurityFault::NoSuchEnclave: return "security.no_such_enclave";
    case SecurityFault::DomainTooHigh: return "security.domain_too_high";
    case SecurityFault::DomainNotGoverned: return "security.domain_not_governed";
    case SecurityFault::DomainNotAllowed: return "security.domain_not_allowed";
    case SecurityFault::NotACertificate: return "security.not_a_certificate";
    case SecurityFault::NotAKey: return "security.not_a_key";
    case SecurityFault::KeyDiffers: return "security.key_differs";
    case SecurityFault::NotSigned: return "security.not_signed";
    case SecurityFault::NotADocument: return "security.not_a_document";
    case SecurityFault::OtherSubject: return "security.other_subject";
    case SecurityFault::WrongCommonName: return "security.wrong_common_name";
    case SecurityFault::WrongDate: return "security.wrong_date";
    case SecurityFault::Expired: return "security.expired";
    case SecurityFault::NotYetValid: return "security.not_yet_valid";
    case SecurityFault::EndsSoon: return "security.ends_soon";
    case SecurityFault::KeyExposed: return "security.key_exposed";
  }
  return "";
}

/// What is wrong with a policy file (SROS 2's XML). Problem::where is its line.
enum class PolicyFault : std::uint8_t {
  Malformed,         ///< The file is not XML.
  NotAPolicy,        ///< The file has no <policy><enclaves>.
  UnknownElement,    ///< An unknown element at this place; Problem::value is its name.
  UnknownAttribute,  ///< An unknown attribute at this place; Problem::value is its name.
  MissingAttribute,  ///< The element lacks a required attribute.
  WrongValue,        ///< An attribute or a name cannot have this value, which is Problem::value.
  NestedIncludes,    ///< More than eight files are nested.
};
[[nodiscard]] constexpr const char* code_text(PolicyFault fault) {
  switch (fault) {
    case PolicyFault::Malformed: return "policy.malformed";
    case PolicyFault::NotAPolicy: return "policy.not_a_policy";
    case PolicyFault::UnknownElement: return "policy.unknown_element";
    case PolicyFault::UnknownAttribute: return "policy.unknown_attribute";
    case PolicyFault::MissingAttribute: return "policy.missing_attribute";
    case PolicyFault::WrongValue: return "policy.wrong_value";
    case PolicyFault::NestedIncludes: return "policy.nested_includes";
  }
  return "";
}

/// Returns the problem with another place and another way out. Code and value stay.
[[nodiscard]] inline Problem moved(Problem problem, Place where, std::string way_out) {
  problem.where = std::move(where);
  problem.way_out = std::move(way_out);
  return problem;
}

}  // namespace nacelle::security
