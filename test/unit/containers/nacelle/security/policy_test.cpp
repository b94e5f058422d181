// SPDX-License-Identifier: Apache-2.0
#include "security/policy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../control/temporary_folder.hpp"
#include "security/files.hpp"
#include "security/policy_includes.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Validity kYear{{std::chrono::seconds(1'795'348'800)}, {std::chrono::seconds(1'826'884'800)}};

std::string enclave_with(const std::string& profile) {
  return "<policy version=\"0.2.0\"><enclaves><enclave path=\"/robot\"><profiles>\n" + profile +
         "\n</profiles></enclave><enclave path=\"/laptop\"><profiles><profile ns=\"/\" "
         "node=\"n\"/></profiles></enclave>"
         "</enclaves></policy>";
}
Problem mistake_in(const std::string& xml, const std::string& enclave = "/robot") {
  const auto read = read_policy(xml, "p.xml", enclave);
  return read ? Problem{"none", "", ""} : read.error();
}
/// The problem has this code, is about this value, and is on this line of p.xml.
void expect(const Problem& problem, const ProblemCode& code, const std::string& value, int line = 2) {
  EXPECT_EQ(problem.code.text(), code.text()) << problem.text();
  EXPECT_EQ(problem.value, value) << problem.text();
  EXPECT_EQ(problem.where.text(), Place("p.xml", line).text()) << problem.text();
}

TEST(Permissions, of_a_new_enclave_are_those_of_sros2_word_for_word) {
  const auto rule = [](const char* name) {
    return std::string("        <") + name +
           ">\n          <topics>\n"
           "            <topic>rq/*/_action/cancel_goalRequest</topic>\n"
           "            <topic>rq/*/_action/get_resultRequest</topic>\n"
           "            <topic>rq/*/_action/send_goalRequest</topic>\n"
           "            <topic>rq/*Request</topic>\n"
           "            <topic>rr/*/_action/cancel_goalReply</topic>\n"
           "            <topic>rr/*/_action/get_resultReply</topic>\n"
           "            <topic>rr/*/_action/send_goalReply</topic>\n"
           "            <topic>rt/*/_action/feedback</topic>\n"
           "            <topic>rt/*/_action/status</topic>\n"
           "            <topic>rr/*Reply</topic>\n"
           "            <topic>rt/*</topic>\n"
           "          </topics>\n        </" +
           name + ">\n";
  };
  const auto graph = [](const char* name) {
    return std::string("        <") + name +
           ">\n          <topics>\n            <topic>ros_discovery_info</topic>\n          </topics>\n        </" +
           name + ">\n";
  };
  const std::string domains = "        <domains>\n          <id>7</id>\n        </domains>\n";
  EXPECT_EQ(permissions_xml(everything(), "/arm/left", kYear, 7),
            "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:noNamespaceSchemaLocation="
            "\"http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd\">\n  <permissions>\n"
            "    <grant name=\"/arm/left\">\n      <subject_name>CN=/arm/left</subject_name>\n      <validity>\n"
            "        <not_before>2026-11-22T12:00:00</not_before>\n        <not_after>2027-11-22T12:00:00</not_after>\n"
            "      </validity>\n      <allow_rule>\n" +
                domains + rule("publish") + rule("subscribe") + "      </allow_rule>\n      <allow_rule>\n" + domains +
                graph("publish") + graph("subscribe") +
                "      </allow_rule>\n      <default>DENY</default>\n    </grant>\n  </permissions>\n</dds>\n");
}

TEST(Permissions, deny_first_and_name_services_by_their_two_topics) {
  const Policy policy{
      {Deed::Publish, false, {"/cmd_vel"}}, {Deed::Publish, true, {"/*"}}, {Deed::Reply, true, {"/reset"}}};
  const std::string xml = permissions_xml(policy, "/robot", kYear, 0);
  const auto deny = xml.find("<deny_rule>"), allow = xml.find("<allow_rule>");
  ASSERT_LT(deny, allow);
  EXPECT_THAT(xml.substr(deny, allow - deny), HasSubstr("<topic>rt/cmd_vel</topic>"));
  EXPECT_THAT(xml.substr(deny, allow - deny), Not(HasSubstr("<subscribe>")));
  const auto subscribe = xml.find("<subscribe>");
  EXPECT_LT(xml.find("rr/resetReply"), subscribe) << "a server writes replies";
  EXPECT_GT(xml.find("rq/resetRequest"), subscribe) << "and reads requests";
}

