// SPDX-License-Identifier: Apache-2.0
#include "security/certificate.hpp"

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <ctime>

#include "security/openssl.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

constexpr int kSerialBits = 159;  // positive, and within X.509's 20 bytes

std::time_t seconds_of(WallTime time) {
  return static_cast<std::time_t>(std::chrono::duration_cast<std::chrono::seconds>(time.since_origin).count());
}

bool set_random_serial(X509& certificate) {
  const Handle<BIGNUM, BN_free> number{BN_new()};
  return number && BN_rand(number.get(), kSerialBits, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY) == 1 &&
         BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(&certificate)) != nullptr;
}

bool set_constraints(X509& certificate, bool is_authority) {
  const char* const words = is_authority ? "critical,CA:TRUE,pathlen:1" : "CA:FALSE";
  const Handle<X509_EXTENSION, X509_EXTENSION_free> made{
      X509V3_EXT_conf_nid(nullptr, nullptr, NID_basic_constraints, words)};
  return made && X509_add_ext(&certificate, made.get(), -1) == 1;
}

bool set_name(X509& certificate, const std::string& common_name) {
  X509_NAME* const name = X509_get_subject_name(&certificate);
  return X509_NAME_add_entry_by_NID(name, NID_commonName, MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>(common_name.data()),
                                    static_cast<int>(common_name.size()), -1, 0) == 1;
}

/// `issuer` and `issuer_key` null: signed by itself, and an authority.
Result<KeyAndCertificate, Problem> make(const std::string& common_name, X509* issuer, EVP_PKEY* issuer_key,
                                        WallTime now) {
  if (common_name.empty() || common_name.size() > kMaxCommonNameBytes) {
    return err(Problem{"",
                       "the name '" + common_name + "' has " + std::to_string(common_name.size()) +
                           " bytes; a certificate's has 1 to " + std::to_string(kMaxCommonNameBytes),
                       "", SecurityFault::WrongCommonName, common_name});
  }
  const Key key{EVP_EC_gen("P-256")};
  const Certificate made{X509_new()};
  if (!key || !made) return err(openssl_problem("no key could be made"));
  const std::time_t begin = seconds_of(now);
  const bool complete =
      X509_set_version(made.get(), X509_VERSION_3) == 1 && set_random_serial(*made) && set_name(*made, common_name) &&
      X509_set_issuer_name(made.get(), X509_get_subject_name(issuer != nullptr ? issuer : made.get())) == 1 &&
      ASN1_TIME_set(X509_getm_notBefore(made.get()), begin) != nullptr &&
      ASN1_TIME_set(X509_getm_notAfter(made.get()), seconds_of(now + kValidity)) != nullptr &&
      X509_set_pubkey(made.get(), key.get()) == 1 && set_constraints(*made, issuer == nullptr) &&
      X509_sign(made.get(), issuer_key != nullptr ? issuer_key : key.get(), EVP_sha256()) > 0;
  if (!complete) return err(openssl_problem("no certificate could be made"));
  const Bio key_text{BIO_new(BIO_s_mem())}, certificate_text{BIO_new(BIO_s_mem())};
  if (!key_text || !certificate_text ||
      PEM_write_bio_PKCS8PrivateKey(key_text.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) != 1 ||
      PEM_write_bio_X509(certificate_text.get(), made.get()) != 1)
    return err(openssl_problem("the key could not be written"));
  return KeyAndCertificate{text_in(*key_text), text_in(*certificate_text)};
}

WallTime wall_time_of(const ASN1_TIME* time) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return {};
  return {std::chrono::seconds(::timegm(&parts))};
}

}  // namespace

Problem openssl_problem(const std::string& what, ProblemCode code) {
  std::string why;
  while (const unsigned long number = ERR_get_error()) {
    const char* const reason = ERR_reason_error_string(number);
    if (reason != nullptr && why.find(reason) == std::string::npos)
      why += (why.empty() ? ": " : ", ") + std::string(reason);
  }
  return {"", what + why, "", std::move(code)};
}

std::string text_in(BIO& bio) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(&bio, &bytes);
  return size > 0 ? std::string(bytes, static_cast<std::size_t>(size)) : std::string{};
}

Bio bio_of(const std::string& text) { return Bio{BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))}; }

Result<Certificate, Problem> parse_certificate(const std::string& text) {
  ERR_clear_error();
  Certificate found{PEM_read_bio_X509(bio_of(text).get(), nullptr, nullptr, nullptr)};
  if (!found) return err(openssl_problem("this is not a certificate", SecurityFault::NotACertificate));
  return found;
}

