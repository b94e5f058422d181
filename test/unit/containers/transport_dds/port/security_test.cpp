// SPDX-License-Identifier: Apache-2.0
// DDS Security by Debian's plugins: only participants with keys receive each other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <filesystem>
#include <regex>

#include "security/enclave.hpp"
#include "security/files.hpp"
#include "security/keystore.hpp"
#include "security/policy.hpp"
#include "support/dds.hpp"

namespace nacelle::transport_dds {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

WallTime now() { return SystemClock{}.wall_now(); }

/// For all domains: the participants of one process have a number each.
std::string for_all_domains(const std::string& xml) {
  return std::regex_replace(xml, std::regex{"<id>[0-9]+</id>"}, "<id_range><min>0</min><max>230</max></id_range>");
}

/// A keystore of a test's own.
class Keys {
 public:
  Keys() {
    std::string name = fs::temp_directory_path() / "nacelle-keys-XXXXXX";
    folder_ = ::mkdtemp(name.data());
    write(folder_ / "enclaves/governance.xml", for_all_domains(security::governance_xml(0)));
    const auto made = security::create_keystore(folder_, 0, now());
    EXPECT_TRUE(made) << made.error().text();
  }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;
  ~Keys() { fs::remove_all(folder_); }

  SecurityFiles enclave(const std::string& name, const security::Policy& policy = security::everything()) {
    write(security::folder_of(folder_, name) / "permissions.xml",
          for_all_domains(security::permissions_xml(policy, name, {now(), now() + 24h}, 0)));
    const auto made = security::create_enclave({folder_, name}, now());
    EXPECT_TRUE(made) << made.error().text();
    const auto opened = security::open_enclave({true, true, folder_.string(), name}, 0, now());
    EXPECT_TRUE(opened) << opened.error().text();
    return opened ? opened.value().secured.files : SecurityFiles{};
  }