TEST(Policy, makes_full_names_of_a_nodes_own) {
  const auto read = read_policy(enclave_with(R"(<profile ns="/arm" node="driver">
    <topics publish="ALLOW" subscribe="DENY"><topic>state</topic><topic>~/raw</topic><topic>/tf</topic></topics>
    <services reply="ALLOW"><service>~/get_parameters</service></services>
    <actions execute="ALLOW"><action>/dock</action></actions></profile>)"),
                                "p.xml", "/robot");
  ASSERT_TRUE(read) << read.error().text();
  const std::vector<std::string> topics{"/arm/state", "/arm/driver/raw", "/tf"};
  EXPECT_EQ(read.value(), (Policy{{Deed::Publish, true, topics},
                                  {Deed::Subscribe, false, topics},
                                  {Deed::Reply, true, {"/arm/driver/get_parameters"}},
                                  {Deed::Execute, true, {"/dock"}}}));
}

TEST(Policy, refuses_mistakes_with_code_line_and_value) {
  const auto with = [](const std::string& profile) { return mistake_in(enclave_with(profile)); };
  const std::string node = "<profile ns=\"/\" node=\"n\">", end = "</profile>";
  expect(mistake_in(enclave_with(""), "/robott"), SecurityFault::NoSuchEnclave, "/robott", 0);
  expect(mistake_in("<policy"), PolicyFault::Malformed, "", 1);
  expect(mistake_in("<dds/>"), PolicyFault::NotAPolicy, "", 0);
  expect(with("<profile ns=\"/\"/>"), PolicyFault::MissingAttribute, "");
  expect(with(node + "<topic/>" + end), PolicyFault::UnknownElement, "topic");
  expect(with(node + "<topics publish=\"YES\"/>" + end), PolicyFault::WrongValue, "YES");
  expect(with(node + "<topics reply=\"ALLOW\"/>" + end), PolicyFault::UnknownAttribute, "reply");
  expect(with(node + "<topics publish=\"ALLOW\"><topic>/a b</topic></topics>" + end), PolicyFault::WrongValue, "/a b");
}

TEST(PolicyProblem, has_these_words) {
  const auto with = [](const std::string& list) {
    return mistake_in(enclave_with("<profile ns=\"/\" node=\"n\">" + list + "</profile>")).text();
  };
  EXPECT_EQ(mistake_in(enclave_with(""), "/robott").text(),
            "p.xml: it has no enclave with the path '/robott'; did you mean '/robot'?");
  EXPECT_EQ(mistake_in("<dds/>").text(),
            "p.xml: this is not a policy file: it has no <policy><enclaves>; see docs/security.md");
  EXPECT_EQ(mistake_in(enclave_with("<profile ns=\"/\"/>")).text(), "p.xml:2: a profile needs 'ns' and 'node'");
  EXPECT_EQ(with("<topic/>"), "p.xml:2: unexpected element 'topic'; did you mean 'topics'?");
  EXPECT_EQ(with("<topics publish=\"YES\"/>"), "p.xml:2: 'publish' cannot be 'YES'; ALLOW or DENY");
  EXPECT_EQ(with("<topics reply=\"ALLOW\"/>"), "p.xml:2: 'topics' has no 'reply'; one of publish, subscribe");
}

class Includes : public ::testing::Test {
 public:
  std::string path_of(const std::string& name, const std::string& text) {
    const std::filesystem::path path = folder.path() + "/" + name;
    std::filesystem::create_directories(path.parent_path());
    EXPECT_TRUE(write_file(path, text, Secrecy::Public));
    return path.string();
  }
  /// The code of the problem, and its place below the folder: "policy.wrong_value a.xml:1".
  std::string refusal(const std::string& name, const std::string& text) {
    const auto read = read_with_includes(path_of(name, text));
    if (read) return "none";
    const std::string place = read.error().where.text();
    EXPECT_TRUE(place.starts_with(folder.path())) << place;
    return read.error().code.text() + " " + place.substr(folder.path().size() + 1);
  }
  TemporaryFolder folder;
};

