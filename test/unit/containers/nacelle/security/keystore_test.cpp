// SPDX-License-Identifier: Apache-2.0
#include "security/keystore.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <regex>

#include "../control/temporary_folder.hpp"
#include "nacelle/base/name_fault.hpp"
#include "security/certificate.hpp"
#include "security/enclave.hpp"
#include "security/files.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const WallTime kNow{std::chrono::seconds(1'795'348'800)};  // 2026-11-22T12:00:00

std::string text_at(const fs::path& path) { return read_file(path).value_or("unreadable"); }
unsigned mode_of(const fs::path& path) {
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 ? found.st_mode & 0777U : 0;
}
std::size_t count(const Changes& changes, Change::Kind kind) {
  return static_cast<std::size_t>(
      std::count_if(changes.begin(), changes.end(), [kind](const Change& one) { return one.kind == kind; }));
}

class Keystore : public ::testing::Test {
 public:
  void SetUp() override {
    const auto made = create_keystore(keystore, 0, kNow);
    ASSERT_TRUE(made) << made.error().text();
  }
  Changes make(const std::string& name, bool renew = false, WallTime now = kNow) {
    auto made = create_enclave({keystore, name, 0, renew}, now);
    EXPECT_TRUE(made) << made.error().text();
    return made.value_or({});
  }
  /// The problem of opening an enclave, without the test's folder.
  Problem problem(const std::string& name, WallTime now = kNow, int domain = 0) const {
    const auto opened = open_enclave({true, true, keystore.string(), name}, domain, now);
    if (opened) return {"none", "", ""};
    Problem found = opened.error();
    for (std::string* text : {&found.where.file, &found.what, &found.way_out}) *text = below(*text);
    return found;
  }
  std::string refusal(const std::string& name, WallTime now = kNow, int domain = 0) const {
    return briefly(problem(name, now, domain));
  }
  /// "security.expired cert.pem": the code, and the last part of the place.
  static std::string briefly(const Problem& problem) {
    return problem.code.text() + " " + fs::path(problem.where.text()).filename().string();
  }
  std::string below(std::string text) const {
    for (auto at = text.find(folder.string()); at != text.npos; at = text.find(folder.string()))
      text.erase(at, folder.string().size() + 1);
    return text;
  }

  static void add_domain(const fs::path& document, int domain) {
    const std::string id = "<id>" + std::to_string(domain) + "</id></domains>";
    const std::string text = std::regex_replace(text_at(document), std::regex{"</domains>"}, id);
    ASSERT_TRUE(write_file(document, text, Secrecy::Public));
  }

  TemporaryFolder temporary;
  const fs::path folder = temporary.path();
  const fs::path keystore = folder / "keys";
};

TEST_F(Keystore, has_the_layout_of_sros2) {
  make("/arm/left");
  for (const char* const file :
       {"public/ca.cert.pem", "public/identity_ca.cert.pem", "public/permissions_ca.cert.pem", "private/ca.key.pem",
        "private/identity_ca.key.pem", "private/permissions_ca.key.pem", "enclaves/governance.xml",
        "enclaves/governance.p7s", "enclaves/arm/left/cert.pem", "enclaves/arm/left/key.pem",
        "enclaves/arm/left/permissions.xml", "enclaves/arm/left/permissions.p7s", "enclaves/arm/left/governance.p7s",
        "enclaves/arm/left/identity_ca.cert.pem", "enclaves/arm/left/permissions_ca.cert.pem"}) {
    EXPECT_TRUE(fs::is_regular_file(keystore / file)) << file;
  }
  EXPECT_EQ(fs::read_symlink(keystore / "public/identity_ca.cert.pem"), "ca.cert.pem");
  EXPECT_EQ(fs::read_symlink(keystore / "private/permissions_ca.key.pem"), "ca.key.pem");
  EXPECT_EQ(fs::read_symlink(keystore / "enclaves/arm/left/identity_ca.cert.pem"),
            "../../../public/identity_ca.cert.pem");
  EXPECT_EQ(fs::read_symlink(keystore / "enclaves/arm/left/governance.p7s"), "../../governance.p7s");
  EXPECT_EQ(read_certificate(text_at(keystore / "public/ca.cert.pem")).value_or({}).subject, "CN=sros2CA");
}