 private:
  static void write(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    EXPECT_TRUE(security::write_file(path, text, security::Secrecy::Public));
  }
  fs::path folder_;
};

std::unique_ptr<Participant> participant_with(const SecurityFiles& files) {
  ParticipantOptions options;
  options.security = files;
  return test::make_participant(options);
}

/// A reader of /chatter and its listener.
struct Listening {
  explicit Listening(Participant& participant, const std::string& topic = "chatter")
      : reader(participant.create_reader(test::string_topic(topic), &told).value()) {}
  test::Told told;
  std::unique_ptr<Reader> reader;
};

std::unique_ptr<Writer> writer_of(Participant& participant, const std::string& topic = "chatter",
                                  EndpointListener* listener = nullptr) {
  return participant.create_writer(test::string_topic(topic), listener).value();
}

TEST(Security, connects_only_participants_of_one_keystore) {
  Keys ours, theirs;
  const auto robot = participant_with(ours.enclave("/robot")), laptop = participant_with(ours.enclave("/laptop"));
  const auto foreign = participant_with(theirs.enclave("/robot"));
  const auto plain = test::make_participant(), other_plain = test::make_participant();
  Listening known(*laptop), of_foreign(*foreign), of_plain(*plain);
  test::Told robot_told, plain_told;
  const auto writer = writer_of(*robot, "chatter", &robot_told);
  const auto foreign_writer = writer_of(*foreign), plain_writer = writer_of(*other_plain, "chatter", &plain_told);

  ASSERT_TRUE(known.told.until([&] { return known.reader->matched_count() == 1; }));
  ASSERT_TRUE(robot_told.until([&] { return writer->status().matched == 1; }));
  ASSERT_EQ(test::say(*writer, "among us"), Writer::Sent::Yes);
  ASSERT_TRUE(known.told.until([&] { return known.reader->has_waiting(); }));
  EXPECT_EQ(test::hear(*known.reader), "among us");

  // Those in the clear have met by now, and heard what the others send in the clear.
  ASSERT_TRUE(of_plain.told.until([&] { return of_plain.reader->matched_count() == 1; }));
  ASSERT_TRUE(plain_told.until([&] { return plain_writer->status().matched == 1; }));
  ASSERT_EQ(test::say(*plain_writer, "for all"), Writer::Sent::Yes);
  ASSERT_EQ(test::say(*foreign_writer, "for theirs"), Writer::Sent::Yes);
  ASSERT_TRUE(of_plain.told.until([&] { return of_plain.reader->has_waiting(); }));
  EXPECT_EQ(test::hear(*of_plain.reader), "for all");
  EXPECT_EQ(test::hear(*of_plain.reader), "nothing");
  EXPECT_EQ(test::hear(*of_foreign.reader), "for theirs");
  EXPECT_EQ(test::hear(*of_foreign.reader), "nothing");
  EXPECT_EQ(test::hear(*known.reader), "nothing");
  EXPECT_EQ(writer->status().matched_total, 1U);
  EXPECT_EQ(known.reader->status().matched_total, 1U);
  EXPECT_EQ(of_foreign.reader->status().matched_total, 1U);
  EXPECT_EQ(of_plain.reader->status().matched_total, 1U);
}

TEST(Security, refuses_a_topic_that_the_permissions_forbid_and_names_it) {
  Keys keys;
  const auto robot = participant_with(
      keys.enclave("/robot", {{security::Deed::Publish, false, {"/secret"}}, {security::Deed::Publish, true, {"/*"}}}));
  const auto allowed = robot->create_writer(test::string_topic("chatter"), nullptr);
  EXPECT_TRUE(allowed) << allowed.error().text();
  const auto denied = robot->create_writer(test::string_topic("secret"), nullptr);
  ASSERT_FALSE(denied);
  EXPECT_THAT(denied.error().text(), HasSubstr("rt/secret: the permissions of the own enclave forbid it"));
  EXPECT_THAT(denied.error().way_out, HasSubstr("create-permission"));
  const auto unread = robot->create_reader(test::string_topic("chatter"), nullptr);
  ASSERT_FALSE(unread) << "nothing may be read";
  EXPECT_THAT(unread.error().text(), HasSubstr("rt/chatter"));
}

TEST(Security, keeps_a_participant_with_rights_from_what_it_has_no_right_to) {
  Keys keys;
  const auto robot = participant_with(keys.enclave("/robot"));
  const auto laptop =
      participant_with(keys.enclave("/laptop", {{security::Deed::Subscribe, true, {"/public", "/secret"}}}));
  const auto camera = participant_with(keys.enclave("/camera", {{security::Deed::Publish, true, {"/public"}}}));
  Listening open(*laptop, "public"), shut(*robot, "public");
  const auto writer = writer_of(*camera, "public");
  ASSERT_TRUE(open.told.until([&] { return open.reader->matched_count() == 1; }));
  ASSERT_TRUE(shut.told.until([&] { return shut.reader->matched_count() == 1; }));
  EXPECT_FALSE(laptop->create_writer(test::string_topic("public"), nullptr));
  EXPECT_FALSE(camera->create_writer(test::string_topic("secret"), nullptr));
}

// A limit of Cyclone 0.10 (docs/security.md): it creates no topic that a deny rule names, even if for one direction only.
TEST(Security, denies_a_topic_both_ways_where_one_is_denied) {
  Keys keys;
  const auto robot = participant_with(keys.enclave(
      "/robot", {{security::Deed::Publish, false, {"/chatter"}}, {security::Deed::Subscribe, true, {"/*"}}}));
  const auto other = robot->create_reader(test::string_topic("other"), nullptr);
  EXPECT_TRUE(other) << other.error().text();
  EXPECT_FALSE(robot->create_reader(test::string_topic("chatter"), nullptr));
}

TEST(Security, tells_of_files_that_the_plugins_refuse) {
  Keys ours, theirs;
  SecurityFiles files = ours.enclave("/robot");
  files.permissions = theirs.enclave("/robot").permissions;
  const auto made =
      Participant::create({.domain_id = 77, .config = test::loopback_config(test::test_domain()), .security = files});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().text(), HasSubstr("DDS domain 77: Error occurred while validating local permissions"));
}

// Not so readers: Cyclone 0.10 announces their end on the wrong channel, and keeps the announcement itself (ADR 0020).
TEST(Security, keeps_no_memory_of_protected_writers_that_have_ended) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "the sanitizer's heap says nothing of sizes";
#endif
  Keys ours;
  const auto participant = participant_with(ours.enclave("/robot"));
  const auto cycle = [&](int times) {
    for (int i = 0; i < times; ++i) static_cast<void>(writer_of(*participant));
  };
  cycle(100);
  const auto before = static_cast<double>(::mallinfo2().uordblks);
  cycle(1000);
  const double grown = static_cast<double>(::mallinfo2().uordblks) - before;
  RecordProperty("bytes_grown", std::to_string(grown));
  EXPECT_LT(grown, 128 * 1024);  // each of the keys has 400 bytes
}

}  // namespace
}  // namespace nacelle::transport_dds
