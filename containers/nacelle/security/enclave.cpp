// SPDX-License-Identifier: Apache-2.0
#include "security/enclave.hpp"

#include <filesystem>

#include "nacelle/base/names.hpp"
#include "security/certificate.hpp"
#include "security/files.hpp"
#include "security/keystore.hpp"
#include "security/policy.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

constexpr Duration kNearEnd = std::chrono::hours(24) * 30;

namespace fs = std::filesystem;
using Done = Result<void, Problem>;

class Examination {
 public:
  Examination(const transport_dds::SecurityWish& wish, int domain, WallTime now)
      : domain_(domain),
        now_(now),
        // Cyclone reads the files later, and a program may change its folder.
        keystore_(wish.keystore.empty() ? fs::path{} : fs::absolute(wish.keystore).lexically_normal()),
        name_(wish.enclave.empty() ? "/" : wish.enclave),
        folder_(keystore_.empty() || !name_.starts_with('/') ? fs::path{} : folder_of(keystore_, name_)) {}

  Result<Enclave, Problem> run() {
    if (domain_ > kMostSecuredDomain) {
      return err(Problem{"security", "there is none in domain " + std::to_string(domain_),
                         "take one from 0 to " + std::to_string(kMostSecuredDomain), SecurityFault::DomainTooHigh,
                         std::to_string(domain_)});
    }
    if (auto found = find_folder(); !found) return err(found.error());
    if (auto right = check_certificate(); !right) return err(right.error());
    if (auto right = check_permissions(); !right) return err(right.error());
    if (auto right = check_governance(); !right) return err(right.error());
    remark_on_mode();
    enclave_.secured.enclave = name_;
    return std::move(enclave_);
  }

 private:
  [[nodiscard]] std::string making(const char* more = "") const {
    return "`nacelle security create-enclave " + keystore_.string() + " " + name_ + more + "`";
  }

  Done find_folder() const {
    std::error_code unreadable;
    if (keystore_.empty()) {
      return err(Problem{"security", "no keystore is named",
                         "set ROS_SECURITY_KEYSTORE, or network: {security: {keystore: FOLDER}} in the launch file",
                         SecurityFault::NoKeystoreName});
    }
    if (!fs::is_directory(keystore_ / "enclaves", unreadable)) {
      return err(Problem{Place(keystore_.string(), 0), "this is not a keystore: it has no folder enclaves",
                         "make one: `nacelle security create-keystore " + keystore_.string() + "`",
                         SecurityFault::NotAKeystore});
    }
    if (auto valid = validate_namespace(name_); !valid) {
      Problem problem = moved(valid.error(), "security", way_to_name(name_));
      problem.what = "as an enclave: " + problem.what;
      return err(std::move(problem));
    }
    if (fs::is_directory(folder_, unreadable) && (name_ != "/" || fs::exists(folder_ / "cert.pem", unreadable)))
      return {};
    const auto others = list_enclaves(keystore_);
    std::string known = others ? suggestion(name_, others.value()) : "";
    return err(Problem{Place(keystore_.string(), 0), "it has no enclave " + name_,
                       "make it: " + making() + (known.empty() ? "" : "; " + known), SecurityFault::NoSuchEnclave,
                       name_});
  }

  /// The text of one of the enclave's files, whose path is noted.
  Result<std::string, Problem> read(const char* file, std::string& path, const char* more = "") const {
    const fs::path at = folder_ / file;
    path = at.string();
    auto text = read_file(at);
    if (text) return text;
    std::error_code unreadable;
    Problem problem = text.error();
    if (!fs::exists(at, unreadable)) {
      problem.way_out = "make it: " + making(more);
    } else if (fs::is_regular_file(at, unreadable) && fs::file_size(at, unreadable) <= kMostFileBytes) {
      problem.way_out = "let the robot's user read it";
    } else {
      problem.way_out = "bring back the file that was there, or move this away and make it anew: " + making(more);
    }
    return err(std::move(problem));
  }

  static Problem at(const std::string& path, const Problem& problem, const std::string& way_out) {
    return moved(problem, Place(path, 0), way_out);
  }

  Done check_times(const std::string& path, const std::string& what, const Validity& validity,
                   const std::string& way_out) const {
    if (now_ > validity.ends)
      return err(Problem{Place(path, 0), what + " has expired on " + utc_text(validity.ends) + " UTC", way_out,
                         SecurityFault::Expired});
    if (now_ < validity.begins) {
      return err(Problem{Place(path, 0),
                         what + " is valid from " + utc_text(validity.begins) +
                             " UTC on, and this machine's clock says " + utc_text(now_),
                         "set the clock, see `nacelle doctor`", SecurityFault::NotYetValid});
    }
    return {};
  }