TEST_F(Keystore, reads_no_more_of_a_file_than_may_be_in_it) {
  const fs::path huge = folder / "huge";
  ASSERT_TRUE(write_file(huge, "x", Secrecy::Public));
  fs::resize_file(huge, std::uintmax_t{3} << 30U);  // sparse
  EXPECT_EQ(briefly(read_file(huge).error()), "file.too_large huge");
  fs::resize_file(huge, kMostFileBytes);
  EXPECT_EQ(text_at(huge).size(), kMostFileBytes);
}

TEST_F(Keystore, keeps_keys_from_others) {
  make("/robot");
  EXPECT_EQ(mode_of(keystore / "private"), 0700U);
  EXPECT_EQ(mode_of(keystore / "private/ca.key.pem"), 0600U);
  EXPECT_EQ(mode_of(keystore / "enclaves/robot/key.pem"), 0600U);
  ::chmod((keystore / "enclaves/robot/key.pem").c_str(), 0644);
  const auto opened = open_enclave({true, true, keystore.string(), "/robot"}, 0, kNow);
  ASSERT_TRUE(opened) << opened.error().text();
  ASSERT_EQ(opened.value().remarks.size(), 1U);
  EXPECT_EQ(briefly(opened.value().remarks[0]), "security.key_exposed key.pem");
}

TEST_F(Keystore, lists_its_enclaves_the_root_one_included) {
  make("/robot");
  make("/");
  make("/arm/left");
  EXPECT_THAT(list_enclaves(keystore).value_or({}), ElementsAre("/", "/arm/left", "/robot"));
  EXPECT_EQ(refusal("/"), " none");
  EXPECT_EQ(list_enclaves(folder).error().code, SecurityFault::NotAKeystore);
}

TEST_F(Keystore, opens_what_it_has_made) {
  make("/robot");
  const auto opened = open_enclave({true, true, keystore.string(), "/robot"}, 0, kNow);
  ASSERT_TRUE(opened) << opened.error().text();
  const transport_dds::SecuredBy& secured = opened.value().secured;
  EXPECT_EQ(secured.enclave, "/robot");
  EXPECT_EQ(secured.subject, "CN=/robot");
  EXPECT_EQ(secured.ends, "2036-11-19");
  EXPECT_EQ(secured.files.certificate, (keystore / "enclaves/robot/cert.pem").string());
  EXPECT_TRUE(opened.value().remarks.empty());
}

TEST_F(Keystore, tells_of_a_certificate_that_ends_soon) {
  make("/robot");
  const auto remarks_after = [&](int days) {
    const auto opened =
        open_enclave({true, true, keystore.string(), "/robot"}, 0, kNow + std::chrono::hours(24 * days));
    EXPECT_TRUE(opened) << opened.error().text();
    return opened ? opened.value().remarks : std::vector<Problem>{};
  };
  EXPECT_TRUE(remarks_after(3600).empty());
  ASSERT_EQ(remarks_after(3640).size(), 1U);
  EXPECT_EQ(briefly(remarks_after(3640)[0]), "security.ends_soon cert.pem");
  EXPECT_THAT(remarks_after(3640)[0].text(), HasSubstr("cert.pem: the certificate ends on 2036-11-19; renew it: "));
}

TEST_F(Keystore, is_never_made_over_another_one) {
  const std::string key = text_at(keystore / "private/ca.key.pem");
  EXPECT_EQ(create_keystore(keystore, 0, kNow).error().code, SecurityFault::KeystoreExists);
  fs::remove(keystore / "enclaves/governance.p7s");
  const auto completed = create_keystore(keystore, 0, kNow);
  ASSERT_TRUE(completed) << completed.error().text();
  EXPECT_EQ(count(completed.value(), Change::Kind::Made), 1U) << "the missing file";
  EXPECT_EQ(count(completed.value(), Change::Kind::Replaced), 0U);
  EXPECT_EQ(text_at(keystore / "private/ca.key.pem"), key);
  fs::remove(keystore / "private/ca.key.pem");
  EXPECT_EQ(briefly(create_keystore(keystore, 0, kNow).error()), "security.keystore_damaged ca.key.pem");
}

