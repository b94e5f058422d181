// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/load_plan.hpp"

#include <gtest/gtest.h>

#include "in_memory.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle::launch {
namespace {

Plan plan_of(const std::string& text, const std::map<std::string, std::string>& arguments = {},
             std::map<std::string, std::string> files = {}, std::map<std::string, std::string> variables = {}) {
  auto plan = load_plan_text(text, "/l/a.launch.yaml", arguments, in_memory(std::move(files), std::move(variables)));
  EXPECT_TRUE(plan) << problems_of(plan);
  return plan ? std::move(*plan) : Plan{};
}

const char* const kWhole = R"yaml(
launch:
- arg: {name: port, default: /dev/ttyUSB0, description: "the LiDAR's line"}
- arg: {name: rate, default: '10'}
- let: {name: both, value: "$(var port)@$(var rate)"}
- node_container:
    pkg: rclcpp_components
    exec: component_container
    name: robot
    namespace: ''
    composable_node:
    - pkg: nacelle_lidar
      plugin: nacelle::lidar::LidarComponent
      name: lidar
      namespace: front
      param:
      - {name: port_name, value: $(var port)}
      - {name: rate, value: "$(var rate)"}
      - {name: note, value: '12'}
      - {name: both, value: $(var both)}
      - {name: angles, value: [1.0, 2.5]}
      - name: filter
        param:
        - {name: range.max, value: 12.0}
        - {name: enabled, value: on}
      remap:
      - {from: scan, to: /scan}
      - {from: "rosservice://~/reset", to: reset}
      extra_arg:
      - {name: use_intra_process_comms, value: 'true'}
      qos:
        /scan: {publisher: {profile: sensor_data, depth: 2, deadline: 150ms}}
        ~/state: {subscription: {reliability: reliable}}
      after:
      - {node: /base, when: active, timeout: 2.5s}
      thread: {mode: own, priority: 20, cpus: [2, 3], threads: 4}
      required: false
      autostart: inactive
    - {pkg: nacelle_base_driver, plugin: a::B, name: base}
- node: {pkg: robot_pkg, exec: talker, name: talker, args: "--words 'a b' $(var rate)", param: [{name: x, value: 1}], output: screen}
- executable: {cmd: "echo 'hello world' $(var port)", cwd: work, env: [{name: A, value: b}]}
- log: {message: "starting at $(var port)"}
)yaml";

TEST(LoadPlan, turns_a_whole_file_into_typed_values) {
  const Plan plan = plan_of(kWhole, {{"rate", "20"}});

  ASSERT_EQ(plan.components.size(), 2U);
  const ComponentPlan& lidar = plan.components[0];
  EXPECT_EQ(lidar.full_name(), "/front/lidar");
  EXPECT_EQ(lidar.plugin, "nacelle::lidar::LidarComponent");
  EXPECT_EQ(lidar.where.text(), "/l/a.launch.yaml:12");
  ASSERT_EQ(lidar.parameters.size(), 7U);
  EXPECT_EQ(lidar.parameters[0], (Parameter{"port_name", std::string("/dev/ttyUSB0"), {"/l/a.launch.yaml", 17}}));
  EXPECT_EQ(lidar.parameters[1].value, ParameterValue(std::int64_t{20}));
  EXPECT_EQ(lidar.parameters[2].value, ParameterValue(std::string("12")));
  EXPECT_EQ(lidar.parameters[3].value, ParameterValue(std::string("/dev/ttyUSB0@20")));
  EXPECT_EQ(lidar.parameters[4].value, ParameterValue(std::vector<double>{1.0, 2.5}));
  EXPECT_EQ(lidar.parameters[5].name, "filter.range.max");
  EXPECT_EQ(lidar.parameters[6].value, ParameterValue(true));
  EXPECT_EQ(lidar.remaps[1], (RemapRule{RemapKind::Service, "", "~/reset", "reset"}));
  EXPECT_EQ(lidar.extra_arguments[0].value, ParameterValue(true));
  EXPECT_EQ(lidar.qos_for("/scan", Side::Publisher, QoS(10)), QoS(2).best_effort().deadline(150ms));
  EXPECT_EQ(lidar.qos_for("/scan", Side::Subscription, QoS(10)), QoS(10));
  EXPECT_EQ(lidar.qos[1].topic, "/front/lidar/state");
  ASSERT_EQ(lidar.after.size(), 1U);
  EXPECT_EQ(lidar.after[0].node, "/base");
  EXPECT_EQ(lidar.after[0].timeout, Duration{2500ms});
  EXPECT_EQ(lidar.thread, (ThreadPolicy{.own = true, .priority = 20, .cpus = {2, 3}, .threads = 4}));
  EXPECT_FALSE(lidar.required);
  EXPECT_EQ(lidar.target, TargetState::Inactive);
  EXPECT_TRUE(plan.components[1].required);
  EXPECT_EQ(plan.components[1].target, TargetState::Active);

  ASSERT_EQ(plan.programs.size(), 2U);
  EXPECT_EQ(plan.programs[0].command_arguments(),
            (std::vector<std::string>{"--words", "a b", "20", "--ros-args", "-r", "__node:=talker", "-p", "x:=1"}));
  EXPECT_EQ(plan.programs[1].executable, "echo");
  EXPECT_EQ(plan.programs[1].arguments, (std::vector<std::string>{"hello world", "/dev/ttyUSB0"}));
  EXPECT_EQ(plan.programs[1].working_directory, "/l/work");
  EXPECT_EQ(plan.messages[0].text, "starting at /dev/ttyUSB0");
  EXPECT_EQ(plan.arguments[0].description, "the LiDAR's line");
  EXPECT_EQ(plan.find("/base"), &plan.components[1]);
}

