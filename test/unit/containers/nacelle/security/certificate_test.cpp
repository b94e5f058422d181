// SPDX-License-Identifier: Apache-2.0
#include "security/certificate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

using ::testing::HasSubstr;

const WallTime kNoon{std::chrono::seconds(1'795'348'800)};  // 2026-11-22T12:00:00

KeyAndCertificate authority_named(const std::string& name) {
  auto made = make_authority(name, kNoon);
  EXPECT_TRUE(made) << made.error().text();
  return std::move(made).value();
}
KeyAndCertificate made_by(const KeyAndCertificate& authority, const std::string& name) {
  auto made = make_certificate(name, authority, kNoon);
  EXPECT_TRUE(made) << made.error().text();
  return std::move(made).value();
}

TEST(Certificate, says_whose_it_is_and_holds_for_ten_years) {
  const auto made = made_by(authority_named("sros2CA"), "/arm/left");
  const auto facts = read_certificate(made.certificate);
  ASSERT_TRUE(facts) << facts.error().text();
  EXPECT_EQ(facts.value().subject, "CN=/arm/left");
  EXPECT_EQ(facts.value().common_name, "/arm/left");
  EXPECT_EQ(utc_text(facts.value().begins), "2026-11-22T12:00:00");
  EXPECT_EQ(utc_text(facts.value().ends), "2036-11-19T12:00:00");
  EXPECT_EQ(made.key.find("-----BEGIN PRIVATE KEY-----"), 0U) << "PKCS #8, as SROS 2 writes it";
}

TEST(Certificate, fits_its_own_key_and_no_other) {
  const auto authority = authority_named("sros2CA");
  const auto one = made_by(authority, "/one"), other = made_by(authority, "/other");
  EXPECT_TRUE(check_key(one.key, one.certificate));
  EXPECT_EQ(check_key(other.key, one.certificate).error().code, SecurityFault::KeyDiffers);
  EXPECT_EQ(check_key("rubbish", one.certificate).error().code, SecurityFault::NotAKey);
  EXPECT_EQ(check_key(one.key, one.key).error().code, SecurityFault::NotACertificate);
}

TEST(Certificate, is_known_to_the_authority_that_signed_it_alone) {
  const auto authority = authority_named("sros2CA"), stranger = authority_named("sros2CA");
  const auto one = made_by(authority, "/one");
  EXPECT_TRUE(check_issuer(one.certificate, authority.certificate));
  EXPECT_EQ(check_issuer(one.certificate, stranger.certificate).error().code, SecurityFault::NotSigned);
}

TEST(Certificate, has_a_name_that_x509_can_hold) {
  const auto authority = authority_named("sros2CA");
  EXPECT_TRUE(make_certificate("/" + std::string(63, 'a'), authority, kNoon));
  const std::string long_name = "/" + std::string(64, 'a');
  const Problem refusal = make_certificate(long_name, authority, kNoon).error();
  EXPECT_EQ(refusal.code, SecurityFault::WrongCommonName);
  EXPECT_EQ(refusal.value, long_name);
  EXPECT_EQ(make_certificate("", authority, kNoon).error().code, SecurityFault::WrongCommonName);
}

TEST(SignedDocument, gives_back_the_text_that_was_signed) {
  const auto authority = authority_named("sros2CA");
  const std::string text = "<dds>\n  <!-- ä -->\n</dds>\n";
  const auto document = sign_document(text, authority);
  ASSERT_TRUE(document) << document.error().text();
  EXPECT_THAT(document.value(), HasSubstr("<!-- ä -->")) << "a person can read it";
  EXPECT_THAT(document.value(), HasSubstr("sha-256"));
  EXPECT_EQ(read_signed_document(document.value(), authority.certificate).value_or("not signed"), text);
}

TEST(SignedDocument, is_refused_with_a_changed_word_or_of_another_authority) {
  const auto authority = authority_named("sros2CA"), stranger = authority_named("sros2CA");
  std::string document = sign_document("<default>DENY</default>\n", authority).value_or("");
  EXPECT_EQ(read_signed_document(document, stranger.certificate).error().code, SecurityFault::NotSigned);
  document.replace(document.find("DENY"), 4, "DANY");
  EXPECT_EQ(read_signed_document(document, authority.certificate).error().code, SecurityFault::NotSigned);
  EXPECT_EQ(read_signed_document("rubbish", authority.certificate).error().code, SecurityFault::NotADocument);
}

TEST(UtcText, is_read_as_it_is_written_with_and_without_a_zone) {
  EXPECT_EQ(read_utc(utc_text(kNoon)).value_or(WallTime{}), kNoon);
  EXPECT_EQ(read_utc("2026-11-22T12:00:00Z").value_or(WallTime{}), kNoon);
  EXPECT_EQ(read_utc("2026-11-22T13:30:00+01:30").value_or(WallTime{}), kNoon);
  EXPECT_EQ(read_utc("2026-11-22T07:00:00-05:00").value_or(WallTime{}), kNoon);
  EXPECT_EQ(read_utc("tomorrow").error().code, SecurityFault::WrongDate);
  EXPECT_EQ(read_utc("tomorrow").error().value, "tomorrow");
}

TEST(CertificateProblem, has_these_words) {
  const auto authority = authority_named("sros2CA"), stranger = authority_named("sros2CA");
  const auto one = made_by(authority, "/one"), other = made_by(authority, "/other");
  const auto words_of = [](const auto& result) { return result.error().text(); };
  EXPECT_EQ(words_of(check_key(other.key, one.certificate)), "the key is not the certificate's");
  EXPECT_THAT(words_of(check_key("rubbish", one.certificate)), HasSubstr("this is not a private key that can be read"));
  EXPECT_THAT(words_of(read_certificate("rubbish")), HasSubstr("this is not a certificate"));
  EXPECT_THAT(words_of(check_issuer(one.certificate, stranger.certificate)),
              HasSubstr("the authority did not sign it"));
  EXPECT_THAT(words_of(read_signed_document("rubbish", authority.certificate)),
              HasSubstr("this is not a signed document"));
  EXPECT_EQ(words_of(make_certificate("", authority, kNoon)), "the name '' has 0 bytes; a certificate's has 1 to 64");
  EXPECT_EQ(words_of(read_utc("tomorrow")), "'tomorrow' is not a date; write 2026-11-22T14:40:00");
}

}  // namespace
}  // namespace nacelle::security