TEST_F(Keystore, keeps_an_enclaves_key_and_permissions_until_it_is_to_renew_them) {
  make("/robot");
  const std::string key = text_at(keystore / "enclaves/robot/key.pem");
  const Changes again = make("/robot");
  EXPECT_EQ(count(again, Change::Kind::Kept), again.size());
  EXPECT_EQ(text_at(keystore / "enclaves/robot/key.pem"), key);

  const WallTime later = kNow + std::chrono::hours(24 * 3651);
  EXPECT_EQ(refusal("/robot", later), "security.expired cert.pem");
  const Changes renewed = make("/robot", true, later);
  EXPECT_EQ(count(renewed, Change::Kind::Replaced), 4U) << "key, certificate, permissions twice";
  EXPECT_EQ(refusal("/robot", later), "security.expired identity_ca.cert.pem");
  EXPECT_EQ(read_certificate(text_at(keystore / "enclaves/robot/cert.pem")).value_or({}).begins, later);
  EXPECT_THAT(text_at(keystore / "enclaves/robot/permissions.xml"), HasSubstr("<not_before>2036-11-20T12:00:00<"));
}

TEST_F(Keystore, takes_permissions_from_a_policy_file) {
  make("/robot");
  const fs::path policy = folder / "policy.xml";
  const auto written = write_file(
      policy,
      "<policy version=\"0.2.0\"><enclaves><enclave path=\"/robot\"><profiles><profile ns=\"/\" node=\"lidar\">"
      "<topics publish=\"ALLOW\"><topic>scan</topic></topics></profile></profiles></enclave></enclaves></policy>",
      Secrecy::Public);
  ASSERT_TRUE(written);
  const auto changed = create_permission({keystore, "/robot"}, policy);
  ASSERT_TRUE(changed) << changed.error().text();
  EXPECT_EQ(count(changed.value(), Change::Kind::Replaced), 2U);
  const std::string xml = text_at(keystore / "enclaves/robot/permissions.xml");
  EXPECT_THAT(xml, HasSubstr("<topic>rt/scan</topic>"));
  EXPECT_THAT(xml, ::testing::Not(HasSubstr("rt/*")));
  EXPECT_EQ(refusal("/robot"), " none");
  const Problem unknown = create_permission({keystore, "/laptop"}, policy).error();
  EXPECT_EQ(unknown.code, SecurityFault::NoSuchEnclave);
  EXPECT_EQ(unknown.value, "/laptop");
}

TEST_F(Keystore, refuses_an_enclave_that_cannot_be_used_with_code_file_and_value) {
  make("/robot");
  EXPECT_EQ(problem("/robto").code, SecurityFault::NoSuchEnclave);
  EXPECT_EQ(problem("/robto").value, "/robto");
  EXPECT_EQ(problem("robot").code, NameFault::Invalid);
  EXPECT_EQ(problem("/robot", kNow - 24h).code, SecurityFault::NotYetValid);
  EXPECT_EQ(refusal("/robot", kNow, 3), "security.domain_not_allowed permissions.p7s");
  EXPECT_EQ(problem("/robot", kNow, 3).value, "3");
  EXPECT_EQ(problem("/robot", kNow, 231).code, SecurityFault::DomainTooHigh);
  EXPECT_EQ(open_enclave({true, true, "", "/robot"}, 0, kNow).error().code, SecurityFault::NoKeystoreName);
  EXPECT_EQ(open_enclave({true, true, (folder / "none").string(), "/robot"}, 0, kNow).error().code,
            SecurityFault::NotAKeystore);

  const fs::path robot = keystore / "enclaves/robot";
  for (const char* const file : {"cert.pem", "key.pem", "identity_ca.cert.pem", "permissions_ca.cert.pem",
                                 "governance.p7s", "permissions.p7s"}) {
    const std::string at = std::string(" ") + file;
    fs::rename(robot / file, robot / "away");
    EXPECT_EQ(refusal("/robot"), "file.not_found" + at);
    EXPECT_EQ(problem("/robot").where, Place("keys/enclaves/robot/" + std::string(file), 0));
    fs::create_directory(robot / file);
    EXPECT_EQ(refusal("/robot"), "file.not_regular" + at);
    fs::remove(robot / file);
    ASSERT_EQ(::mkfifo((robot / file).c_str(), 0600), 0);  // without a writer
    EXPECT_EQ(refusal("/robot"), "file.not_regular" + at);
    fs::remove(robot / file);
    ASSERT_TRUE(write_file(robot / file, "", Secrecy::Private));
    fs::resize_file(robot / file, kMostFileBytes + 1);
    EXPECT_EQ(refusal("/robot"), "file.too_large" + at);
    fs::remove(robot / file);
    fs::rename(robot / "away", robot / file);
  }
  EXPECT_EQ(refusal("/robot"), " none");
}

