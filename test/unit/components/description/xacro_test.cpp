// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/xacro.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <tinyxml2.h>
#include <cstdlib>
#include <filesystem>

#include <memory>

namespace nacelle::description {
namespace {

using Files = std::map<std::string, std::string>;

Result<XacroResult, Problem> expand(const Files& files, const std::map<std::string, std::string>& arguments = {}) {
  XacroEnvironment environment;
  environment.read_file = [files](const std::string& path) -> Result<std::string, Problem> {
    const auto found = files.find(path);
    if (found == files.end()) return err(Problem{path, "cannot be read", ""});
    return found->second;
  };
  environment.find_package = [](const std::string& package) {
    return package == "arm" ? std::string{"/share/arm"} : std::string{};
  };
  environment.variable = [](const std::string& name) {
    return name == "SIDE" ? std::optional<std::string>{"left"} : std::nullopt;
  };
  return expand_xacro("/r/robot.xacro", arguments, environment);
}

std::string robot(const std::string& body) {
  return "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n" + body + "\n</robot>";
}

/// Elements and attributes in one line, without indentation.
std::string compact(const std::string& xml) {
  tinyxml2::XMLDocument document;
  if (document.Parse(xml.c_str()) != tinyxml2::XML_SUCCESS) return "no XML: " + xml;
  tinyxml2::XMLPrinter printer(nullptr, true);
  document.RootElement()->Accept(&printer);
  return printer.CStr();
}

std::string made(const std::string& body, const std::map<std::string, std::string>& arguments = {}) {
  auto result = expand({{"/r/robot.xacro", robot(body)}}, arguments);
  if (!result) return result.error().text();
  std::string text = compact(result->urdf);
  const std::string begin = "<robot name=\"r\">", end = "</robot>";
  if (text == "<robot name=\"r\"/>") return "";
  EXPECT_TRUE(text.starts_with(begin)) << text;
  return text.substr(begin.size(), text.size() - begin.size() - end.size());
}

TEST(Xacro, replaces_properties_with_arithmetic_and_joins_texts) {
  EXPECT_EQ(made("<xacro:property name=\"width\" value=\"0.30\"/>"
                 "<xacro:property name=\"half\" value=\"${width/2}\"/>"
                 "<origin xyz=\"0 -${half} ${-half}\" rpy=\"0 ${pi/2} 0\" name=\"a_${width}_b\"/>"),
            "<origin xyz=\"0 -0.15 -0.15\" rpy=\"0 1.5707963267948966 0\" name=\"a_0.3_b\"/>");
  EXPECT_EQ(made("<xacro:property name=\"n\" value=\"3\"/><a v=\"${n}\" w=\"${n+1}\" t=\"$${n}\"/>"),
            "<a v=\"3\" w=\"4\" t=\"${n}\"/>");
}

TEST(Xacro, evaluates_a_property_when_it_is_asked_for) {
  EXPECT_EQ(
      made("<xacro:property name=\"a\" value=\"${b*2}\"/><xacro:property name=\"b\" value=\"2\"/><x v=\"${a}\"/>"),
      "<x v=\"4\"/>");
}

TEST(Xacro, calls_macros_with_parameters_defaults_and_blocks) {
  const std::string macro =
      "<xacro:macro name=\"wheel\" params=\"side y:=${1/10} color:='dark grey' *origin **extra\">"
      "<link name=\"${side}_wheel\" y=\"${y}\" color=\"${color}\"><xacro:insert_block name=\"origin\"/>"
      "<xacro:insert_block name=\"extra\"/></link></xacro:macro>";
  EXPECT_EQ(made(macro + "<xacro:wheel side=\"left\"><o x=\"${1+1}\"/><e><a/><b/></e></xacro:wheel>"
                         "<xacro:wheel side=\"right\" y=\"-2\"><o/><e/></xacro:wheel>"),
            "<link name=\"left_wheel\" y=\"0.1\" color=\"dark grey\"><o x=\"2\"/><a/><b/></link>"
            "<link name=\"right_wheel\" y=\"-2\" color=\"dark grey\"><o/></link>");
}

TEST(Xacro, keeps_a_macros_properties_inside_unless_they_are_sent_out) {
  EXPECT_EQ(made("<xacro:property name=\"p\" value=\"1\"/>"
                 "<xacro:macro name=\"m\" params=\"p:=^|7 q:=^|8\"><in v=\"${p} ${q}\"/><xacro:property name=\"p\" "
                 "value=\"2\"/>"
                 "<xacro:property name=\"out\" value=\"${p*10}\" scope=\"parent\"/></xacro:macro>"
                 "<xacro:m/><x v=\"${p} ${out}\"/>"),
            "<in v=\"1 8\"/><x v=\"1 20\"/>");
}

TEST(Xacro, takes_conditions_and_arguments) {
  const std::string body =
      "<xacro:arg name=\"laser\" default=\"false\"/><xacro:arg name=\"side\" default=\"left\"/>"
      "<xacro:if value=\"$(arg laser)\"><laser/></xacro:if><xacro:unless value=\"$(arg laser)\"><none/></xacro:unless>"
      "<xacro:property name=\"s\" value=\"$(arg side)\"/><xacro:if value=\"${s == 'left'}\"><left/></xacro:if>";
  EXPECT_EQ(made(body), "<none/><left/>");
  EXPECT_EQ(made(body, {{"laser", "true"}, {"side", "right"}}), "<laser/>");
  EXPECT_EQ(made(body, {{"lasr", "true"}}), "/r/robot.xacro: declares no argument 'lasr'; did you mean 'laser'?");
}

TEST(Xacro, substitutes_what_stands_outside) {
  EXPECT_EQ(made("<a v=\"$(find arm)/x $(env SIDE) $(optenv NONE a b) $(optenv SIDE z) $(dirname)\"/>"),
            "<a v=\"/share/arm/x left a b left /r\"/>");
}

TEST(Xacro, reads_included_files_beside_the_one_that_names_them) {
  auto result =
      expand({{"/r/robot.xacro", robot("<xacro:include filename=\"parts/wheel.xacro\"/>"
                                       "<xacro:include filename=\"none.xacro\" optional=\"true\"/>"
                                       "<xacro:wheel n=\"1\"/>")},
              {"/r/parts/wheel.xacro",
               robot("<xacro:include filename=\"tyre.xacro\"/>"
                     "<xacro:macro name=\"wheel\" params=\"n\"><xacro:tyre n=\"${n}\"/></xacro:macro>")},
              {"/r/parts/tyre.xacro", robot("<xacro:macro name=\"tyre\" params=\"n\"><t n=\"${n}\"/></xacro:macro>")}});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_EQ(compact(result->urdf), "<robot name=\"r\"><t n=\"1\"/></robot>");
}

TEST(Xacro, makes_elements_and_attributes_by_name) {
  EXPECT_EQ(made("<xacro:element xacro:name=\"${'li' + 'nk'}\" a=\"1\"><xacro:attribute name=\"b\" "
                 "value=\"${1+1}\"/></xacro:element>"),
            "<link a=\"1\" b=\"2\"/>");
}

TEST(Xacro, tells_mistakes_with_their_line_and_the_way_there) {
  const std::pair<std::string, std::string> cases[]{
      {"<a v=\"${widht}\"/><xacro:property name=\"width\" value=\"1\"/>",
       "/r/robot.xacro:2: ${widht}: there is no property 'widht'; "},
      {"<xacro:property name=\"width\" value=\"1\"/>\n<a v=\"${widht}\"/>",
       "/r/robot.xacro:3: ${widht}: there is no property 'widht'; did you mean 'width'?"},
      {"<xacro:whel/>", "/r/robot.xacro:2: there is no macro 'whel'"},
      {"<xacro:macro name=\"m\" params=\"a\">\n<b v=\"${a/0}\"/></xacro:macro>\n\n<xacro:m a=\"1\"/>",
       "/r/robot.xacro:3: ${a/0}: division by zero\n  in macro 'm', called at /r/robot.xacro:5"},
      {"<xacro:macro name=\"m\" params=\"a\"/><xacro:m/>", "/r/robot.xacro:2: the macro 'm' needs the parameter 'a'"},
      {"<xacro:macro name=\"m\" params=\"a\"/><xacro:m zz=\"1\"/>",
       "/r/robot.xacro:2: the macro 'm' has no parameter 'zz'; the only"},
      {"<xacro:macro name=\"m\" params=\"*o\"/><xacro:m/>",
       "/r/robot.xacro:2: the macro 'm' needs the block 'o'; put an element into its call"},
      {"<xacro:if value=\"maybe\"/>",
       "/r/robot.xacro:2: value=\"maybe\" is neither true nor false: 'maybe'; write true, false, a number or a "
       "comparison"},
      {"<a v=\"$(arg x)\"/>", "/r/robot.xacro:2: there is no argument 'x'"},
      {"<xacro:arg name=\"x\"/><a v=\"$(arg x)\"/>",
       "/r/robot.xacro:2: the argument 'x' has no value; give it as x:=value"},
      {"<a v=\"$(evn X)\"/>", "/r/robot.xacro:2: unknown substitution $(evn); did you mean 'env'?"},
      {"<a v=\"${1\"/>", "/r/robot.xacro:2: '${1' lacks its '}'"},
      {"<xacro:include filename=\"none.xacro\"/>", "/r/robot.xacro:2: /r/none.xacro: cannot be read"},
      {"<xacro:include filename=\"robot.xacro\"/>", "/r/robot.xacro:2: the files include each other: '/r/robot.xacro'"},
      {"<xacro:property name=\"a\" value=\"${b}\"/><xacro:property name=\"b\" value=\"${a}\"/><x v=\"${a}\"/>",
       "/r/robot.xacro:2: ${a}: the property 'a' is made of itself"},
      {"<a>", "/r/robot.xacro:2: the element <a> that begins here is not closed"},
  };
  for (const auto& [body, expected] : cases) EXPECT_EQ(made(body).substr(0, expected.size()), expected) << body;
}

TEST(Xacro, ends_for_files_that_would_not) {
  EXPECT_NE(made("<xacro:macro name=\"m\" params=\"\"><xacro:m/></xacro:macro><xacro:m/>").find("nested too deeply"),
            std::string::npos);
  std::string doubling = "<xacro:property name=\"p0\" value=\"\"/>";
  const auto property = [](const std::string& name, const std::string& before) {
    return "<xacro:property name=\"" + name + "\" value=\"${" + before + "}${" + before + "}\"/>";
  };
  for (int i = 1; i < 50; ++i) doubling += property("p" + std::to_string(i), "p" + std::to_string(i - 1));
  EXPECT_NE(made(doubling + "<a v=\"${p49}\"/>").find("more than a million times"), std::string::npos);
  std::string bomb = "<xacro:macro name=\"m0\" params=\"\"><a/></xacro:macro>";
  const auto macro = [](const std::string& name, const std::string& before) {
    return "<xacro:macro name=\"" + name + "\" params=\"\"><xacro:" + before + "/><xacro:" + before +
           "/></xacro:macro>";
  };
  for (int i = 1; i < 30; ++i) bomb += macro("m" + std::to_string(i), "m" + std::to_string(i - 1));
  EXPECT_NE(made(bomb + "<xacro:m29/>").find("200000"), std::string::npos);
}

TEST(Xacro, lets_recursion_end_where_a_condition_says_so) {
  EXPECT_EQ(made("<xacro:macro name=\"count\" params=\"n\"><xacro:if value=\"${n > 0}\"><i n=\"${n}\"/>"
                 "<xacro:count n=\"${n-1}\"/></xacro:if></xacro:macro><xacro:count n=\"3\"/>"),
            "<i n=\"3\"/><i n=\"2\"/><i n=\"1\"/>");
}

TEST(Xacro, reports_unavailable_features_with_their_line) {
  EXPECT_EQ(made("<xacro:property name=\"cfg\" value=\"${xacro.load_yaml('a.yaml')}\"/>"),
            "/r/robot.xacro:2: property 'cfg': load_yaml is not available; write its values as properties");
  EXPECT_EQ(made("<xacro:include filename=\"package://arm/urdf/a.xacro\"/>"),
            "/r/robot.xacro:2: 'package://arm/urdf/a.xacro' is an address for meshes; an include takes a path; write "
            "$(find arm)/urdf/a.xacro");
  EXPECT_EQ(made("<xacro:include filename=\"$(find pk)/a.xacro\"/>"),
            "/r/robot.xacro:2: there is no package 'pk'; it is looked for as share/pk below the folders of "
            "NACELLE_PREFIX_PATH and AMENT_PREFIX_PATH; $(dirname) is the folder of the file itself");
}

TEST(XacroMachine, finds_packages_of_an_installed_ros) {
  const auto folder = std::filesystem::temp_directory_path() / ("nacelle_xacro_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder / "share/arm_description");
  ::setenv("AMENT_PREFIX_PATH", ("/no/such/prefix:" + folder.string()).c_str(), 1);
  const auto environment = machine({});
  ::unsetenv("AMENT_PREFIX_PATH");
  EXPECT_EQ(environment.find_package("arm_description"), (folder / "share/arm_description").string());
  EXPECT_EQ(environment.find_package("leg_description"), "");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace nacelle::description
