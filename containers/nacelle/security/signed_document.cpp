// SPDX-License-Identifier: Apache-2.0
#include <openssl/err.h>
#include <openssl/pkcs7.h>

#include <algorithm>

#include "security/certificate.hpp"
#include "security/openssl.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

using Signature = Handle<PKCS7, PKCS7_free>;

// The document's own text stays readable, and a mail program would show it.
constexpr int kDetachedText = PKCS7_DETACHED | PKCS7_TEXT | PKCS7_STREAM | PKCS7_PARTIAL;

}  // namespace

Result<std::string, Problem> sign_document(const std::string& text, const KeyAndCertificate& signer) {
  const auto certificate = parse_certificate(signer.certificate);
  if (!certificate) return err(certificate.error());
  const auto key = parse_key(signer.key);
  if (!key) return err(key.error());
  const Bio in = bio_of(text), out{BIO_new(BIO_s_mem())};
  const Signature made{PKCS7_sign(nullptr, nullptr, nullptr, in.get(), kDetachedText)};
  const bool complete = in && out && made &&
                        PKCS7_sign_add_signer(made.get(), certificate.value().get(), key.value().get(), EVP_sha256(),
                                              kDetachedText) != nullptr &&
                        SMIME_write_PKCS7(out.get(), made.get(), in.get(), kDetachedText) == 1;
  if (!complete) return err(openssl_problem("the document could not be signed"));
  return text_in(*out);
}

Result<std::string, Problem> read_signed_document(const std::string& document, const std::string& authority) {
  const auto store = store_of(authority);
  if (!store) return err(store.error());
  ERR_clear_error();
  const Bio in = bio_of(document), out{BIO_new(BIO_s_mem())};
  BIO* content = nullptr;
  const Signature found{SMIME_read_PKCS7(in.get(), &content)};
  const Bio owned{content};
  if (!found || !owned) return err(openssl_problem("this is not a signed document", SecurityFault::NotADocument));
  if (PKCS7_verify(found.get(), nullptr, store.value().get(), owned.get(), out.get(), PKCS7_TEXT) != 1)
    return err(openssl_problem("the authority did not sign it as it is", SecurityFault::NotSigned));
  std::string text = text_in(*out);
  text.erase(std::remove(text.begin(), text.end(), '\r'), text.end());
  return text;
}

}  // namespace nacelle::security