// The wording of each code, with the way out that a user needs.
TEST_F(Keystore, explains_what_to_do) {
  make("/robot");
  EXPECT_EQ(problem("/robto").text(),
            "keys: it has no enclave /robto; make it: `nacelle security create-enclave keys /robto`; did you "
            "mean '/robot'?");
  EXPECT_THAT(problem("laptop").text(), HasSubstr("; did you mean '/laptop'?"));
  EXPECT_THAT(problem("/robot", kNow - 24h).text(), HasSubstr("set the clock"));
  EXPECT_EQ(problem("/robot", kNow, 231).text(), "security: there is none in domain 231; take one from 0 to 230");
  EXPECT_THAT(open_enclave({true, true, "", "/robot"}, 0, kNow).error().text(), HasSubstr("ROS_SECURITY_KEYSTORE"));
  EXPECT_THAT(list_enclaves(folder).error().text(), HasSubstr("create-keystore"));
  EXPECT_THAT(create_keystore(keystore, 0, kNow).error().text(), HasSubstr("there is a keystore already"));
  EXPECT_THAT(problem("/robot", kNow + std::chrono::hours(24 * 3651)).text(),
              HasSubstr("cert.pem: the certificate has expired on 2036-11-19T12:00:00 UTC; renew "
                        "it: `nacelle security create-enclave keys /robot --renew`"));
  EXPECT_EQ(problem("/robot", kNow, 9).text(),
            "keys/enclaves/robot/permissions.p7s: it allows nothing in domain 9; add <id>9</id> to each <domains> of "
            "permissions.xml, then move permissions.p7s away, then `nacelle security create-enclave keys /robot`, "
            "which signs permissions.xml");
  EXPECT_THAT(create_enclave({keystore, "/n9", 9}, kNow).error().text(),
              HasSubstr("governance.p7s: it does not govern domain 9; add <id>9</id> to"));
  EXPECT_THAT(create_permission({keystore, "/laptop"}, "").error().text(), HasSubstr("make the enclave first"));
  ::chmod((keystore / "enclaves/robot/key.pem").c_str(), 0644);
  const auto opened = open_enclave({true, true, keystore.string(), "/robot"}, 0, kNow);
  ASSERT_TRUE(opened && opened.value().remarks.size() == 1);
  EXPECT_THAT(opened.value().remarks[0].text(), HasSubstr("chmod 600"));
  fs::remove(keystore / "enclaves/robot/cert.pem");
  EXPECT_THAT(problem("/robot").way_out, HasSubstr("create-enclave keys /robot"));
  fs::create_directory(keystore / "enclaves/robot/cert.pem");
  EXPECT_THAT(problem("/robot").text(), HasSubstr("it is a folder; bring back the file that was there"));
}

TEST_F(Keystore, makes_no_enclave_for_a_domain_that_it_does_not_govern) {
  const auto refused = create_enclave({keystore, "/n9", 9}, kNow);
  ASSERT_FALSE(refused);
  EXPECT_EQ(briefly(refused.error()), "security.domain_not_governed governance.p7s");
  EXPECT_EQ(refused.error().value, "9");
  EXPECT_FALSE(fs::exists(keystore / "enclaves/n9")) << "nothing is made";
  make("/robot");
  EXPECT_EQ(create_permission({keystore, "/robot", 9}, folder / "any").error().code, SecurityFault::DomainNotGoverned);
  EXPECT_TRUE(create_enclave({keystore, "/robot", 9}, kNow)) << "nothing is made of the domain";

  // Follows the suggested fix.
  add_domain(keystore / "enclaves/governance.xml", 9);
  fs::rename(keystore / "enclaves/governance.p7s", folder / "away");
  ASSERT_TRUE(create_keystore(keystore, 0, kNow));
  ASSERT_TRUE(create_enclave({keystore, "/n9", 9}, kNow));
  EXPECT_EQ(refusal("/n9", kNow, 9), " none");
  EXPECT_EQ(refusal("/robot"), " none") << "the first domain is governed as before";
}

