// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "element.hpp"
#include "nacelle/launch/launch_fault.hpp"
#include "nacelle/qos/profiles.hpp"
#include "substitution.hpp"
#include "unsupported.hpp"

namespace nacelle::launch {
namespace {

struct Rule {
  std::vector<std::string> attributes;  // all known ones
  std::vector<std::string> required;
  std::vector<std::string> lists;  // may be a list of values
  std::vector<std::string> children;
};

// "name! value* type": '!' is required, '*' may be a list, both may stand together.
Rule make_rule(const std::string& attributes, const std::string& children) {
  Rule rule;
  std::istringstream words(attributes);
  for (std::string word; words >> word;) {
    bool required = false;
    bool list = false;
    while (word.back() == '!' || word.back() == '*') {
      (word.back() == '!' ? required : list) = true;
      word.pop_back();
    }
    rule.attributes.push_back(word);
    if (required) rule.required.push_back(word);
    if (list) rule.lists.push_back(word);
  }
  std::istringstream more(children);
  for (std::string word; more >> word;) rule.children.push_back(word);
  return rule;
}

const char* const kActions =
    "node_container load_composable_node node executable arg let include group push_ros_namespace set_env unset_env "
    "log look set_parameter set_parameters_from_file set_remap set_use_sim_time network";
const char* const kProcess =
    " if unless name cwd output shell launch-prefix emulate_tty respawn respawn_delay respawn_max_retries "
    "sigterm_timeout sigkill_timeout required";

// ROS 2's launch and launch_ros (jazzy), extended by network, look, namespace and by qos, after, thread, required, isolate,
// budget, on_fault, resume and autostart.
// "include/arg" is the rule of an arg inside an include; without such an entry the rule of "arg" holds.
const std::map<std::string, Rule>& rules() {
  static const std::map<std::string, Rule> all = [] {
    const std::string process = kProcess;
    const std::string node = "exec namespace exec_name args* ros_args pkg" + process;
    const std::string qos = join(qos_keys(), " ") + " liveliness_lease_duration";
    const std::string limits = "max_copies max_age min_hz";
    std::map<std::string, Rule> r;
    r["launch"] = make_rule("version", std::string(kActions) + " namespace");
    r["group"] = make_rule("if unless scoped forwarding", kActions);
    r["arg"] = make_rule("name! default description if unless", "choice");
    r["choice"] = make_rule("value!", "");
    r["let"] = make_rule("name! value! if unless", "");
    r["include"] = make_rule("file! if unless", "arg let");
    r["include/arg"] = make_rule("name! value!", "");
    r["include/let"] = make_rule("name! value!", "");
    r["executable"] = make_rule("cmd! args*" + process, "env");
    r["node"] = make_rule(node, "param remap env");
    r["node"].required = {"exec"};
    r["node_container"] = make_rule(node, "param remap env composable_node");
    r["node_container"].required = {"name"};
    r["load_composable_node"] = make_rule("target! if unless", "composable_node");
    r["composable_node"] =
        make_rule("pkg! plugin! name! namespace if unless required isolate autostart resume after* thread on_fault",
                  "param remap extra_arg qos after thread budget on_fault");
    r["param"] = make_rule("name value* type from allow_substs", "param");
    r["remap"] = make_rule("from! to!", "");
    r["extra_arg"] = make_rule("name! value!", "");
    r["env"] = make_rule("name! value!", "");
    r["qos"] = make_rule("topic!", "publisher subscription");
    r["publisher"] = make_rule(qos, "");
    r["subscription"] = r["publisher"];
    r["after"] = make_rule("node! when detail timeout", "");
    r["thread"] = make_rule("mode priority cpus* threads", "");
    r["budget"] = make_rule("topic " + limits, "");
    r["on_fault"] = make_rule("policy max backoff", "restart");
    r["restart"] = make_rule("max backoff", "");
    r["network"] =
        make_rule("mode domain_id interfaces* peers* export* allow_load remote_control if unless", "export security");
    r["look"] = make_rule("port address name if unless", "");
    r["security"] = make_rule("keystore enclave strategy", "");
    r["export"] = make_rule("topic! max_hz max_bytes compressed_only", "");
    r["namespace"] = make_rule("name! tf if unless", "");
    r["push_ros_namespace"] = make_rule("namespace! if unless", "");
    r["set_env"] = make_rule("name! value! if unless", "");
    r["unset_env"] = make_rule("name! if unless", "");
    r["log"] = make_rule("message! if unless", "");
    r["set_parameter"] = make_rule("name! value!* type if unless", "");
    r["set_parameters_from_file"] = make_rule("filename! if unless", "");
    r["set_remap"] = make_rule("from! to! if unless", "");
    r["set_use_sim_time"] = make_rule("value! if unless", "");
    return r;
  }();
  return all;
}

struct OtherWord {
  std::string_view other;
  const char* word;
};
constexpr std::array kOtherWords{OtherWord{"params", "param"},     OtherWord{"parameters", "param"},
                                 OtherWord{"remappings", "remap"}, OtherWord{"remaps", "remap"},
                                 OtherWord{"package", "pkg"},      OtherWord{"executable", "exec"},
                                 OtherWord{"arguments", "args"},   OtherWord{"class", "plugin"},
                                 OtherWord{"node_name", "name"},   OtherWord{"node_namespace", "namespace"},
                                 OtherWord{"depends_on", "after"}, OtherWord{"extra_arguments", "extra_arg"}};

bool holds(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

class Checker {
 public:
  Checker(const std::string& file, std::vector<Problem>& problems) : file_(file), problems_(problems) {}

  // As deep as the front ends allow.
  void check(const Element& element, const Rule& rule) {
    for (const auto& attribute : element.attributes) check_attribute(element, attribute, rule);
    for (const auto& name : rule.required) {
      if (element.find(name) == nullptr)
        report(element.line, LaunchFault::MissingKey, "'" + element.name + "' needs the key '" + name + "'");
    }
    if (element.find("if") != nullptr && element.find("unless") != nullptr) {
      report(element.find("unless")->line, LaunchFault::Misplaced, "'" + element.name + "' has both 'if' and 'unless'",
             "use one of them with $(and) or $(not)");
    }
    std::vector<std::string> once;
    for (const auto& child : element.children) {
      check_child(element, child, rule);
      const bool single = child.name == "thread" || child.name == "on_fault" || child.name == "publisher" ||
                          child.name == "subscription" || child.name == "security";
      if (!single) continue;
      if (holds(once, child.name) || element.find(child.name) != nullptr)
        report(child.line, LaunchFault::Twice, "'" + child.name + "' stands here a second time");
      once.push_back(child.name);
    }
  }

 private:
  void report(int line, LaunchFault fault, std::string what, std::string way_out = {}) {
    problems_.push_back({Place(file_, line), std::move(what), std::move(way_out), fault});
  }
  // A refusal's text is "<what>; <way out>" already.
  void refuse(int line, const std::string& name, const char* why) {
    report(line, LaunchFault::Refused, "'" + name + "' is refused: " + why);
  }

  static std::string unknown_text(const Element& element, const std::string& name) {
    const bool action = element.name == "launch" || element.name == "group";
    return std::string("unknown ") + (action ? "action" : "key") + " '" + name + "' in '" + element.name + "'";
  }

  void unknown(const Element& element, const std::string& name, int line, const Rule& rule) {
    std::vector<std::string> known = rule.attributes;
    for (const auto& child : rule.children) {
      if (!holds(known, child)) known.push_back(child);  // some may be either
    }
    // What a Python launch file, or another tool, calls them.
    std::vector<std::string> others;
    for (const auto& [other, word] : kOtherWords) {
      if (holds(known, word)) others.emplace_back(other);
    }
    if (nearest_name(name, known).empty()) {
      const auto other = std::ranges::find(kOtherWords, nearest_name(name, others), &OtherWord::other);
      if (other != kOtherWords.end())
        return report(line, LaunchFault::UnknownKey, unknown_text(element, name),
                      "did you mean '" + std::string(other->word) + "'?");
    }
    report(line, LaunchFault::UnknownKey, unknown_text(element, name), suggestion(name, known));
  }

  void check_attribute(const Element& element, const Attribute& attribute, const Rule& rule) {
    if (!holds(rule.attributes, attribute.name)) {
      if (!holds(rule.children, attribute.name)) return unknown(element, attribute.name, attribute.line, rule);
      if (!attribute.is_list || !attribute.values.empty()) {
        report(attribute.line, LaunchFault::Form,
               "'" + attribute.name + "' in '" + element.name + "' needs a map or a list of maps, not text");
      }
      return;
    }
    if (attribute.is_list && !holds(rule.lists, attribute.name) &&
        !(attribute.values.empty() && holds(rule.children, attribute.name))) {
      report(attribute.line, LaunchFault::Form, "'" + attribute.name + "' needs one value, not a list");
    }
    const bool off = !attribute.values.empty() && attribute.values.front().text == "false";
    if (const char* why = refused_attribute(attribute.name); why != nullptr && !off) {
      refuse(attribute.line, attribute.name, why);
    }
    for (const auto& value : attribute.values) {
      if (auto ok = check_template(value.text); !ok)
        report(value.line, LaunchFault::Form, ok.error().what, ok.error().way_out);
    }
  }

  void check_child(const Element& element, const Element& child, const Rule& rule) {
    // launch_ros knows both spellings.
    const std::string name = child.name == "push-ros-namespace" ? "push_ros_namespace" : child.name;
    if (!holds(rule.children, name)) {
      if (holds(rule.attributes, name))
        return report(child.line, LaunchFault::Form,
                      "'" + name + "' in '" + element.name + "' needs a value, not a map");
      const bool actions = element.name == "launch" || element.name == "group";
      if (const char* why = actions ? refused_action(name) : nullptr; why != nullptr)
        return refuse(child.line, name, why);
      return unknown(element, child.name, child.line, rule);
    }
    auto found = rules().find(element.name + "/" + name);
    if (found == rules().end()) found = rules().find(name);
    if (found != rules().end()) check(child, found->second);
  }

  const std::string& file_;
  std::vector<Problem>& problems_;
};

}  // namespace

void check_schema(const Element& root, const std::string& file, std::vector<Problem>& problems) {
  Checker(file, problems).check(root, rules().at("launch"));
}

}  // namespace nacelle::launch
