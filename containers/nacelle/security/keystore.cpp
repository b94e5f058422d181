// SPDX-License-Identifier: Apache-2.0
#include "security/keystore.hpp"

#include <algorithm>
#include <array>
#include <regex>

#include "nacelle/base/file_fault.hpp"
#include "nacelle/base/names.hpp"
#include "security/certificate.hpp"
#include "security/files.hpp"
#include "security/policy.hpp"
#include "security/policy_includes.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

namespace fs = std::filesystem;
using Done = Result<void, Problem>;

constexpr const char* kCommonName = "sros2CA";
constexpr std::array<const char*, 2> kAuthorities{"identity_ca", "permissions_ca"};

bool is_there(const fs::path& path) {
  std::error_code unreadable;
  return fs::exists(path, unreadable);
}

/// Writes files and records each change. Does nothing after the first problem.
class Maker {
 public:
  void folder(const fs::path& path, Secrecy secrecy = Secrecy::Public) {
    if (!problem_) note(make_folder(path, secrecy));
  }
  void file(const fs::path& path, const std::string& text, Secrecy secrecy = Secrecy::Public) {
    if (problem_) return;
    const auto kind = is_there(path) ? Change::Kind::Replaced : Change::Kind::Made;
    note(write_file(path, text, secrecy));
    if (!problem_) changes_.push_back({kind, path.string()});
  }
  /// Keeps what leads to the same file, or is one of its own.
  void link(const fs::path& path, const fs::path& target) {
    if (problem_ || keep(path)) return;
    note(make_link(path, target.lexically_relative(path.parent_path())));
    if (!problem_) changes_.push_back({Change::Kind::Made, path.string()});
  }
  bool keep(const fs::path& path) {
    if (problem_ || !is_there(path)) return false;
    changes_.push_back({Change::Kind::Kept, path.string()});
    return true;
  }
  /// The value, or nothing from now on.
  template <typename T>
  T take(Result<T, Problem> result, const fs::path& where) {
    if (result) return std::move(result).value();
    if (!problem_) {
      problem_ = result.error();
      if (problem_->where.empty()) problem_->where = Place(where.string(), 0);
    }
    return T{};
  }
  std::string text_of(const fs::path& path) { return take(read_file(path), path); }
  [[nodiscard]] bool failed() const { return problem_.has_value(); }
  [[nodiscard]] Result<Changes, Problem> result() && {
    if (problem_) return err(std::move(*problem_));
    return std::move(changes_);
  }

 private:
  void note(const Done& done) {
    if (!done && !problem_) problem_ = done.error();
  }
  Changes changes_;
  std::optional<Problem> problem_;
};

KeyAndCertificate authority_of(Maker& maker, const fs::path& keystore, const std::string& name) {
  const fs::path key = keystore / "private" / (name + ".key.pem");
  const fs::path certificate = keystore / "public" / (name + ".cert.pem");
  KeyAndCertificate found;
  found.certificate = maker.text_of(certificate);
  found.key = maker.text_of(key);
  if (!maker.failed()) {
    if (const auto fits = check_key(found.key, found.certificate); !fits)
      maker.take(Result<int, Problem>{err(fits.error())}, key);
  }
  return found;
}

void sign(Maker& maker, const fs::path& keystore, const fs::path& document, const std::string& text) {
  const KeyAndCertificate authority = authority_of(maker, keystore, "permissions_ca");
  if (maker.failed()) return;
  maker.file(document, maker.take(sign_document(text, authority), document));
}

Done make_new_authority(Maker& maker, const fs::path& keystore, WallTime now) {
  const fs::path certificate = keystore / "public/ca.cert.pem", key = keystore / "private/ca.key.pem";
  if (is_there(certificate) != is_there(key)) {
    return err(Problem{Place((is_there(key) ? certificate : key).string(), 0),
                       "it is missing, and the authority's other half is there",
                       "restore it, or make a keystore in another folder: with a new authority, existing certificates "
                       "would no longer be accepted",
                       SecurityFault::KeystoreDamaged});
  }
  if (maker.keep(certificate)) {
    maker.keep(key);
    return {};
  }
  const KeyAndCertificate made = maker.take(make_authority(kCommonName, now), keystore);
  maker.file(key, made.key, Secrecy::Private);
  maker.file(certificate, made.certificate);
  return {};
}

bool is_complete(const fs::path& keystore) {
  for (const std::string name : kAuthorities) {
    if (!is_there(keystore / "public" / (name + ".cert.pem")) || !is_there(keystore / "private" / (name + ".key.pem")))
      return false;
  }
  return is_there(keystore / "enclaves/governance.p7s");
}