  Done check_certificate() {
    transport_dds::SecuredBy& made = enclave_.secured;
    const auto certificate = read("cert.pem", made.files.certificate);
    if (!certificate) return err(certificate.error());
    const auto facts = read_certificate(certificate.value());
    if (!facts) return err(at(made.files.certificate, facts.error(), "make it anew: " + making(" --renew")));
    const Validity validity{facts.value().begins, facts.value().ends};
    if (auto valid =
            check_times(made.files.certificate, "the certificate", validity, "renew it: " + making(" --renew"));
        !valid)
      return valid;
    const auto key = read("key.pem", made.files.private_key);
    if (!key) return err(key.error());
    if (auto fits = check_key(key.value(), certificate.value()); !fits)
      return err(at(made.files.private_key, fits.error(), "make both anew: " + making(" --renew")));
    const auto authority = read("identity_ca.cert.pem", made.files.identity_ca);
    if (!authority) return err(authority.error());
    if (auto issued = check_issuer(certificate.value(), authority.value()); !issued)
      return err(at(made.files.certificate, issued.error(), "make it anew: " + making(" --renew")));
    const auto authority_facts = read_certificate(authority.value());
    if (!authority_facts) return err(at(made.files.identity_ca, authority_facts.error(), ""));
    if (auto valid = check_times(made.files.identity_ca, "the authority's certificate",
                                 {authority_facts.value().begins, authority_facts.value().ends}, "make a new keystore");
        !valid)
      return valid;
    made.subject = facts.value().subject;
    made.ends = utc_text(validity.ends).substr(0, 10);
    if (validity.ends - now_ < kNearEnd) {
      enclave_.remarks.push_back({Place(made.files.certificate, 0), "the certificate ends on " + made.ends,
                                  "renew it: " + making(" --renew"), SecurityFault::EndsSoon});
    }
    return {};
  }

  /// A document that the authority of permissions has signed.
  Result<std::string, Problem> read_document(const char* file, std::string& path, const std::string& way_out) {
    auto authority = read("permissions_ca.cert.pem", enclave_.secured.files.permissions_ca);
    if (!authority) return authority;
    auto document = read(file, path);
    if (!document) return document;
    auto text = read_signed_document(document.value(), authority.value());
    if (!text) return err(at(path, text.error(), way_out));
    return text;
  }

  /// Makes permissions.p7s of permissions.xml again, where that is there. Nothing is lost: a person may have written rules.
  [[nodiscard]] std::string signing_anew() const {
    std::error_code unreadable;
    const bool is_written = fs::exists(folder_ / "permissions.xml", unreadable);
    return "move permissions.p7s away, then " + making() +
           (is_written ? ", which signs permissions.xml" : ": it makes permissions for everything");
  }

  /// Whether permissions.xml, which is signed when permissions.p7s is missing, is this enclave's own.
  [[nodiscard]] bool has_own_rules() const {
    const auto rules = read_file(folder_ / "permissions.xml");
    return rules && find_grant(rules.value(), enclave_.secured.subject, domain_);
  }

  Done check_permissions() {
    std::string& path = enclave_.secured.files.permissions;
    const auto text = read_document("permissions.p7s", path, signing_anew());
    if (!text) return err(text.error());
    const auto found = find_grant(text.value(), enclave_.secured.subject, domain_);
    if (!found) {
      return err(at(path, found.error(),
                    has_own_rules()
                        ? signing_anew()
                        : "bring back the enclave's own; or move permissions.p7s and permissions.xml away, then " +
                              making() + ": it makes permissions for everything"));
    }
    // The plugin compares names more cleverly than texts are compared here, so without a find it has the word.
    if (!found.value()) return {};
    if (auto valid = check_times(path, "the grant", found.value()->validity, "renew it: " + making(" --renew")); !valid)
      return valid;
    if (found.value()->covers_domain) return {};
    return err(Problem{
        Place(path, 0), "it allows nothing in domain " + std::to_string(domain_),
        "add <id>" + std::to_string(domain_) + "</id> to each <domains> of permissions.xml, then " + signing_anew(),
        SecurityFault::DomainNotAllowed, std::to_string(domain_)});
  }

  Done check_governance() {
    std::string& path = enclave_.secured.files.governance;
    const auto text = read_document("governance.p7s", path, "sign it with the permissions' authority");
    if (!text) return err(text.error());
    const auto found = governs(text.value(), domain_);
    if (!found) return err(at(path, found.error(), ""));
    if (found.value()) return {};
    return err(Problem{Place(path, 0), "it does not govern domain " + std::to_string(domain_),
                       way_to_govern(keystore_, domain_), SecurityFault::DomainNotGoverned, std::to_string(domain_)});
  }

  void remark_on_mode() {
    std::error_code unreadable;
    const std::string& key = enclave_.secured.files.private_key;
    const auto mode = fs::status(key, unreadable).permissions();
    constexpr auto kOthers = fs::perms::group_all | fs::perms::others_all;
    if (!unreadable && (mode & kOthers) != fs::perms::none)
      enclave_.remarks.push_back({Place(key, 0), "others on this machine may read or write the private key",
                                  "`chmod 600 " + key + "`", SecurityFault::KeyExposed});
  }

  const int domain_;
  const WallTime now_;
  const fs::path keystore_;
  const std::string name_;
  const fs::path folder_;
  Enclave enclave_;
};

}  // namespace

Result<Enclave, Problem> open_enclave(const transport_dds::SecurityWish& wish, int domain, WallTime now) {
  return Examination{wish, domain, now}.run();
}

}  // namespace nacelle::security
