// SPDX-License-Identifier: Apache-2.0
// Owners of OpenSSL's objects. Included by the sources of this folder only.
#pragma once

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::security {

template <auto free>
struct Freer {
  template <typename T>
  void operator()(T* object) const {
    free(object);
  }
};
template <typename T, auto free>
using Handle = std::unique_ptr<T, Freer<free>>;
using Bio = Handle<BIO, BIO_free_all>;
using Certificate = Handle<X509, X509_free>;
using Key = Handle<EVP_PKEY, EVP_PKEY_free>;
using Store = Handle<X509_STORE, X509_STORE_free>;

/// "what: what OpenSSL says of it"; takes the thread's queue of errors along.
[[nodiscard]] Problem openssl_problem(const std::string& what, ProblemCode code = {});
/// Reads from `text`, which must outlive it.
[[nodiscard]] Bio bio_of(const std::string& text);
/// What was written to a BIO in memory.
[[nodiscard]] std::string text_in(BIO& bio);

[[nodiscard]] Result<Certificate, Problem> parse_certificate(const std::string& text);
[[nodiscard]] Result<Key, Problem> parse_key(const std::string& text);
/// Trusts `authority`, at any time.
[[nodiscard]] Result<Store, Problem> store_of(const std::string& authority);

}  // namespace nacelle::security
