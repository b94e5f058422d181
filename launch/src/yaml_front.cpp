// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "element.hpp"
#include "nacelle/launch/launch_fault.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::launch {
namespace {

// The recursion below is as deep as the document, which parse_yaml() bounds.
class YamlFront {
 public:
  explicit YamlFront(const std::string& file) : file_(file) {}

  Element read(const YamlNode& root) {
    Element launch{"launch", root.line, {}, {}};
    if (!root.is_map()) {
      report(root.line, LaunchFault::Form,
             std::string("expected the key 'launch' with a list of actions, found ") + root.kind_text());
      return launch;
    }
    check_repeated(root);
    bool found = false;
    for (const YamlNode& entry : root.items) {
      if (entry.key != "launch") {
        report(entry.key_line, LaunchFault::UnknownKey, "unknown key '" + entry.key + "'",
               suggestion(entry.key, {"launch"}));
        continue;
      }
      found = true;
      launch.line = entry.key_line;
      if (entry.is_null()) continue;
      if (entry.is_sequence()) {
        read_actions(entry, launch);
      } else {
        report(entry.line, LaunchFault::Form,
               std::string("'launch' needs a list of actions, not ") + entry.kind_text());
      }
    }
    if (!found && root.items.empty()) report(root.line, LaunchFault::MissingKey, "the key 'launch' is missing");
    return launch;
  }
  std::vector<Problem> problems;

 private:
  void report(int line, LaunchFault fault, std::string what, std::string way_out = {}) {
    problems.push_back({Place(file_, line), std::move(what), std::move(way_out), fault});
  }

  void check_repeated(const YamlNode& map) {
    for (std::size_t i = 1; i < map.items.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        if (map.items[k].key != map.items[i].key) continue;
        report(map.items[i].key_line, LaunchFault::Twice,
               "the key '" + map.items[i].key + "' stands here a second time; the first is at line " +
                   std::to_string(map.items[k].key_line));
        break;
      }
      if (i > 200) return report(map.items[i].key_line, LaunchFault::TooMuch, "more than 200 keys in one map");
    }
  }

  // `- node: {...}`: a list of maps with one key each.
  void read_actions(const YamlNode& list, Element& into) {
    for (const YamlNode& item : list.items) {
      if (!item.is_map() || item.items.size() != 1) {
        report(item.line, LaunchFault::Form,
               std::string("expected one action, such as '- node: {...}', found ") +
                   (item.is_map() ? "a map with " + std::to_string(item.items.size()) + " keys" : item.kind_text()),
               item.is_map() ? "indent the keys of an action below its name" : "");
        continue;
      }
      const YamlNode& action = item.items.front();
      Element element{action.key, action.key_line, {}, {}};
      if (action.is_map()) {
        read_fields(action, element);
      } else if (action.is_sequence()) {
        read_actions(action, element);
      } else if (action.is_scalar()) {
        report(action.line, LaunchFault::Form, "'" + action.key + "' needs a map, not text");
        continue;
      }
      into.children.push_back(std::move(element));
    }
  }

  void read_fields(const YamlNode& map, Element& into) {
    check_repeated(map);
    for (const YamlNode& field : map.items) {
      if (field.is_null()) {
        report(field.key_line, LaunchFault::MissingKey, "'" + field.key + "' has no value",
               "write '' for an empty text");
      } else if (field.is_scalar()) {
        into.attributes.push_back({field.key, field.key_line, false, {raw(field)}});
      } else if (field.key == "children" && field.is_sequence()) {
        read_actions(field, into);
      } else if (field.is_map()) {
        read_map_field(field, into);
      } else {
        read_list_field(field, into);
      }
    }
  }

  void read_map_field(const YamlNode& field, Element& into) {
    // Keyed by topic: {<topic>: {...}} is an element per topic, so that XML can say the same.
    const bool by_topic =
        field.key == "qos" || (field.key == "budget" && !field.items.empty() && field.items.front().is_map());
    if (!by_topic) {
      Element child{field.key, field.key_line, {}, {}};
      read_fields(field, child);
      into.children.push_back(std::move(child));
      return;
    }
    check_repeated(field);
    for (const YamlNode& topic : field.items) {
      Element child{field.key, topic.key_line, {}, {}};
      child.attributes.push_back({"topic", topic.key_line, false, {{topic.key, true, topic.key_line}}});
      if (topic.is_map()) {
        read_fields(topic, child);
      } else {
        report(topic.line, LaunchFault::Form,
               "'" + topic.key + "' below '" + field.key + "' needs a map, not " + topic.kind_text());
      }
      into.children.push_back(std::move(child));
    }
  }

  void read_list_field(const YamlNode& field, Element& into) {
    const bool maps =
        std::any_of(field.items.begin(), field.items.end(), [](const YamlNode& item) { return item.is_map(); });
    Attribute attribute{field.key, field.key_line, true, {}};
    for (const YamlNode& item : field.items) {
      if (maps ? !item.is_map() : !item.is_scalar()) {
        report(item.line, LaunchFault::Form,
               std::string("the list of '") + field.key + "' holds " + item.kind_text() + " beside " +
                   (maps ? "maps" : "text"));
      } else if (maps) {
        Element child{field.key, item.line, {}, {}};
        read_fields(item, child);
        into.children.push_back(std::move(child));
      } else {
        attribute.values.push_back(raw(item));
      }
    }
    if (!maps) into.attributes.push_back(std::move(attribute));
  }

  static RawText raw(const YamlNode& node) { return {node.text, node.quoted || node.tag == "str", node.line}; }

  const std::string& file_;
};

}  // namespace

Result<Element, std::vector<Problem>> read_yaml(std::string_view text, const std::string& file) {
  const auto root = parse_yaml(text, file);
  if (!root) return err(std::vector<Problem>{coded(root.error(), LaunchFault::Form)});
  YamlFront front(file);
  Element launch = front.read(*root);
  if (!front.problems.empty()) return err(std::move(front.problems));
  return launch;
}

}  // namespace nacelle::launch