TEST_F(Keystore, comes_to_allow_another_domain_without_losing_rules) {
  make("/robot");
  EXPECT_EQ(refusal("/robot", kNow, 9), "security.domain_not_allowed permissions.p7s");
  add_domain(keystore / "enclaves/robot/permissions.xml", 9);
  fs::remove(keystore / "enclaves/robot/permissions.p7s");
  make("/robot");
  EXPECT_EQ(refusal("/robot", kNow, 9), "security.domain_not_governed governance.p7s");
  EXPECT_EQ(refusal("/robot"), " none");
}

TEST_F(Keystore, needs_a_name) {
  for (const auto& refused : {create_keystore("", 0, kNow), create_enclave({"", "/robot"}, kNow)})
    EXPECT_EQ(refused.error().text(), "keystore: the name is empty; name the keystore's folder: keys");
  EXPECT_EQ(list_enclaves("").error().code, SecurityFault::NoKeystoreName);
}

TEST_F(Keystore, tells_whose_permissions_it_found) {
  make("/robot");
  make("/laptop");
  const fs::path robot = keystore / "enclaves/robot", laptop = keystore / "enclaves/laptop";
  fs::copy_file(robot / "permissions.p7s", laptop / "permissions.p7s", fs::copy_options::overwrite_existing);
  EXPECT_EQ(problem("/laptop").code, SecurityFault::OtherSubject);
  EXPECT_EQ(problem("/laptop").value, "CN=/laptop");
  EXPECT_EQ(problem("/laptop").text(),
            "keys/enclaves/laptop/permissions.p7s: it is for CN=/robot, and the certificate is for CN=/laptop; move "
            "permissions.p7s away, then `nacelle security create-enclave keys /laptop`, which signs permissions.xml");
  fs::copy_file(robot / "permissions.xml", laptop / "permissions.xml", fs::copy_options::overwrite_existing);
  EXPECT_EQ(problem("/laptop").code, SecurityFault::OtherSubject);
  EXPECT_THAT(problem("/laptop").text(),
              HasSubstr("; bring back the enclave's own; or move permissions.p7s and "
                        "permissions.xml away, then `nacelle security create-enclave keys /laptop`: "
                        "it makes permissions for everything"));
  fs::remove(laptop / "permissions.xml");
  fs::remove(laptop / "permissions.p7s");
  make("/laptop");
  EXPECT_EQ(refusal("/laptop"), " none");
}

TEST_F(Keystore, does_not_take_the_files_of_another_enclave_or_keystore) {
  make("/robot");
  make("/laptop");
  const fs::path robot = keystore / "enclaves/robot", laptop = keystore / "enclaves/laptop";
  fs::copy_file(laptop / "key.pem", robot / "key.pem", fs::copy_options::overwrite_existing);
  EXPECT_EQ(refusal("/robot"), "security.key_differs key.pem");
  make("/robot", true);

  const fs::path foreign = folder / "foreign";
  ASSERT_TRUE(create_keystore(foreign, 0, kNow));
  ASSERT_TRUE(create_enclave({foreign, "/robot"}, kNow));
  fs::copy_file(foreign / "enclaves/robot/permissions.p7s", robot / "permissions.p7s",
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(refusal("/robot"), "security.not_signed permissions.p7s");
  make("/robot", true);
  EXPECT_EQ(refusal("/robot"), " none");
  for (const char* const file : {"cert.pem", "key.pem"})
    fs::copy_file(foreign / "enclaves/robot" / file, robot / file, fs::copy_options::overwrite_existing);
  EXPECT_EQ(refusal("/robot"), "security.not_signed cert.pem");
}

}  // namespace
}  // namespace nacelle::security