Done is_named(const fs::path& keystore) {
  if (!keystore.empty()) return {};
  return err(
      Problem{"keystore", "the name is empty", "name the keystore's folder: keys", SecurityFault::NoKeystoreName});
}

Done examine(const EnclaveWish& wish) {
  if (auto valid = is_named(wish.keystore); !valid) return valid;
  if (auto valid = validate_namespace(wish.enclave); !valid)
    return err(moved(valid.error(), "enclave", way_to_name(wish.enclave)));
  if (is_complete(wish.keystore)) return {};
  return err(Problem{Place(wish.keystore.string(), 0), "this is not a complete keystore",
                     "make one: `nacelle security create-keystore " + wish.keystore.string() + "`",
                     SecurityFault::NotAKeystore});
}

/// An enclave in a domain that nothing governs could never take part.
Done check_governed(const EnclaveWish& wish) {
  const fs::path document = wish.keystore / "enclaves/governance.p7s";
  const auto authority = read_file(wish.keystore / "public/permissions_ca.cert.pem");
  if (!authority) return err(authority.error());
  const auto is_signed = read_file(document);
  if (!is_signed) return err(is_signed.error());
  const auto text = read_signed_document(is_signed.value(), authority.value());
  if (!text) return err(moved(text.error(), Place(document.string(), 0), "sign it with the permissions' authority"));
  const auto found = governs(text.value(), wish.domain);
  if (!found) return err(moved(found.error(), Place(document.string(), 0), ""));
  if (found.value()) return {};
  return err(Problem{Place(document.string(), 0), "it does not govern domain " + std::to_string(wish.domain),
                     way_to_govern(wish.keystore, wish.domain), SecurityFault::DomainNotGoverned,
                     std::to_string(wish.domain)});
}

/// Permissions as they are, but for when they hold.
std::string with_validity(const std::string& permissions, const CertificateFacts& certificate) {
  static const std::regex begin{"<not_before>[^<]*</not_before>"}, end{"<not_after>[^<]*</not_after>"};
  const std::string text =
      std::regex_replace(permissions, begin, "<not_before>" + utc_text(certificate.begins) + "</not_before>");
  return std::regex_replace(text, end, "<not_after>" + utc_text(certificate.ends) + "</not_after>");
}

}  // namespace

const char* to_text(Change::Kind kind) {
  constexpr std::array<const char*, 3> kWords{"made", "replaced", "kept"};
  return kWords[static_cast<std::size_t>(kind)];
}

std::string way_to_govern(const fs::path& keystore, int domain) {
  return "add <id>" + std::to_string(domain) + "</id> to the <domains> of " +
         (keystore / "enclaves/governance.xml").string() + ", move governance.p7s beside it away, then " +
         "`nacelle security create-keystore " + keystore.string() + "`, which signs it";
}

std::string way_to_name(const std::string& enclave) {
  const std::string meant = "/" + enclave;
  return validate_namespace(meant) ? "did you mean '" + meant + "'?" : "write it as '/robot'";
}

fs::path folder_of(const fs::path& keystore, const std::string& enclave) {
  return enclave == "/" ? keystore / "enclaves" : keystore / "enclaves" / enclave.substr(1);
}

Result<Changes, Problem> create_keystore(const fs::path& keystore, int domain, WallTime now) {
  if (auto valid = is_named(keystore); !valid) return err(valid.error());
  if (is_complete(keystore)) {
    return err(Problem{Place(keystore.string(), 0), "there is a keystore already",
                       "add enclaves to it: `nacelle security create-enclave " + keystore.string() + " /robot`",
                       SecurityFault::KeystoreExists});
  }
  Maker maker;
  maker.folder(keystore / "public");
  maker.folder(keystore / "private", Secrecy::Private);
  maker.folder(keystore / "enclaves");
  const bool has_own = std::all_of(kAuthorities.begin(), kAuthorities.end(), [&](const std::string& name) {
    return is_there(keystore / "public" / (name + ".cert.pem")) && is_there(keystore / "private" / (name + ".key.pem"));
  });
  if (!has_own) {
    if (auto made = make_new_authority(maker, keystore, now); !made) return err(made.error());
  }
  for (const std::string name : kAuthorities) {
    maker.link(keystore / "public" / (name + ".cert.pem"), keystore / "public/ca.cert.pem");
    maker.link(keystore / "private" / (name + ".key.pem"), keystore / "private/ca.key.pem");
  }
  const fs::path governance = keystore / "enclaves/governance.xml", document = keystore / "enclaves/governance.p7s";
  if (!maker.keep(governance)) maker.file(governance, governance_xml(domain));
  if (!maker.failed() && !maker.keep(document)) sign(maker, keystore, document, maker.text_of(governance));
  return std::move(maker).result();
}