Result<Key, Problem> parse_key(const std::string& text) {
  ERR_clear_error();
  // A robot has no terminal at which a pass phrase could be typed.
  const auto no_phrase = [](char*, int, int, void*) { return 0; };
  Key found{PEM_read_bio_PrivateKey(bio_of(text).get(), nullptr, no_phrase, nullptr)};
  if (!found)
    return err(
        openssl_problem("this is not a private key that can be read without a pass phrase", SecurityFault::NotAKey));
  return found;
}

Result<KeyAndCertificate, Problem> make_authority(const std::string& common_name, WallTime now) {
  ERR_clear_error();
  return make(common_name, nullptr, nullptr, now);
}

Result<KeyAndCertificate, Problem> make_certificate(const std::string& common_name, const KeyAndCertificate& authority,
                                                    WallTime now) {
  const auto issuer = parse_certificate(authority.certificate);
  if (!issuer) return err(issuer.error());
  const auto key = parse_key(authority.key);
  if (!key) return err(key.error());
  return make(common_name, issuer.value().get(), key.value().get(), now);
}

Result<CertificateFacts, Problem> read_certificate(const std::string& certificate) {
  const auto found = parse_certificate(certificate);
  if (!found) return err(found.error());
  X509& x509 = *found.value();
  CertificateFacts facts;
  const Bio line{BIO_new(BIO_s_mem())};
  X509_NAME_print_ex(line.get(), X509_get_subject_name(&x509), 0, XN_FLAG_RFC2253);
  facts.subject = text_in(*line);
  const X509_NAME* const name = X509_get_subject_name(&x509);
  if (const int at = X509_NAME_get_index_by_NID(name, NID_commonName, -1); at >= 0) {
    unsigned char* bytes = nullptr;
    const int size = ASN1_STRING_to_UTF8(&bytes, X509_NAME_ENTRY_get_data(X509_NAME_get_entry(name, at)));
    if (size > 0) facts.common_name.assign(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
    OPENSSL_free(bytes);
  }
  facts.begins = wall_time_of(X509_get0_notBefore(&x509));
  facts.ends = wall_time_of(X509_get0_notAfter(&x509));
  return facts;
}

Result<void, Problem> check_key(const std::string& key, const std::string& certificate) {
  const auto owned = parse_certificate(certificate);
  if (!owned) return err(owned.error());
  const auto found = parse_key(key);
  if (!found) return err(found.error());
  if (X509_check_private_key(owned.value().get(), found.value().get()) == 1) return {};
  ERR_clear_error();
  return err(Problem{"", "the key is not the certificate's", "", SecurityFault::KeyDiffers});
}

Result<void, Problem> check_issuer(const std::string& certificate, const std::string& authority) {
  const auto signed_one = parse_certificate(certificate);
  if (!signed_one) return err(signed_one.error());
  const auto store = store_of(authority);
  if (!store) return err(store.error());
  const Handle<X509_STORE_CTX, X509_STORE_CTX_free> context{X509_STORE_CTX_new()};
  if (!context || X509_STORE_CTX_init(context.get(), store.value().get(), signed_one.value().get(), nullptr) != 1)
    return err(openssl_problem("the certificate could not be examined"));
  if (X509_verify_cert(context.get()) == 1) return {};
  ERR_clear_error();
  return err(Problem{"",
                     std::string("the authority did not sign it: ") +
                         X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get())),
                     "", SecurityFault::NotSigned});
}

Result<Store, Problem> store_of(const std::string& authority) {
  const auto trusted = parse_certificate(authority);
  if (!trusted) return err(trusted.error());
  Store store{X509_STORE_new()};
  if (!store || X509_STORE_add_cert(store.get(), trusted.value().get()) != 1 ||
      X509_STORE_set_flags(store.get(), X509_V_FLAG_NO_CHECK_TIME) != 1)
    return err(openssl_problem("the authority's certificate could not be taken"));
  return store;
}

std::string utc_text(WallTime time) {
  const std::time_t seconds = seconds_of(time);
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts)};
}

Result<WallTime, Problem> read_utc(const std::string& text) {
  std::tm parts{};
  const char* rest = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (rest == nullptr)
    return err(Problem{"", "'" + text.substr(0, 60) + "' is not a date", "write 2026-11-22T14:40:00",
                       SecurityFault::WrongDate, text});
  std::time_t seconds = ::timegm(&parts);
  if (*rest == '+' || *rest == '-') {
    int hours = 0, minutes = 0;
    if (std::sscanf(rest + 1, "%2d:%2d", &hours, &minutes) == 2)
      seconds -= (*rest == '+' ? 1 : -1) * (hours * 3600L + minutes * 60L);
  }
  return WallTime{std::chrono::seconds(seconds)};
}

}  // namespace nacelle::security
