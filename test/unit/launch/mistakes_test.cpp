// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "in_memory.hpp"

namespace nacelle::launch {
namespace {

std::string told(const std::string& text, const std::map<std::string, std::string>& arguments = {},
                 std::map<std::string, std::string> files = {}) {
  return problems_of(load_plan_text(text, "a.launch.yaml", arguments, in_memory(std::move(files))));
}

// What one line of a composable node makes the parser say.
std::string told_of(const std::string& line) {
  return told(with_components("    - pkg: p\n      plugin: a::A\n      name: one\n      " + line +
                              "\n    - {pkg: p, plugin: a::A, name: two}\n"));
}

struct Mistake {
  const char* text;
  const char* told;
};

TEST(Mistakes, of_a_files_shape_are_reported_with_their_line) {
  const Mistake cases[]{
      {"lunch: []", "a.launch.yaml:1: unknown key 'lunch'; did you mean 'launch'?\n"},
      {"- node: {}", "a.launch.yaml:1: expected the key 'launch' with a list of actions, found a list\n"},
      {"launch: {node: {}}", "a.launch.yaml:1: 'launch' needs a list of actions, not a map\n"},
      {"launch:\n- nod: {exec: a}", "a.launch.yaml:2: unknown action 'nod' in 'launch'; did you mean 'node'?\n"},
      {"launch:\n- node: {exec: a}\n  name: b",
       "a.launch.yaml:2: expected one action, such as '- node: {...}', found a map with 2 keys; indent the keys of an "
       "action below its name\n"},
      {"launch:\n- node: text", "a.launch.yaml:2: 'node' needs a map, not text\n"},
      {"launch:\n- node: {pkg: x}", "a.launch.yaml:2: 'node' needs the key 'exec'\n"},
      {"launch:\n- node: {exec: a, exec: b}",
       "a.launch.yaml:2: the key 'exec' stands here a second time; the first is at line 2\n"},
      {"launch:\n- node: {exec: [a]}", "a.launch.yaml:2: 'exec' needs one value, not a list\n"},
      {"launch:\n- node: {exec: {a: b}}",
       "a.launch.yaml:2: 'node' needs the key 'exec'\na.launch.yaml:2: 'exec' in 'node' needs a value, not a map\n"},
      {"launch:\n- node: {exec: a, param: b}",
       "a.launch.yaml:2: 'param' in 'node' needs a map or a list of maps, not text\n"},
      {"launch:\n- node: {exec: a, name: }", "a.launch.yaml:2: 'name' has no value; write '' for an empty text\n"},
      {"launch:\n- node: {exec: a, if: 'true', unless: 'true'}",
       "a.launch.yaml:2: 'node' has both 'if' and 'unless'; use one of them with $(and) or $(not)\n"},
      {"launch:\n- node: {exec: a, if: maybe}", "a.launch.yaml:2: 'if' must be true or false, not 'maybe'\n"},
      {"launch:\n- node: {exec: a, output: scren}",
       "a.launch.yaml:2: 'output' cannot be 'scren'; did you mean 'screen'?\n"},
      {"launch:\n- node: {exec: a, name: 1x}", "a.launch.yaml:2: the node name '1x' must not start with a digit\n"},
      {"launch:\n- executable: {cmd: ''}", "a.launch.yaml:2: 'cmd' names no program\n"},
      {"launch:\n- executable: {cmd: \"a 'b\"}",
       "a.launch.yaml:2: the quote ' does not end\na.launch.yaml:2: 'cmd' names no program\n"},
      {"launch:\n- push_ros_namespace: {namespace: a-b}",
       "a.launch.yaml:2: the namespace '/a-b' may hold only letters, digits, '_' and '/'\n"},
      {"launch:\n- set_remap: {from: 'a b', to: c}",
       "a.launch.yaml:2: the topic or service name 'a b' may hold only letters, digits, '_', '/', a leading '~' and "
       "{node}, {ns}, {namespace}\n"},
      {"launch:\n- node: {exec: a, param: [{name: x, value: 1}, {nmae: y, value: 2}]}",
       "a.launch.yaml:2: unknown key 'nmae' in 'param'; did you mean 'name'?\na.launch.yaml:2: a 'param' needs 'name' "
       "or 'from'\n"},
      {"launch:\n- node: {exec: a, param: [{name: x, from: b}]}",
       "a.launch.yaml:2: a 'param' has either 'from' or 'name', not both\n"},
      {"launch:\n- node: {exec: a, param: [{name: x}]}",
       "a.launch.yaml:2: a 'param' needs either 'value' or nested 'param'\n"},
      {"launch:\n- node: {exec: a, param: [{name: x, value: [1, 2.5]}]}",
       "a.launch.yaml:2: the list mixes int and double ('2.5'); write all of them as one type, such as 1.0 instead of "
       "1\n"},
      {"launch:\n- node: {exec: a, param: [{name: x, value: a, type: int}]}",
       "a.launch.yaml:2: 'a' is not of the type int\n"},
      {"launch:\n- node: {exec: a, param: [{name: x, value: a, type: integer}]}",
       "a.launch.yaml:2: 'integer' is not a type of parameters; one of bool, int, float, str, list_of_bool, "
       "list_of_int, list_of_float, list_of_str\n"},
      {"launch:\n- node: {exec: a, param: [{from: missing.yaml}]}",
       "a.launch.yaml:2: the parameter file 'missing.yaml' cannot be read\n"},
      {"launch:\n- node: {exec: a, param: [{from: missing.yaml}]}\n"
       "- node: {exec: b, param: [{from: missing.yaml, allow_substs: true}, {from: other.yaml}]}",
       "a.launch.yaml:2: the parameter file 'missing.yaml' cannot be read\n"
       "a.launch.yaml:3: the parameter file 'other.yaml' cannot be read\n"},
      {"launch:\n- include: {file: b.launch.yaml}",
       "a.launch.yaml:2: the launch file 'b.launch.yaml' cannot be read\n"},
      {"launch:\n- shutdown: {reason: x}",
       "a.launch.yaml:2: 'shutdown' is refused: a launch file describes what runs, it does not stop it; use `nacelle "
       "component unload` or Ctrl-C\n"},
      {"launch: [a: &x {b: 1}]",
       "a.launch.yaml:1: anchors and aliases are not supported; write the value where it is used\n"},
      {"launch:\n- node: {exec: a, shell: true, respawn: true}",
       "a.launch.yaml:2: 'shell' is refused: a shell between the container and the program hides the program from it; "
       "start a script instead\n"
       "a.launch.yaml:2: respawn: true is not available yet: a program that ends stays ended; leave it out\n"},
  };
  for (const auto& mistake : cases) EXPECT_EQ(told(mistake.text), mistake.told) << mistake.text;
}

TEST(Mistakes, of_a_component_are_reported_with_their_line) {
  const Mistake cases[]{
      {"plugn: x", "a.launch.yaml:8: unknown key 'plugn' in 'composable_node'; did you mean 'plugin'?\n"},
      {"after: [tow]",
       "a.launch.yaml:8: 'after' names the node 'tow', which is not a component of this launch; did you mean 'two'?\n"},
      {"after: [one]", "a.launch.yaml:8: the node 'one' cannot wait for itself\n"},
      {"after: [{node: two, when: activ}]", "a.launch.yaml:8: 'when' cannot be 'activ'; did you mean 'active'?\n"},
      {"after: [{node: two, timeout: soon}]",
       "a.launch.yaml:8: 'soon' is not a duration; write a number and its unit, such as 100ms or 1.5s, or infinite\n"},
      {"after: [{when: active}]", "a.launch.yaml:8: 'after' needs the key 'node'\n"},
      {"thread: {mode: onw}", "a.launch.yaml:8: 'mode' cannot be 'onw'; did you mean 'own'?\n"},
      {"thread: {mode: own, priority: 100}",
       "a.launch.yaml:8: 'priority' must be a whole number from 0 to 99, not '100'\n"},
      {"thread: {mode: own, cpus: [a]}", "a.launch.yaml:8: 'cpus' must be numbers from 0 to 1023, not 'a'\n"},
      {"thread: {mode: own, threads: 0}",
       "a.launch.yaml:8: 'threads' must be from 1 to 64; leave it out for one thread\n"},
      {"thread: {priority: 5}",
       "a.launch.yaml:8: priority, cpus and threads belong to a thread of one's own; write mode: own, or leave them "
       "out\n"},
      {"required: maybe", "a.launch.yaml:8: 'required' must be true or false, not 'maybe'\n"},
      {"autostart: on",
       "a.launch.yaml:8: 'autostart' cannot be 'on'; one of unconfigured, inactive, active, false, true\n"},
      {"qos: {/x: {publisher: {relability: reliable}}}",
       "a.launch.yaml:8: unknown key 'relability' in 'publisher'; did you mean 'reliability'?\n"},
      {"qos: {/x: {publisher: {reliability: relable}}}",
       "a.launch.yaml:8: 'relable' is not a reliability; did you mean 'reliable'?\n"},
      {"qos: {/x: {publisher: {profile: sensor}}}",
       "a.launch.yaml:8: no QoS profile has the name 'sensor'; did you mean 'sensor_data'?\n"},
      {"qos: {/x: {publishr: {depth: 1}}}",
       "a.launch.yaml:8: unknown key 'publishr' in 'qos'; did you mean 'publisher'?\n"},
      {"qos: {/x: reliable}", "a.launch.yaml:8: '/x' below 'qos' needs a map, not text\n"},
      {"qos: {x-y: {publisher: {depth: 1}}}",
       "a.launch.yaml:8: the topic or service name 'x-y' may hold only letters, digits, '_', '/', a leading '~' and "
       "{node}, {ns}, {namespace}\n"},
      {"isolate: proces", "a.launch.yaml:8: 'isolate' cannot be 'proces'; did you mean 'process'?\n"},
      {"budget: {min_hz: -1}", "a.launch.yaml:8: 'min_hz' must be a number above 0, not '-1'\n"},
      {"on_fault: {degrade: {max: 3}}",
       "a.launch.yaml:8: unknown key 'degrade' in 'on_fault'; one of policy, max, backoff, restart\n"},
      {"on_fault: {policy: degrade, max: 3}", "a.launch.yaml:8: 'max' and 'backoff' belong to the policy restart\n"},
      {"resume: activ", "a.launch.yaml:8: 'resume' cannot be 'activ'; did you mean 'active'?\n"},
      {"on_fault: stop", "a.launch.yaml:8: 'on_fault' cannot be 'stop'; did you mean 'stop_robot'?\n"},
      {"after: [{node: two, when: first_message}]",
       "a.launch.yaml:8: 'first_message' needs a name; write first_message(/name)\n"},
      {"after: [{node: two, when: service(x-y)}]",
       "a.launch.yaml:8: the topic or service name 'x-y' may hold only letters, digits, '_', '/', a leading '~' and "
       "{node}, {ns}, {namespace}\n"},
      {"after: [{node: two, when: tf(odom)}]",
       "a.launch.yaml:8: 'tf' needs two frames, not 'odom'; write tf(odom->base_link)\n"},
      {"after: [{node: two, when: active(now)}]",
       "a.launch.yaml:8: 'active' takes nothing in parentheses, not 'now'\n"},
  };
  for (const auto& mistake : cases) EXPECT_EQ(told_of(mistake.text), mistake.told) << mistake.text;
  EXPECT_EQ(told_of("isolate: none"), "ok");
  EXPECT_EQ(told_of("on_fault: restart_container"), "ok");
  EXPECT_EQ(told_of("isolate: process"), "ok");
}

TEST(Mistakes, of_substitutions_are_reported_even_if_a_condition_is_false) {
  const Mistake cases[]{
      {"$(vra x)", "unknown substitution $(vra); did you mean 'var'?\n"},
      {"$(var x", "'$(var x' lacks its ')'; write \\$( for the characters themselves\n"},
      {"$(var a b)", "$(var) has 2 arguments; it takes 1; put quotes around a text with spaces\n"},
      {"$(eval 1 + (2))",
       "$(eval) is refused: it runs Python, which Nacelle does not have; use $(not), $(and), $(or), $(equals) or an "
       "argument\n"},
      {"$(command 'ls')",
       "$(command) is refused: it runs a program while the file is read, so that a check could change the robot; give "
       "the value as an argument\n"},
  };
  for (const auto& mistake : cases) {
    for (const char* condition : {"'true'", "'false'"}) {
      const std::string file =
          std::string("launch:\n- log:\n    message: ") + mistake.text + "\n    if: " + condition + "\n";
      EXPECT_EQ(told(file), std::string("a.launch.yaml:3: ") + mistake.told) << file;
    }
  }
  EXPECT_EQ(told("launch:\n- arg: {name: port, default: x}\n- log: {message: $(var prot)}"),
            "a.launch.yaml:3: no argument or variable has the name 'prot'; did you mean 'port'?\n");
  EXPECT_EQ(
      told("launch:\n- log: {message: $(env HOME)}"),
      "a.launch.yaml:2: the environment variable 'HOME' is not set; set it, or write a default: $(env HOME default)\n");
  EXPECT_EQ(told("launch:\n- log: {message: $(find-pkg-share robt_pkg)}"),
            "a.launch.yaml:2: no package has the name 'robt_pkg'; did you mean 'robot_pkg'?\n");
  EXPECT_EQ(told("launch:\n- log: {message: $(not perhaps)}"),
            "a.launch.yaml:2: $(not) needs true or false, not 'perhaps'\n");
}

TEST(Mistakes, a_package_that_is_nowhere_has_a_way_out) {
  EXPECT_EQ(told("launch:\n- log: {message: $(find-pkg-share slam_toolbox)}"),
            "a.launch.yaml:2: no package has the name 'slam_toolbox'; install it, or add the prefix that holds "
            "share/slam_toolbox to NACELLE_PREFIX_PATH\n");
}

TEST(Mistakes, an_equivalent_choice_is_accepted_and_a_wrong_one_reported_once) {
  const std::string file =
      "launch:\n- arg: {name: sim, default: 'true', choice: [{value: 'true'}, {value: 'false'}]}\n"
      "- let: {name: port, value: $(var sim), if: $(var sim)}\n- let: {name: port, value: real, unless: $(var sim)}\n"
      "- log: {message: '$(var port) $(var sim)'}\n";
  for (const char* const value : {"True", "TRUE", "1", "true", "False", "0"})
    EXPECT_EQ(told(file, {{"sim", value}}), "ok") << value;
  EXPECT_EQ(told(file, {{"sim", "yes"}}), "a.launch.yaml:2: the argument 'sim' cannot be 'yes'; one of true, false\n");
}

TEST(Mistakes, of_arguments_are_reported_once) {
  EXPECT_EQ(told("launch:\n- arg: {name: port}\n- log: {message: $(var port)}\n- log: {message: $(var port)}"),
            "a.launch.yaml:2: the argument 'port' has no value and no default; give it: port:=...\n");
  EXPECT_EQ(told("launch:\n- arg: {name: port, default: a}", {{"prt", "x"}}),
            "a.launch.yaml: the files declare no argument 'prt'; did you mean 'port'?\n");
  EXPECT_EQ(told("launch:\n- arg: {name: port, default: a}", {{"netwrk", "off"}}),
            "a.launch.yaml: the files declare no argument 'netwrk'; did you mean 'network'?\n");
  EXPECT_EQ(
      told("launch:\n- arg: {name: mode, default: fast, choice: [{value: slow}, {value: fast}]}", {{"mode", "quick"}}),
      "a.launch.yaml:2: the argument 'mode' cannot be 'quick'; one of slow, fast\n");
  EXPECT_EQ(told("launch:\n- include: {file: b.launch.yaml, arg: [{name: prot, value: x}]}", {},
                 {{"b.launch.yaml", "launch:\n- arg: {name: port, default: y}"}}),
            "a.launch.yaml:2: the file 'b.launch.yaml' declares no argument 'prot'; did you mean 'port'?\n");
}

TEST(Mistakes, across_files_are_reported_with_each_files_name) {
  EXPECT_EQ(
      told("launch:\n- include: {file: b.launch.yaml}", {},
           {{"b.launch.yaml", "launch:\n- include: {file: a.launch.yaml}"}}),
      "b.launch.yaml:2: the files include each other: a.launch.yaml -> a.launch.yaml; take one of the includes out\n");
  EXPECT_EQ(
      told("launch:\n- include: {file: b.launch.xml}", {}, {{"b.launch.xml", "<launch>\n  <nod/>\n  text\n</launch>"}}),
      "b.launch.xml:3: text inside <launch>; values are attributes\n");
  EXPECT_EQ(
      told("launch:\n- include: {file: b.launch.xml}", {}, {{"b.launch.xml", "<launch>\n  <nod exec='a'/></launch>"}}),
      "b.launch.xml:2: unknown action 'nod' in 'launch'; did you mean 'node'?\n");
  EXPECT_EQ(told("launch:\n- include: {file: b.launch.xml}", {},
                 {{"b.launch.xml", "<launch>\n  <group>\n    <node exec='a'/>\n</launch>"}}),
            "b.launch.xml:2: the element <group> that begins here is not closed by its own </...>; close it\n");
  EXPECT_EQ(
      told("launch:\n- include: {file: b.launch.py}", {}, {{"b.launch.py", "x"}}),
      "b.launch.py: a launch file in Python is a program, which Nacelle does not run; write the same in YAML or XML\n");
  EXPECT_EQ(
      told(with_components("    - {pkg: p, plugin: a::A, name: one, param: [{from: p.yaml}]}\n"), {},
           {{"p.yaml", "one:\n  rate: 5\n/**: {ros__parameters: {x: 1}}\n"}}),
      "p.yaml:2: 'rate' is a node or namespace and needs a map, not text; parameters stand below 'ros__parameters'\n");
}

TEST(Mistakes, a_parameter_file_of_ros_1_is_reported_once) {
  EXPECT_EQ(told(with_components("    - {pkg: p, plugin: a::A, name: one, param: [{from: p.yaml}]}\n"), {},
                 {{"p.yaml", "frequency: 30\ntwo_d_mode: true\none:\n  rate: 5\n"}}),
            "p.yaml:1: the file has no 'ros__parameters': it is of ROS 1's form, or no parameter file; write '<node>:' "
            "and below it 'ros__parameters:' above the values, or '/**:' for every node\n");
}

TEST(Mistakes, words_of_other_tools_are_known) {
  for (const char* const word : {"prams", "params", "parameters"}) {
    EXPECT_EQ(told_of(std::string{word} + ": [{name: a, value: 1}]"),
              "a.launch.yaml:8: unknown key '" + std::string{word} + "' in 'composable_node'; did you mean 'param'?\n");
  }
  const std::string all = told_of("zzzzzzzz: 1");
  for (const std::string word : {" after", " thread", " on_fault"})
    EXPECT_EQ(all.find(word), all.rfind(word)) << all;  // once, though they may be a value or a map
}

TEST(Mistakes, a_misspelt_variable_is_reported_once) {
  EXPECT_EQ(told("launch:\n- arg: {name: mode, default: fast}\n- node_container: {name: c, namespace: '', "
                 "composable_node: [{pkg: n, plugin: 'a::A', name: 'x_$(var mde)'}]}"),
            "a.launch.yaml:3: no argument or variable has the name 'mde'; did you mean 'mode'?\n");
}

TEST(Mistakes, a_component_is_not_renamed_by_a_remap) {
  EXPECT_EQ(told_of("remap: [{from: __node, to: other}]"),
            "a.launch.yaml:8: a remap of '__node' cannot rename a composable_node; write name: other\n");
  EXPECT_EQ(told_of("remap: [{from: __ns, to: /arm}]"),
            "a.launch.yaml:8: a remap of '__ns' cannot rename a composable_node; write namespace: /arm\n");
  EXPECT_EQ(told("launch:\n- set_remap: {from: __name, to: other}\n- node_container: {name: c, namespace: '', "
                 "composable_node: [{pkg: n, plugin: 'a::A', name: x}]}"),
            "a.launch.yaml:3: a remap of '__node' cannot rename a composable_node: the set_remap is at "
            "a.launch.yaml:2; write name: other\n");
}

TEST(Mistakes, of_a_whole_plan_are_reported) {
  EXPECT_EQ(told(with_components("    - {pkg: p, plugin: a::A, name: one}\n    - {pkg: p, plugin: a::A, name: one}\n")),
            "a.launch.yaml:6: a second node has the name '/one'; the first is at a.launch.yaml:5; give it another name "
            "or namespace\n");
  EXPECT_EQ(told("launch:\n- load_composable_node: {target: rob, composable_node: [{pkg: p, plugin: a::A, name: "
                 "one}]}\n- node_container: {name: robot}"),
            "a.launch.yaml:2: there is no container 'rob'; the only choice is robot\n");
  EXPECT_EQ(told("launch:\n- node_container: {name: a}\n- node_container: {name: b}"),
            "a.launch.yaml:3: a second node_container; the first is at a.launch.yaml:2; one process holds the whole "
            "robot: put these components into the first, or start a second `nacelle launch`\n");
  EXPECT_EQ(
      told(with_components("    - {pkg: p, plugin: a::A, name: one, after: [three]}\n    - {pkg: p, plugin: a::A, "
                           "name: two, after: [one]}\n    - {pkg: p, plugin: a::A, name: three, after: [two]}\n")),
      "a.launch.yaml:6: 'after' forms a cycle: one waits for three waits for two waits for one; take one of "
      "the conditions out\n");
}

TEST(Mistakes, every_cycle_is_reported_once) {
  EXPECT_EQ(told(with_components("    - {pkg: p, plugin: a::A, name: a, after: [b]}\n"
                                 "    - {pkg: p, plugin: a::A, name: b, after: [a]}\n"
                                 "    - {pkg: p, plugin: a::A, name: c, after: [d, a]}\n"
                                 "    - {pkg: p, plugin: a::A, name: d, after: [c]}\n"
                                 "    - {pkg: p, plugin: a::A, name: e, after: [d]}\n")),
            "a.launch.yaml:6: 'after' forms a cycle: a waits for b waits for a; take one of the conditions "
            "out\na.launch.yaml:8: 'after' forms a cycle: c waits for d waits for c; take one of the "
            "conditions out\n");
}

TEST(Mistakes, in_after_are_reported_with_the_name_that_works_there) {
  const auto file = [](const char* wanted) {
    return with_components(
        "    - {pkg: p, plugin: a::A, name: m2, namespace: /g}\n    - {pkg: p, plugin: a::A, name: "
        "base}\n    - {pkg: p, plugin: a::A, name: one, namespace: /h, after: [" +
        std::string(wanted) + "]}\n");
  };
  const std::string told_before = "a.launch.yaml:7: 'after' names the node '";
  EXPECT_EQ(told(file("m2")), told_before + "m2', which is not a component of this launch; did you mean '/g/m2'?\n");
  EXPECT_EQ(told(file("bsae")), told_before + "bsae', which is not a component of this launch; did you mean 'base'?\n");
  EXPECT_EQ(told(file("/g/m3")),
            told_before + "/g/m3', which is not a component of this launch; did you mean '/g/m2'?\n");
}

TEST(Mistakes, of_one_file_are_all_reported) {
  const std::string all = told(
      "launch:\n- nod: {}\n- node: {pkg: a}\n- arg: {name: x}\n- include: {file: gone.launch.yaml}\n- log: {message: "
      "$(var y)}");
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 5) << all;
}

TEST(HostileFiles, end_in_a_problem_and_in_bounded_time) {
  std::string doubling = "launch:\n- let: {name: x, value: aaaaaaaaaaaaaaaa}\n";
  for (int i = 0; i < 200; ++i) doubling += "- let: {name: x, value: $(var x)$(var x)}\n";
  EXPECT_NE(told(doubling).find("longer than"), std::string::npos);

  std::map<std::string, std::string> tree;
  for (int i = 0; i < 15; ++i) {
    const std::string next = "f" + std::to_string(i + 1) + ".launch.yaml";
    tree["f" + std::to_string(i) + ".launch.yaml"] = std::string("launch:\n- include: {file: ")
                                                         .append(next)
                                                         .append("}\n- include: {file: ")
                                                         .append(next)
                                                         .append("}\n");
  }
  tree["f15.launch.yaml"] = "launch: []";
  EXPECT_NE(told("launch:\n- include: {file: f0.launch.yaml}", {}, tree).find("files are included"), std::string::npos);

  std::string nested = "$(not ";
  for (int i = 0; i < 5000; ++i) nested += "$(not ";
  EXPECT_NE(told("launch:\n- log: {message: '" + nested + "'}").find("nested more than"), std::string::npos);

  std::string many = "launch:\n";
  for (int i = 0; i < 3000; ++i) many += "- log: {message: a}\n";
  EXPECT_NE(told(many).find("more than 1000 actions"), std::string::npos);

  std::string xml;
  for (int i = 0; i < 100000; ++i) xml += "<group>";
  EXPECT_FALSE(load_plan_text(xml, "a.xml", {}, in_memory({})));
}

}  // namespace
}  // namespace nacelle::launch