Result<Changes, Problem> create_enclave(const EnclaveWish& wish, WallTime now) {
  if (auto valid = examine(wish); !valid) return err(valid.error());
  const fs::path folder = folder_of(wish.keystore, wish.enclave);
  const fs::path key = folder / "key.pem", certificate = folder / "cert.pem";
  const fs::path permissions = folder / "permissions.xml", document = folder / "permissions.p7s";
  const bool had_permissions = is_there(permissions);
  if (!had_permissions) {
    if (auto governed = check_governed(wish); !governed) return err(governed.error());
  }
  Maker maker;
  maker.folder(folder);
  for (const std::string name : kAuthorities)
    maker.link(folder / (name + ".cert.pem"), wish.keystore / "public" / (name + ".cert.pem"));
  if (wish.enclave != "/") maker.link(folder / "governance.p7s", wish.keystore / "enclaves/governance.p7s");
  if (maker.failed()) return std::move(maker).result();

  const bool has_both = is_there(key) && is_there(certificate);
  bool is_new = false;
  if (has_both && !wish.renew) {
    maker.keep(key);
    maker.keep(certificate);
  } else {
    const KeyAndCertificate authority = authority_of(maker, wish.keystore, "identity_ca");
    if (maker.failed()) return std::move(maker).result();
    const KeyAndCertificate made = maker.take(make_certificate(wish.enclave, authority, now), certificate);
    maker.file(key, made.key, Secrecy::Private);
    maker.file(certificate, made.certificate);
    is_new = true;
  }
  const CertificateFacts facts = maker.take(read_certificate(maker.text_of(certificate)), certificate);
  if (maker.failed()) return std::move(maker).result();
  if (!had_permissions) {
    maker.file(permissions, permissions_xml(everything(), wish.enclave, {facts.begins, facts.ends}, wish.domain));
  } else if (is_new) {
    maker.file(permissions, with_validity(maker.text_of(permissions), facts));
  } else {
    maker.keep(permissions);
  }
  const bool is_signed = had_permissions && !is_new && maker.keep(document);
  if (!maker.failed() && !is_signed) sign(maker, wish.keystore, document, maker.text_of(permissions));
  return std::move(maker).result();
}

Result<Changes, Problem> create_permission(const EnclaveWish& wish, const fs::path& policy_file) {
  if (auto valid = examine(wish); !valid) return err(valid.error());
  if (auto governed = check_governed(wish); !governed) return err(governed.error());
  const fs::path folder = folder_of(wish.keystore, wish.enclave), certificate = folder / "cert.pem";
  if (!is_there(certificate)) {
    return err(Problem{
        Place(certificate.string(), 0), "it is missing",
        "make the enclave first: `nacelle security create-enclave " + wish.keystore.string() + " " + wish.enclave + "`",
        SecurityFault::NoSuchEnclave, wish.enclave});
  }
  Maker maker;
  const CertificateFacts facts = maker.take(read_certificate(maker.text_of(certificate)), certificate);
  const std::string xml = maker.take(read_with_includes(policy_file), policy_file);
  if (maker.failed()) return std::move(maker).result();
  const auto policy = read_policy(xml, policy_file.string(), wish.enclave);
  if (!policy) return err(policy.error());
  const std::string text = permissions_xml(policy.value(), wish.enclave, {facts.begins, facts.ends}, wish.domain);
  maker.file(folder / "permissions.xml", text);
  sign(maker, wish.keystore, folder / "permissions.p7s", text);
  return std::move(maker).result();
}

Result<std::vector<std::string>, Problem> list_enclaves(const fs::path& keystore) {
  if (auto valid = is_named(keystore); !valid) return err(valid.error());
  if (!is_there(keystore / "enclaves")) {
    return err(Problem{Place(keystore.string(), 0), "this is not a keystore: it has no folder enclaves",
                       "make one: `nacelle security create-keystore " + keystore.string() + "`",
                       SecurityFault::NotAKeystore});
  }
  std::vector<std::string> found;
  std::error_code failed;
  const auto options = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator at(keystore / "enclaves", options, failed), end; !failed && at != end;
       at.increment(failed)) {
    if (at->path().filename() != "key.pem") continue;
    const std::string below = at->path().parent_path().lexically_relative(keystore / "enclaves").string();
    found.push_back(below == "." ? "/" : "/" + below);
  }
  if (failed)
    return err(Problem{Place(keystore.string(), 0), "cannot be read: " + failed.message(), "",
                       file_fault_of(failed.value(), FileFault::Unreadable)});
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace nacelle::security