const char* const kXmlTwin = R"xml(<!-- the same in XML -->
<launch>
  <arg name="port" default="/dev/ttyUSB0" description="the LiDAR's line"/>
  <arg name="rate" default="10"/>
  <let name="both" value="$(var port)@$(var rate)"/>
  <node_container pkg="rclcpp_components" exec="component_container" name="robot" namespace="">
    <composable_node pkg="nacelle_lidar" plugin="nacelle::lidar::LidarComponent" name="lidar" namespace="front"
                     required="false" autostart="inactive">
      <param name="port_name" value="$(var port)"/>
      <param name="rate" value="$(var rate)"/>
      <param name="note" value="12" type="str"/>
      <param name="both" value="$(var both)"/>
      <param name="angles" value="[1.0, 2.5]"/>
      <param name="filter"><param name="range.max" value="12.0"/><param name="enabled" value="on"/></param>
      <remap from="scan" to="/scan"/>
      <remap from="rosservice://~/reset" to="reset"/>
      <extra_arg name="use_intra_process_comms" value="true"/>
      <qos topic="/scan"><publisher profile="sensor_data" depth="2" deadline="150ms"/></qos>
      <qos topic="~/state"><subscription reliability="reliable"/></qos>
      <after node="/base" when="active" timeout="2.5s"/>
      <thread mode="own" priority="20" cpus="2 3" threads="4"/>
    </composable_node>
    <composable_node pkg="nacelle_base_driver" plugin="a::B" name="base"/>
  </node_container>
  <node pkg="robot_pkg" exec="talker" name="talker" args="--words 'a b' $(var rate)" output="screen"><param name="x" value="1"/></node>
  <executable cmd="echo 'hello world' $(var port)" cwd="work"><env name="A" value="b"/></executable>
  <log message="starting at $(var port)"/>
</launch>)xml";

TEST(LoadPlan, makes_the_same_plan_of_xml_and_yaml) {
  const auto xml = load_plan_text(kXmlTwin, "/l/a.launch.xml", {}, in_memory({}));
  ASSERT_TRUE(xml) << problems_of(xml);
  EXPECT_EQ(to_text(*xml), to_text(plan_of(kWhole)));
  EXPECT_EQ(xml->components[0].where.line, 7);
}

TEST(LoadPlan, gives_the_same_plan_every_time) { EXPECT_EQ(to_text(plan_of(kWhole)), to_text(plan_of(kWhole))); }

