// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/participant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/dds.hpp"

#if defined(__SANITIZE_ADDRESS__)
#define NACELLE_FINDS_LEAKS
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define NACELLE_FINDS_LEAKS
#endif
#endif
#ifdef NACELLE_FINDS_LEAKS
#include <sanitizer/lsan_interface.h>
#endif

namespace nacelle::transport_dds {
namespace {

using ::testing::HasSubstr;

std::string problem_with(const ParticipantOptions& options) {
  const auto made = Participant::create(options);
  return made ? "none" : made.error().text();
}

TEST(Participant, has_a_gid_of_a_participant) {
  const auto participant = test::make_participant();
  EXPECT_TRUE(participant->gid().is_participant()) << participant->gid().text();
}

TEST(Participant, names_the_mistake_in_its_configuration) {
  EXPECT_THAT(problem_with({.domain_id = 90, .config = "<General><Interfacs/></General>"}), HasSubstr("Interfacs"));
  EXPECT_THAT(problem_with({.domain_id = 90, .config = "<General><"}), HasSubstr("configuration"));
}

TEST(Participant, names_an_interface_that_is_not_there) {
  const std::string config = "<General><Interfaces><NetworkInterface name=\"wlan7\"/></Interfaces></General>";
  const std::string problem = problem_with({.domain_id = 90, .config = config});
  EXPECT_THAT(problem, HasSubstr("wlan7"));
  EXPECT_THAT(problem, HasSubstr("ip address"));
}

TEST(Participant, tells_of_peers_without_an_address) {
  const std::string peers =
      "<Discovery><Peers><Peer address=\"nosuch.invalid\"/><Peer address=\"127.0.0.1\"/></Peers></Discovery>";
  const auto made = Participant::create(
      {.domain_id = 95, .config = test::loopback_config(test::test_domain()) + peers, .is_trial = true});
  ASSERT_TRUE(made) << made.error().text();
  ASSERT_EQ(made.value()->remarks().size(), 1U);
  EXPECT_EQ(made.value()->remarks()[0].where.text(), "peer nosuch.invalid");
}

TEST(Participant, is_one_per_domain_and_process) {
  const auto config = test::loopback_config(test::test_domain());
  const auto first = Participant::create({.domain_id = 91, .config = config});
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_THAT(problem_with({.domain_id = 91, .config = config}), HasSubstr("already"));
}

/// Cyclone 0.10 loses 240 bytes in rtps_init() when it finds no index.
auto create_and_forgive_cyclone(const ParticipantOptions& options) {
#ifdef NACELLE_FINDS_LEAKS
  const __lsan::ScopedDisabler forgive;
#endif
  return Participant::create(options);
}

TEST(Participant, says_when_there_is_no_free_index) {
  ParticipantOptions options;
  options.domain_id = 100;
  options.config =
      "<General><Interfaces><NetworkInterface "
      "name=\"lo\"/></Interfaces><AllowMulticast>false</AllowMulticast></General>"
      "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>2</MaxAutoParticipantIndex>"
      "<ExternalDomainId>" +
      std::to_string(test::test_domain()) + "</ExternalDomainId></Discovery>";
  std::vector<std::unique_ptr<Participant>> others;
  std::string problem;
  for (; problem.empty() && others.size() < 5; ++options.domain_id) {
    auto made = create_and_forgive_cyclone(options);
    if (made) {
      others.push_back(std::move(*made));
    } else {
      problem = made.error().text();
    }
  }
  EXPECT_GE(others.size(), 1U);
  EXPECT_THAT(problem, HasSubstr("MaxAutoParticipantIndex"));
}

TEST(Participant, keeps_shared_memory_off_whatever_is_asked_for) {
  // With it Cyclone would wait a minute for its daemon, and then abort.
  const auto participant = Participant::create(
      {.domain_id = 94,
       .config = test::loopback_config(test::test_domain()) + "<SharedMemory><Enable>true</Enable></SharedMemory>"});
  EXPECT_TRUE(participant) << participant.error().text();
}

TEST(Participant, lets_its_endpoints_live_on) {
  auto participant = test::make_participant();
  auto writer = participant->create_writer(test::string_topic("lives_on"), nullptr);
  ASSERT_TRUE(writer);
  participant.reset();
  EXPECT_EQ(test::say(**writer, "still here"), Writer::Sent::Yes);
}

TEST(Participant, refuses_a_topic_name_that_is_none) {
  const auto participant = test::make_participant();
  auto options = test::string_topic("x");
  options.topic = "rt/with a \"quote\" and a space";
  const auto writer = participant->create_writer(options, nullptr);
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().text(), HasSubstr("quote"));
}

}  // namespace
}  // namespace nacelle::transport_dds
