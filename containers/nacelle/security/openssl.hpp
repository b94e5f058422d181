// SPDX-License-Identifier: Apache-2.0
// Owners of OpenSSL's objects. Only the sources of this folder include this file.
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

/// Returns "what: OpenSSL's reason", and empties the thread's queue of OpenSSL errors.
[[nodiscard]] Problem openssl_problem(const std::string& what, ProblemCode code = {});
/// Returns a BIO that reads from `text`, which must outlive it.
[[nodiscard]] Bio bio_of(const std::string& text);
/// Returns the content of a memory BIO.
[[nodiscard]] std::string text_in(BIO& bio);

[[nodiscard]] Result<Certificate, Problem> parse_certificate(const std::string& text);
[[nodiscard]] Result<Key, Problem> parse_key(const std::string& text);
/// Returns a store that trusts `authority` and ignores times.
[[nodiscard]] Result<Store, Problem> store_of(const std::string& authority);

}  // namespace nacelle::security