TEST(LoadPlan, scopes_variables_and_namespaces_by_group) {
  const Plan plan = plan_of(R"yaml(
launch:
- let: {name: x, value: outer}
- group:
  - push_ros_namespace: {namespace: left}
  - let: {name: x, value: inner}
  - set_remap: {from: scan, to: /all_scans}
  - set_parameter: {name: speed, value: 0.5}
  - group:
    - push-ros-namespace: {namespace: arm}
    - load_composable_node:
        target: robot
        composable_node: [{pkg: p, plugin: a::A, name: one, param: [{name: x, value: $(var x)}, {name: speed, value: 0.7}]}]
  - load_composable_node: {target: /robot, composable_node: [{pkg: p, plugin: a::A, name: two, namespace: /abs}]}
- group:
    scoped: false
    children:
    - let: {name: x, value: leaked}
- node_container:
    name: robot
    composable_node: [{pkg: p, plugin: a::A, name: three, param: [{name: x, value: $(var x)}]}]
)yaml");
  EXPECT_EQ(plan.components[0].full_name(), "/left/arm/one");
  EXPECT_EQ(plan.components[0].parameters[0].value, ParameterValue(0.7));
  EXPECT_EQ(plan.components[0].parameters[1].value, ParameterValue(std::string("inner")));
  EXPECT_EQ(plan.components[0].remaps.size(), 1U);
  EXPECT_EQ(plan.components[1].full_name(), "/abs/two");
  EXPECT_EQ(plan.components[1].parameters[0].value, ParameterValue(0.5));
  EXPECT_EQ(plan.components[2].full_name(), "/three");
  EXPECT_EQ(plan.components[2].parameters[0].value, ParameterValue(std::string("leaked")));
}

TEST(LoadArguments, lists_what_is_required_without_its_value) {
  const std::string text = R"yaml(
launch:
- arg: {name: who, description: "whom to start"}
- arg: {name: port, default: p0}
- node_container:
    name: robot
    composable_node:
    - {pkg: p, plugin: a::A, name: $(var who), after: [$(var who)], param: [{name: x, value: $(var who)}]}
)yaml";
  const auto environment = in_memory({{"a.launch.yaml", text}});
  const auto plan = load_arguments("a.launch.yaml", {}, environment);
  ASSERT_TRUE(plan) << problems_of(plan);
  ASSERT_EQ(plan->arguments.size(), 2U);
  EXPECT_EQ(plan->arguments[0].name, "who");
  EXPECT_FALSE(plan->arguments[0].default_value);
  EXPECT_FALSE(load_plan("a.launch.yaml", {}, environment));
}

TEST(LoadPlan, follows_conditions) {
  const std::string text = R"yaml(
launch:
- arg: {name: sim, default: 'true'}
- node: {exec: world, if: $(var sim)}
- node: {exec: real, unless: $(var sim)}
- node: {exec: both, if: $(and $(var sim) $(not $(equals $(env MODE none) fast)))}
- node_container:
    name: robot
    composable_node:
    - {pkg: p, plugin: a::A, name: one, unless: $(var sim)}
)yaml";
  const Plan sim = plan_of(text);
  ASSERT_EQ(sim.programs.size(), 2U);
  EXPECT_EQ(sim.programs[1].executable, "both");
  EXPECT_TRUE(sim.components.empty());
  EXPECT_EQ(plan_of(text, {}, {}, {{"MODE", "fast"}}).programs.size(), 1U);
  const Plan real = plan_of(text, {{"sim", "False"}});
  EXPECT_EQ(real.programs[0].executable, "real");
  EXPECT_EQ(real.components.size(), 1U);
}

TEST(LoadPlan, includes_files_beside_its_own_with_arguments) {
  const Plan plan = plan_of(
      "launch:\n- arg: {name: port, default: p0}\n"
      "- include: {file: sub/b.launch.xml, arg: [{name: who, value: lidar}]}\n"
      "- log: {message: '$(var extra)'}\n",
      {},
      {{"/l/sub/b.launch.xml",
        "<launch><arg name='who'/><arg name='port' default='unused'/>"
        "<let name='extra' value='$(dirname) $(filename)'/>"
        "<log message='$(var who) $(var port) $(find-pkg-share robot_pkg)'/></launch>"}});
  EXPECT_EQ(plan.messages[0].text, "lidar p0 /share/robot_pkg");
  EXPECT_EQ(plan.messages[1].text, "/l/sub /l/sub/b.launch.xml") << "an include is not a scope, as in ROS 2";
  EXPECT_EQ(plan.arguments.size(), 2U);
}