TEST_F(Includes, stand_for_what_they_lead_to) {
  path_of("common/time.xml", R"(<profile><topics subscribe="ALLOW"><topic>/clock</topic></topics></profile>)");
  path_of("common/node.xml", R"xml(<profile xmlns:xi="x"><xi:include href="time.xml" xpointer="xpointer(/profile/*)"/>
    <topics publish="ALLOW"><topic>/rosout</topic></topics></profile>)xml");
  const std::string policy = path_of("policy.xml", enclave_with(R"xml(<profile ns="/" node="n" xmlns:xi="x">
    <xi:include href="common/node.xml" xpointer="xpointer(/profile/*)"/>
    <topics publish="ALLOW"><topic>scan</topic></topics></profile>)xml"));
  const auto xml = read_with_includes(policy);
  ASSERT_TRUE(xml) << xml.error().text();
  const auto read = read_policy(xml.value(), policy, "/robot");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read.value(), (Policy{{Deed::Subscribe, true, {"/clock"}},
                                  {Deed::Publish, true, {"/rosout"}},
                                  {Deed::Publish, true, {"/scan"}}}));
}

TEST_F(Includes, that_lead_nowhere_are_reported) {
  EXPECT_EQ(refusal("a.xml", "<a><xi:include href=\"none.xml\"/></a>"), "file.not_found none.xml");
  EXPECT_EQ(refusal("a.xml", "<a>\n<xi:include/></a>"), "policy.missing_attribute a.xml:2");
  EXPECT_EQ(refusal("a.xml", "<a><xi:include href=\"a.xml\"/></a>"), "policy.nested_includes a.xml");
  EXPECT_EQ(refusal("a.xml", "<a>\n<xi:include</a>"), "policy.malformed a.xml:2");
  path_of("b.xml", "<b/>");
  EXPECT_EQ(refusal("a.xml", "<a><xi:include href=\"b.xml\" xpointer=\"element(1)\"/></a>"),
            "policy.wrong_value a.xml:1");
  EXPECT_EQ(refusal("a.xml", "<a>\n</a>"), "none");
}

TEST(Policy, that_is_written_is_read_again) {
  const NodeProfile lidar{"/front", "lidar", {"/front/scan"}, {"/clock"}, {"/front/lidar/get_state"}, {}};
  const auto read = read_policy(policy_xml("/robot", {lidar}), "p.xml", "/robot");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read.value(), (Policy{{Deed::Reply, true, {"/front/lidar/get_state"}},
                                  {Deed::Subscribe, true, {"/clock"}},
                                  {Deed::Publish, true, {"/front/scan"}}}));
}

TEST(Grant, is_found_by_its_subject_with_times_and_domain) {
  const std::string xml = permissions_xml(everything(), "/robot", kYear, 7);
  const auto found = find_grant(xml, "CN=/robot", 7);
  ASSERT_TRUE(found && found.value()) << xml;
  EXPECT_EQ(found.value()->validity.ends, kYear.ends);
  EXPECT_TRUE(found.value()->covers_domain);
  EXPECT_FALSE(find_grant(xml, "CN=/robot", 8).value_or({})->covers_domain);
  const Problem other = find_grant(xml, "CN=/laptop", 7).error();
  EXPECT_EQ(other.code, SecurityFault::OtherSubject);
  EXPECT_EQ(other.value, "CN=/laptop");
  EXPECT_EQ(other.text(), "it is for CN=/robot, and the certificate is for CN=/laptop");
  const auto of_parts = find_grant(xml, "CN=/robot,O=us", 7);
  ASSERT_TRUE(of_parts) << "not judged here: DDS takes parts in any order";
  EXPECT_FALSE(of_parts.value().has_value());
  EXPECT_EQ(find_grant("<dds/>", "CN=/robot", 7).error().code, SecurityFault::NotADocument);
}

TEST(Governance, covers_a_domain_or_a_range_of_them) {
  EXPECT_TRUE(governs(governance_xml(7), 7).value_or(false));
  EXPECT_FALSE(governs(governance_xml(7), 8).value_or(true));
  std::string range = governance_xml(7);
  range.replace(range.find("<id>7</id>"), 10, "<id_range><min>3</min></id_range>");
  EXPECT_TRUE(governs(range, 200).value_or(false));
  EXPECT_FALSE(governs(range, 2).value_or(true));
  EXPECT_EQ(governs("rubbish", 0).error().code, SecurityFault::NotADocument);
}

}  // namespace
}  // namespace nacelle::security
