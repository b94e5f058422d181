// SPDX-License-Identifier: Apache-2.0
#include "ros_import/drivers.hpp"

#include <cctype>
#include <utility>
#include <variant>

#include "nacelle/base/expect.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::ros_import {
namespace {

using Names = std::vector<std::string>;
using Values = std::map<std::string, ParameterValue, std::less<>>;

/// The words of a map in drivers.yaml, and the members of a T that they set.
template <typename T>
using Words = std::map<std::string_view, std::variant<std::string T::*, bool T::*, ParameterValue T::*, Names T::*,
                                                      Values T::*, std::vector<Key> T::*, std::vector<Driver> T::*>>;
const Words<Table> kTableWords{{"every_node", &Table::every_node},
                               {"generic", &Table::generic},
                               {"double_lists", &Table::double_lists},
                               {"drivers", &Table::drivers}};
const Words<Driver> kDriverWords{
    {"name", &Driver::name},     {"named", &Driver::named}, {"hinted", &Driver::hinted},    {"node", &Driver::node},
    {"shared", &Driver::shared}, {"keys", &Driver::keys},   {"controls", &Driver::controls}};
const Words<Key> kKeyWords{{"nodes", &Key::nodes},
                           {"to", &Key::to},
                           {"text", &Key::text},
                           {"usual", &Key::usual},
                           {"values", &Key::values},
                           {"usual_text", &Key::usual_text},
                           {"also", &Key::also},
                           {"any_case", &Key::any_case},
                           {"otherwise", &Key::otherwise},
                           {"form", &Key::form},
                           {"most", &Key::most},
                           {"absent", &Key::absent},
                           {"absent_text", &Key::absent_text}};
const std::map<std::string_view, Fate> kFates{{"kept", Fate::Kept},
                                              {"translated", Fate::Translated},
                                              {"joined", Fate::Translated},
                                              {"dropped", Fate::Dropped},
                                              {"doubted", Fate::Doubted}};

/// Makes the table of a document. What does not fit becomes a problem, and the rest is read on.
struct Reader {
  std::string file;
  std::vector<Problem> problems{};

  void complain(const YamlNode& at, std::string what) {
    problems.push_back({Place{file, at.line}, std::move(what), ""});
  }
  template <typename T>
  void read_word(const YamlNode& item, T& to, const Words<T>& words) {
    const auto word = words.find(item.key);
    if (word == words.end()) return complain(item, "'" + item.key + "' means nothing here");
    std::visit([&](auto member) { read(item, to.*member); }, word->second);
  }
  void read(const YamlNode& node, std::string& to) {
    if (!node.is_scalar()) complain(node, std::string{"text is needed, not "} + node.kind_text());
    to = node.text;
  }
  void read(const YamlNode& node, ParameterValue& to) {
    auto made = launch::value_of_node(node);
    if (!made) return complain(node, made.error().what);
    to = std::move(*made);
  }
  void read(const YamlNode& node, bool& to) { to = value(node) == ParameterValue{true}; }
  ParameterValue value(const YamlNode& node) {
    ParameterValue made;
    read(node, made);
    return made;
  }
  void read(const YamlNode& node, Values& to) {
    for (const YamlNode& item : node.items) read(item, to[item.key]);
  }
  template <typename Item>
  void read(const YamlNode& node, std::vector<Item>& to) {
    if (!node.is_sequence()) complain(node, std::string{"a list is needed, not "} + node.kind_text());
    for (const YamlNode& item : node.items) read(item, to.emplace_back());
  }
  void read(const YamlNode& node, Table& to) {
    for (const YamlNode& item : node.items) read_word(item, to, kTableWords);
    if (to.drivers.empty()) complain(node, "there are no drivers");
  }
  void read(const YamlNode& node, Driver& to) {
    for (const YamlNode& item : node.items) read_word(item, to, kDriverWords);
    if (to.name.empty() || to.named.empty() || to.keys.empty())
      complain(node, "a driver has `name`, `named` and `keys`");
  }
  void read(const YamlNode& rows, std::vector<Key>& to) {
    for (const YamlNode& row : rows.items) read_row(row, to);
  }
  void read_row(const YamlNode& row, std::vector<Key>& to) {
    Key shared;
    const YamlNode* keys = nullptr;
    for (const YamlNode& item : row.items) {
      if (const auto fate = kFates.find(item.key); fate != kFates.end() && keys == nullptr) {
        shared.fate = fate->second;
        keys = &item;
      } else {
        read_word(item, shared, kKeyWords);
      }
    }
    if (keys == nullptr) return complain(row, "a row says one fate: kept, translated, dropped, doubted or joined");
    for (const YamlNode& item : keys->items) {
      Key& key = to.emplace_back(shared);
      key.name = keys->is_map() ? item.key : item.text;
      const bool has_reason = key.fate == Fate::Dropped || key.fate == Fate::Doubted;
      if (keys->key == "joined")
        key.joined = value(item);
      else if (keys->is_map())
        read(item, has_reason ? key.text : key.to);
      if (has_reason && key.nodes.empty() && key.text.empty()) complain(item, "'" + key.name + "' needs a reason");
      const ParameterValue none;
      const bool may_misfit = key.joined != none || key.most != none || !key.values.empty() || key.form == "period";
      if (may_misfit && key.otherwise.empty()) complain(item, "'" + key.name + "' needs `otherwise`");
    }
  }
};

/// '#' stands for one digit or more, '*' for anything, the empty text included.
bool fits(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern.front() == '*') {
    for (std::size_t skip = 0; skip <= name.size(); ++skip) {
      if (fits(pattern.substr(1), name.substr(skip))) return true;
    }
    return false;
  }
  if (name.empty()) return false;
  if (pattern.front() == '#') {
    std::size_t digits = 0;
    while (digits < name.size() && std::isdigit(static_cast<unsigned char>(name[digits])) != 0) ++digits;
    return digits > 0 && fits(pattern.substr(1), name.substr(digits));
  }
  return pattern.front() == name.front() && fits(pattern.substr(1), name.substr(1));
}

const Key* find_in(const std::vector<Key>& keys, std::string_view name) {
  for (const Key& key : keys) {
    if (fits(key.name, name)) return &key;
  }
  return nullptr;
}

}  // namespace

Result<Table, std::vector<Problem>> read_table(std::string_view yaml, const std::string& file_name) {
  const auto root = parse_yaml(yaml, file_name);
  if (!root) return err(std::vector<Problem>{root.error()});
  Reader reader{file_name};
  Table made;
  reader.read(*root, made);
  if (!reader.problems.empty()) return err(std::move(reader.problems));
  return made;
}

const Table& table() {
  static const Table shipped = [] {
    auto read = read_table(kDriversYaml, "drivers.yaml");
    NACELLE_EXPECT(read, "the table of drivers in the program has no mistake");
    return std::move(*read);
  }();
  return shipped;
}

const std::vector<Driver>& drivers() { return table().drivers; }
const Key* find_key(const Driver& driver, std::string_view name) { return find_in(driver.keys, name); }
const Key* find_common_key(std::string_view name) { return find_in(table().every_node, name); }

}  // namespace nacelle::ros_import