TEST(LoadPlan, lets_the_later_parameter_win_and_remembers_its_origin) {
  const std::map<std::string, std::string> files{{"/l/p.yaml",
                                                  "/**:\n  ros__parameters:\n    rate: 5\n    only: true\nlidar:\n  "
                                                  "ros__parameters: {rate: 7, port: $(var port)}\n"},
                                                 {"/l/q.yaml", "nobody:\n  ros__parameters: {x: 1}\n"}};
  const Plan plan = plan_of(
      "launch:\n- arg: {name: port, default: '3'}\n- node_container:\n    name: robot\n    composable_node:\n"
      "    - pkg: p\n      plugin: a::A\n      name: lidar\n      param:\n      - {name: rate, value: 1}\n"
      "      - {from: p.yaml, allow_substs: true}\n      - {from: q.yaml}\n      - {name: only, value: false}\n",
      {}, files);
  const auto& p = plan.components[0].parameters;
  ASSERT_EQ(p.size(), 3U);
  EXPECT_EQ(p[0], (Parameter{"rate", std::int64_t{7}, {"/l/p.yaml", 6}}));
  EXPECT_EQ(p[1].value, ParameterValue(false));
  EXPECT_EQ(p[2], (Parameter{"port", std::int64_t{3}, {"/l/p.yaml", 6}}));
  ASSERT_EQ(plan.unused_sections.size(), 1U);
  EXPECT_EQ(plan.unused_sections[0].pattern, "/nobody");
  EXPECT_EQ(plan.unused_sections[0].where.text(), "/l/q.yaml:2");
}

TEST(LoadPlan, finds_the_nodes_of_after_beside_the_component_first) {
  const Plan plan = plan_of(with_components(
      "    - {pkg: p, plugin: a::A, name: base}\n    - {pkg: p, plugin: a::A, name: base, namespace: left}\n"
      "    - {pkg: p, plugin: a::A, name: odom, namespace: left, after: [base]}\n"
      "    - {pkg: p, plugin: a::A, name: ekf, namespace: right, after: [{node: base}]}\n"));
  EXPECT_EQ(plan.components[2].after[0].node, "/left/base");
  EXPECT_EQ(plan.components[3].after[0].node, "/base");
}

TEST(LoadPlan, gives_programs_the_environment_of_their_scope) {
  const Plan plan = plan_of(
      "launch:\n- set_env: {name: A, value: one}\n- unset_env: {name: B}\n"
      "- executable: {cmd: run, env: [{name: C, value: '$(env A)'}]}\n");
  using Entry = std::pair<std::string, std::optional<std::string>>;
  EXPECT_EQ(plan.programs[0].environment, (std::vector<Entry>{{"A", "one"}, {"B", std::nullopt}, {"C", "one"}}));
}

TEST(LoadPlan, passes_parameter_files_to_programs_as_files) {
  const Plan plan =
      plan_of("launch:\n- node: {pkg: robot_pkg, exec: t, param: [{from: p.yaml}, {name: a, value: '5'}]}\n", {},
              {{"/l/p.yaml", "/**: {ros__parameters: {x: 1}}"}});
  EXPECT_EQ(plan.programs[0].command_arguments(),
            (std::vector<std::string>{"--ros-args", "--params-file", "/l/p.yaml", "-p", "a:=\"5\""}));
  EXPECT_TRUE(plan.unused_sections.empty());
}

TEST(Arguments, are_split_at_the_first_assignment) {
  const auto good = parse_arguments({"a:=b", "c:=", "d:=e:=f"});
  ASSERT_TRUE(good);
  EXPECT_EQ(good->at("c"), "");
  EXPECT_EQ(good->at("d"), "e:=f");
  EXPECT_FALSE(parse_arguments({"a=b"}));
  EXPECT_FALSE(parse_arguments({":=b"}));
}

TEST(LoadPlan, the_folder_of_a_relative_launch_file_stands_in_other_paths) {
  auto environment = in_memory({{"/ws/dir/robot.yaml", "/**: {ros__parameters: {rate: 30}}"}});
  environment.working_directory = "/ws";
  const auto plan = load_plan_text(
      "launch:\n- node_container:\n    pkg: nacelle\n    exec: container\n    name: c\n    namespace: ''\n"
      "    composable_node:\n    - {pkg: nacelle, plugin: 'a::B', name: b, param: [{from: $(dirname)/robot.yaml}]}\n",
      "dir/f.launch.yaml", {}, environment);
  ASSERT_TRUE(plan) << problems_of(plan);
}

}  // namespace
}  // namespace nacelle::launch
