// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/xacro.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "nacelle/base/reversed.hpp"
#include "scope.hpp"

namespace nacelle::description {
namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;
using tinyxml2::XMLNode;

constexpr std::size_t kMaxFiles = 200;
constexpr std::size_t kMaxDepth = 60;                   // of macros, includes and elements on the way to one
constexpr std::size_t kMaxElements = 200000;            // of the result
constexpr std::size_t kMaxNesting = 400;                // of elements, those of xacro and of macros on the way included
constexpr std::size_t kMaxReads = 1000000;              // of properties
constexpr std::size_t kMaxText = std::size_t{1} << 20;  // of one attribute or text
constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20;

/// Ends the expansion; caught in expand_xacro().
struct Failure {
  Problem problem;
};

struct Parameter {
  std::string name;
  std::string default_text;
  bool has_default = false;
  bool from_outside = false;  ///< ^: the value of the same name where it is called
  int stars = 0;              ///< *: the next child, **: what is in the next child
};

struct Macro {
  std::vector<Parameter> parameters;
  const XMLElement* body = nullptr;
  std::string file;
};

bool is_blank(std::string_view text) { return text.find_first_not_of(" \t\r\n") == std::string_view::npos; }

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// "xacro:macro" -> "macro"; empty for elements of the result.
std::string_view xacro_name(const XMLElement& element) {
  const std::string_view name = element.Name();
  return name.starts_with("xacro:") ? name.substr(6) : std::string_view{};
}

class Expander {
 public:
  Expander(const std::map<std::string, std::string>& arguments, const XacroEnvironment& environment)
      : given_(arguments), environment_(environment) {}

  XacroResult expand(const std::string& path) {
    const XMLElement& root = load(path);
    Scope global;
    XMLDocument out;
    const Frame here(*this, path, "");
    // The root is an element of the result like any other; only its namespace goes.
    XMLElement* const made = out.NewElement(root.Name());
    out.InsertEndChild(made);
    copy_attributes(root, *made, global);
    expand_children(root, *made, global);
    check_arguments(path);
    tinyxml2::XMLPrinter printer;
    out.Print(&printer);
    return {"<?xml version=\"1.0\"?>\n" + std::string(printer.CStr()), std::move(warnings_)};
  }

 private:
  /// Where we are: a file, and what led there.
  class Frame {
   public:
    Frame(Expander& expander, const std::string& file, std::string reason) : expander_(expander) {
      if (expander.trail_.size() >= kMaxDepth) expander.fail_here("macros and includes are nested too deeply");
      expander.trail_.push_back({file, std::move(reason)});
    }
    ~Frame() { expander_.trail_.pop_back(); }
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

   private:
    Expander& expander_;
  };
  using Reading = std::pair<const Scope*, std::string>;
  struct Trail {
    std::string file, reason;  // "in macro 'wheel', called at robot.xacro:30"
  };

  [[nodiscard]] std::string place() const { return fmt::format("{}:{}", trail_.back().file, line_); }

  [[noreturn]] void fail_here(std::string what, std::string way_out = {}) const {
    // Whoever must mend it has to know how it was reached.
    for (const auto& step : reversed(trail_)) {
      if (!step.reason.empty()) (way_out.empty() ? what : way_out) += "\n  " + step.reason;
    }
    throw Failure{{trail_.empty() ? std::string{} : place(), std::move(what), std::move(way_out)}};
  }

  // --- files ---

  const XMLElement& load(const std::string& path) {
    if (documents_.size() >= kMaxFiles) throw Failure{{path, "more than 200 files are included", ""}};
    if (!environment_.read_file) throw Failure{{path, "cannot be read: there are no files here", ""}};
    auto text = environment_.read_file(path);
    if (!text) {
      if (!trail_.empty()) fail_here(text.error().text());
      throw Failure{text.error()};
    }
    auto document = std::make_unique<XMLDocument>(true, tinyxml2::PRESERVE_WHITESPACE);
    if (document->Parse(text->data(), text->size()) != tinyxml2::XML_SUCCESS) {
      throw Failure{{fmt::format("{}:{}", path, document->ErrorLineNum()),
                     std::string{"is no well-formed XML: "} + document->ErrorName(), ""}};
    }
    if (document->RootElement() == nullptr) throw Failure{{path, "has no element", ""}};
    documents_.push_back(std::move(document));
    return *documents_.back()->RootElement();
  }

  void include(const XMLElement& element, XMLNode& into, Scope& scope) {
    allow_only(element, {"filename", "optional"});
    std::string name = required(element, "filename", scope);
    const bool optional = element.Attribute("optional") != nullptr && condition(element, "optional", scope);
    if (!name.starts_with('/'))
      name = (std::filesystem::path(trail_.back().file).parent_path() / name).lexically_normal().string();
    for (const auto& step : trail_) {
      if (step.file == name && step.reason.find("included") != std::string::npos)
        fail_here("the files include each other: '" + name + "'");
    }
    if (name == trail_.front().file) fail_here("the files include each other: '" + name + "'");
    if (optional && environment_.read_file && !environment_.read_file(name)) return;
    const std::string reason = "included at " + place();
    const XMLElement& root = load(name);
    const int line = line_;
    {
      const Frame frame(*this, name, reason);
      expand_children(root, into, scope);
    }
    line_ = line;
  }

  // --- text ---

  std::string argument(const std::string& name) {
    asked_.push_back(name);
    if (const auto given = given_.find(name); given != given_.end()) return given->second;
    if (const auto known = defaults_.find(name); known != defaults_.end()) {
      if (known->second) return *known->second;
      fail_here("the argument '" + name + "' has no value", "give it as " + name + ":=value");
    }
    std::vector<std::string> names;
    for (const auto& [key, value] : defaults_) names.push_back(key);
    fail_here("there is no argument '" + name + "'", suggestion(name, names));
  }

  std::string substitution(const std::string& text) {
    const auto words = words_of(text);
    const std::string name = words.empty() ? std::string{} : words[0];
    const auto needs = [&](std::size_t count) {
      if (words.size() != count + 1)
        fail_here(fmt::format("$({}) takes {} word{}, not {}", name, count, count == 1 ? "" : "s",
                              words.empty() ? 0 : words.size() - 1));
    };
    if (name == "arg") {
      needs(1);
      return argument(words[1]);
    }
    if (name == "find" || name == "find-pkg-share") {
      needs(1);
      std::string folder = environment_.find_package ? environment_.find_package(words[1]) : std::string{};
      if (folder.empty()) fail_here("there is no package '" + words[1] + "'");
      return folder;
    }
    if (name == "env") {
      needs(1);
      auto value = environment_.variable ? environment_.variable(words[1]) : std::nullopt;
      if (!value)
        fail_here("the environment variable '" + words[1] + "' is not set",
                  "or write $(optenv " + words[1] + " default)");
      return *value;
    }
    if (name == "optenv") {
      if (words.size() < 2) fail_here("$(optenv) takes a name and a default");
      if (auto value = environment_.variable ? environment_.variable(words[1]) : std::nullopt) return *value;
      const auto rest = text.find(words[1]) + words[1].size();
      return words.size() == 2 ? std::string{} : text.substr(text.find_first_not_of(" \t", rest));
    }
    if (name == "dirname") {
      needs(0);
      const std::string folder = std::filesystem::path(trail_.back().file).parent_path().string();
      return folder.empty() ? "." : folder;
    }
    if (name == "cwd") {
      needs(0);
      std::error_code none;
      return std::filesystem::current_path(none).string();
    }
    fail_here("unknown substitution $(" + name.substr(0, 60) + ")",
              suggestion(name.substr(0, 60), {"arg", "find", "env", "optenv", "dirname", "cwd"}));
  }

  /// The end of ${...} or $(...) that begins at `at`; quotes hide what is in them.
  std::size_t end_of(const std::string& text, std::size_t at) {
    const char open = text[at + 1], close = open == '{' ? '}' : ')';
    int depth = 0;
    char quote = '\0';
    for (std::size_t i = at + 1; i < text.size(); ++i) {
      const char c = text[i];
      if (quote != '\0') {
        if (c == quote) quote = '\0';
      } else if (open == '{' && (c == '\'' || c == '"')) {
        quote = c;
      } else if (c == open) {
        ++depth;
      } else if (c == close && --depth == 0) {
        return i;
      }
    }
    fail_here("'" + text.substr(at, 40) + "' lacks its '" + close + "'");
  }

  /// The text with ${} and $() replaced; a single ${} keeps its type.
  Value evaluate_text(const std::string& text, const Scope& scope) {
    std::string out;
    std::optional<Value> single;
    for (std::size_t i = 0; i < text.size();) {
      if (text.size() - i >= 3 && text[i] == '$' && text[i + 1] == '$' && (text[i + 2] == '{' || text[i + 2] == '(')) {
        const std::size_t end = end_of(text, i + 1);
        out += text.substr(i + 1, end - i);
        i = end + 1;
      } else if (text[i] == '$' && i + 1 < text.size() && (text[i + 1] == '{' || text[i + 1] == '(')) {
        const std::size_t end = end_of(text, i);
        const std::string inner = text.substr(i + 2, end - i - 2);
        Value value;
        if (text[i + 1] == '{') {
          auto answer = evaluate(inner, [&](std::string_view name) { return value_named(name, scope); });
          if (!answer) fail_here("${" + inner.substr(0, 80) + "}: " + answer.error());
          value = std::move(*answer);
        } else {
          value = value_of(substitution(to_text(evaluate_text(inner, scope))));
          if (!(i == 0 && end + 1 == text.size())) value = to_text(value);
        }
        if (i == 0 && end + 1 == text.size()) single = value;
        out += to_text(value);
        i = end + 1;
      } else {
        out += text[i++];
      }
      if (out.size() > kMaxText) fail_here("a text becomes longer than 1 MiB");
    }
    return single ? *single : Value{std::move(out)};
  }

  Result<Value, std::string> value_named(std::string_view name, const Scope& scope) {
    const Scope* const owner = scope.owner_of(name);
    if (owner == nullptr) {
      std::vector<std::string> names;
      scope.append_names(names);
      return err("there is no property '" + std::string(name.substr(0, 60)) + "'; " +
                 suggestion(name.substr(0, 60), names));
    }
    const Property& property = *owner->find(name);
    if (property.is_block) return err("'" + std::string(name) + "' is a block; insert it with xacro:insert_block");
    const Reading reading{owner, std::string(name)};
    if (std::find(being_read_.begin(), being_read_.end(), reading) != being_read_.end())
      return err("the property '" + std::string(name) + "' is made of itself");
    if (being_read_.size() > kMaxDepth) return err(std::string{"properties are nested too deeply"});
    if (++reads_ > kMaxReads) return err(std::string{"properties are read more than a million times"});
    being_read_.push_back(reading);
    // Evaluated when it is asked for, with the names that it can see where it stands.
    Value value = evaluate_text(property.text, *owner);
    being_read_.pop_back();
    if (const auto* read = std::get_if<std::string>(&value)) return value_of(*read);
    return value;
  }

  std::string text_of(const std::string& text, const Scope& scope) { return to_text(evaluate_text(text, scope)); }

  // --- attributes ---

  std::string required(const XMLElement& element, const char* name, const Scope& scope) {
    const char* const text = element.Attribute(name);
    if (text == nullptr) fail_here(fmt::format("<{}> needs the attribute '{}'", element.Name(), name));
    return text_of(text, scope);
  }

  void allow_only(const XMLElement& element, const std::vector<std::string>& known) const {
    for (const auto* attribute = element.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
      if (std::find(known.begin(), known.end(), attribute->Name()) != known.end()) continue;
      if (element.Name() == std::string_view{"xacro:include"} && attribute->Name() == std::string_view{"ns"})
        fail_here("an include with a namespace (ns) is not available", "give the file's macros names of their own");
      fail_here(fmt::format("<{}> has no attribute '{}'", element.Name(), attribute->Name()),
                suggestion(attribute->Name(), known));
    }
  }

  bool condition(const XMLElement& element, const char* name, const Scope& scope) {
    const char* const text = element.Attribute(name);
    if (text == nullptr) fail_here(fmt::format("<{}> needs the attribute '{}'", element.Name(), name));
    Value value = evaluate_text(text, scope);
    if (const auto* word = std::get_if<std::string>(&value)) value = value_of(*word);
    if (std::holds_alternative<std::string>(value))
      fail_here(fmt::format("{}=\"{}\" is neither true nor false: '{}'", name, text, to_text(value).substr(0, 60)),
                "write true, false, a number or a comparison");
    return is_true(value);
  }

  void copy_attributes(const XMLElement& from, XMLElement& to, const Scope& scope) {
    for (const auto* attribute = from.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
      if (std::string_view{attribute->Name()} == "xmlns:xacro") continue;
      to.SetAttribute(attribute->Name(), text_of(attribute->Value(), scope).c_str());
    }
  }

  // --- elements ---

  void expand_children(const XMLElement& from, XMLNode& into, Scope& scope) {
    for (const XMLNode* node = from.FirstChild(); node != nullptr; node = node->NextSibling()) {
      expand_node(*node, into, scope);
    }
  }

  void expand_node(const XMLNode& node, XMLNode& into, Scope& scope) {
    line_ = node.GetLineNum();
    XMLDocument& out = *into.GetDocument();
    if (const auto* text = node.ToText()) {
      if (!is_blank(text->Value())) into.InsertEndChild(out.NewText(text_of(text->Value(), scope).c_str()));
      return;
    }
    const XMLElement* const element = node.ToElement();
    if (element == nullptr) return;  // comments and declarations stay behind
    if (++depth_ > kMaxNesting) fail_here("elements are nested too deeply", "does a macro call itself?");
    if (const std::string_view name = xacro_name(*element); !name.empty()) {
      expand_xacro_element(name, *element, into, scope);
    } else {
      if (++elements_ > kMaxElements) fail_here("the result would have more than 200000 elements");
      XMLElement* const made = out.NewElement(element->Name());
      into.InsertEndChild(made);
      copy_attributes(*element, *made, scope);
      expand_children(*element, *made, scope);
    }
    --depth_;
  }

  void expand_xacro_element(std::string_view name, const XMLElement& element, XMLNode& into, Scope& scope) {
    if (name == "property") return property(element, scope);
    if (name == "macro") return macro(element, scope);
    if (name == "arg") return arg(element, scope);
    if (name == "include") return include(element, into, scope);
    if (name == "if" || name == "unless") {
      allow_only(element, {"value"});
      if (condition(element, "value", scope) == (name == "if")) expand_children(element, into, scope);
      return;
    }
    if (name == "insert_block") return insert_block(element, into, scope);
    if (name == "element") {
      const std::string made_name = required(element, "xacro:name", scope);
      if (!is_element_name(made_name)) fail_here("'" + made_name.substr(0, 60) + "' is no name of an element");
      XMLElement* const made = into.GetDocument()->NewElement(made_name.c_str());
      into.InsertEndChild(made);
      copy_attributes(element, *made, scope);
      made->DeleteAttribute("xacro:name");
      return expand_children(element, *made, scope);
    }
    if (name == "attribute") {
      allow_only(element, {"name", "value"});
      XMLElement* const parent = into.ToElement();
      const std::string made_name = required(element, "name", scope);
      if (parent == nullptr || !is_element_name(made_name))
        fail_here("'" + made_name.substr(0, 60) + "' is no name of an attribute");
      parent->SetAttribute(made_name.c_str(), required(element, "value", scope).c_str());
      return;
    }
    if (name == "call") {
      const std::string called = required(element, "macro", scope);
      return call(called, element, into, scope);
    }
    call(std::string(name), element, into, scope);
  }

  static bool is_element_name(const std::string& name) {
    return !name.empty() && (std::isalpha(static_cast<unsigned char>(name[0])) != 0 || name[0] == '_') &&
           name.find_first_of(" \t\r\n<>&'\"/=") == std::string::npos;
  }

  void property(const XMLElement& element, Scope& scope) {
    allow_only(element, {"name", "value", "default", "scope", "remove"});
    const std::string name = required(element, "name", scope);
    if (name.empty() || name.starts_with("__")) fail_here("'" + name + "' is no name of a property");
    Scope* target = &scope;
    bool is_local = true;
    if (const char* where = element.Attribute("scope")) {
      const std::string_view word = where;
      if (word != "parent" && word != "global" && word != "local")
        fail_here("scope cannot be '" + std::string(word.substr(0, 60)) + "'",
                  suggestion(word, {"parent", "global", "local"}));
      if (word == "global") target = &scope.root();
      if (word == "parent") target = scope.above() != nullptr ? scope.above() : &scope;
      is_local = word == "local";
    }
    Property made;
    if (const char* value = element.Attribute("value")) {
      made.text = value;
      // What leaves its scope is evaluated here, where its names are known.
      if (!is_local) made.text = text_of(value, scope);
    } else if (const char* fallback = element.Attribute("default")) {
      if (target->find(name) != nullptr) return;
      made.text = fallback;
    } else {
      made.is_block = true;
      made.blocks.push_back(evaluated_block(element, scope));
    }
    target->set(name, std::move(made));
  }

  void arg(const XMLElement& element, Scope& scope) {
    allow_only(element, {"name", "default"});
    const std::string name = required(element, "name", scope);
    std::optional<std::string> value;
    if (element.Attribute("default") != nullptr) value = required(element, "default", scope);
    defaults_.emplace(name, std::move(value));  // the first one counts
  }

  void macro(const XMLElement& element, Scope& scope) {
    allow_only(element, {"name", "params"});
    std::string name = required(element, "name", scope);
    if (name.starts_with("xacro:")) name.erase(0, 6);
    Macro made{parameters_of(element.Attribute("params")), &element, trail_.back().file};
    for (const char* const word :
         {"property", "macro", "arg", "include", "if", "unless", "insert_block", "call", "element", "attribute"}) {
      if (name == word) fail_here("a macro cannot be called '" + name + "': that is a word of xacro");
    }
    if (macros_.count(name) != 0) warnings_.push_back(place() + ": the macro '" + name + "' is defined anew");
    macros_.insert_or_assign(name, std::move(made));
  }

  /// "a b:=1 c:='x y' *block **blocks d:=^ e:=^|2"
  std::vector<Parameter> parameters_of(const char* text) {
    std::vector<Parameter> parameters;
    std::string_view rest = text == nullptr ? "" : text;
    while (true) {
      const auto begin = rest.find_first_not_of(" \t\r\n");
      if (begin == std::string_view::npos) return parameters;
      rest.remove_prefix(begin);
      Parameter made;
      while (rest.starts_with('*')) {
        ++made.stars;
        rest.remove_prefix(1);
      }
      const auto name_end = std::min(rest.find_first_of(" \t\r\n:="), rest.size());
      made.name = std::string(rest.substr(0, name_end));
      rest.remove_prefix(name_end);
      if (made.name.empty() || made.stars > 2)
        fail_here("the parameters are not understood at '" + std::string(rest.substr(0, 20)) + "'");
      if (rest.starts_with(":=") || rest.starts_with("=")) {
        rest.remove_prefix(rest.starts_with(":=") ? 2 : 1);
        made.has_default = true;
        if (rest.starts_with('^')) {
          made.from_outside = true;
          made.has_default = false;
          rest.remove_prefix(1);
          if (rest.starts_with('|')) {
            rest.remove_prefix(1);
            made.has_default = true;
          }
        }
        if (made.has_default) made.default_text = taken_value(rest);
      }
      parameters.push_back(std::move(made));
    }
  }

  /// A value in quotes, or up to the next blank outside of ${}.
  std::string taken_value(std::string_view& rest) {
    if (!rest.empty() && (rest.front() == '\'' || rest.front() == '"')) {
      const auto end = rest.find(rest.front(), 1);
      if (end == std::string_view::npos) fail_here("a quotation mark in the parameters is not closed");
      std::string value(rest.substr(1, end - 1));
      rest.remove_prefix(end + 1);
      return value;
    }
    int depth = 0;
    std::size_t i = 0;
    for (; i < rest.size(); ++i) {
      const char c = rest[i];
      if (c == '{' || c == '(') ++depth;
      if (c == '}' || c == ')') --depth;
      if (depth <= 0 && (c == ' ' || c == '\t' || c == '\n' || c == '\r')) break;
    }
    std::string value(rest.substr(0, i));
    rest.remove_prefix(i);
    return value;
  }

  /// A copy of the children with everything in them done, in a document that stays.
  Block evaluated_block(const XMLElement& element, Scope& scope) {
    documents_.push_back(std::make_unique<XMLDocument>());
    XMLElement* const holder = documents_.back()->NewElement("block");
    documents_.back()->InsertEndChild(holder);
    if (documents_.size() > 20000) fail_here("there are more than 20000 blocks");
    const int line = line_;
    expand_children(element, *holder, scope);
    line_ = line;
    return holder;
  }

  void insert_block(const XMLElement& element, XMLNode& into, Scope& scope) {
    allow_only(element, {"name"});
    const std::string name = required(element, "name", scope);
    const Property* const property = scope.find(name);
    if (property == nullptr) {
      std::vector<std::string> names;
      scope.append_names(names);
      fail_here("there is no block '" + name.substr(0, 60) + "'", suggestion(name.substr(0, 60), names));
    }
    if (!property->is_block) fail_here("'" + name + "' is a value, not a block", "write ${" + name + "}");
    for (const Block block : property->blocks) {
      for (const XMLNode* node = block->FirstChild(); node != nullptr; node = node->NextSibling()) {
        elements_ += count_of(*node);
        if (elements_ > kMaxElements) fail_here("the result would have more than 200000 elements");
        into.InsertEndChild(node->DeepClone(into.GetDocument()));
      }
    }
  }

  static std::size_t count_of(const XMLNode& node) {
    std::size_t count = 1;
    for (const XMLNode* child = node.FirstChild(); child != nullptr; child = child->NextSibling())
      count += count_of(*child);
    return count;
  }

  void call(const std::string& name, const XMLElement& element, XMLNode& into, Scope& scope) {
    const auto found = macros_.find(name);
    if (found == macros_.end()) {
      std::vector<std::string> names{"property", "macro", "include", "if", "unless", "arg", "insert_block"};
      for (const auto& [known, macro] : macros_) names.push_back(known);
      fail_here("there is no macro '" + name.substr(0, 60) + "'", suggestion(name.substr(0, 60), names));
    }
    const Macro macro = found->second;  // a copy: the body may define it anew
    if (++elements_ > kMaxElements) fail_here("macros are called more than 200000 times", "does a macro call itself?");
    Scope inner(&scope);
    pass_values(name, macro, element, scope, inner);
    pass_blocks(name, macro, element, scope, inner);
    const std::string reason = "in macro '" + name + "', called at " + place();
    const int line = line_;
    {
      const Frame frame(*this, macro.file, reason);
      expand_children(*macro.body, into, inner);
    }
    line_ = line;
  }

  void pass_values(const std::string& name, const Macro& macro, const XMLElement& element, Scope& scope, Scope& inner) {
    for (const auto* attribute = element.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
      if (element.Name() == std::string_view{"xacro:call"} && attribute->Name() == std::string_view{"macro"}) continue;
      std::vector<std::string> names;
      for (const auto& parameter : macro.parameters) {
        if (parameter.stars == 0) names.push_back(parameter.name);
      }
      if (std::find(names.begin(), names.end(), attribute->Name()) == names.end())
        fail_here(fmt::format("the macro '{}' has no parameter '{}'", name, attribute->Name()),
                  suggestion(attribute->Name(), names));
      inner.set(attribute->Name(), {escaped(text_of(attribute->Value(), scope)), false, {}});
    }
    for (const auto& parameter : macro.parameters) {
      if (parameter.stars != 0 || inner.has_own(parameter.name)) continue;
      if (parameter.from_outside && scope.find(parameter.name) != nullptr) {
        const Property& outside = *scope.find(parameter.name);
        inner.set(parameter.name, outside.is_block
                                      ? outside
                                      : Property{escaped(text_of("${" + parameter.name + "}", scope)), false, {}});
      } else if (parameter.has_default) {
        inner.set(parameter.name, {escaped(text_of(parameter.default_text, inner)), false, {}});
      } else {
        fail_here("the macro '" + name + "' needs the parameter '" + parameter.name + "'");
      }
    }
  }

  /// A text that evaluates to itself.
  static std::string escaped(const std::string& text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '$' && i + 1 < text.size() && (text[i + 1] == '{' || text[i + 1] == '(')) out += '$';
      out += text[i];
    }
    return out;
  }

  void pass_blocks(const std::string& name, const Macro& macro, const XMLElement& element, Scope& scope, Scope& inner) {
    const XMLElement* child = element.FirstChildElement();
    for (const auto& parameter : macro.parameters) {
      if (parameter.stars == 0) continue;
      if (child == nullptr)
        fail_here("the macro '" + name + "' needs the block '" + parameter.name + "'", "put an element into its call");
      // *: the element itself; **: what is in it.
      Block block = nullptr;
      if (parameter.stars == 2) {
        block = evaluated_block(*child, scope);
      } else {
        documents_.push_back(std::make_unique<XMLDocument>());
        if (documents_.size() > 20000) fail_here("there are more than 20000 blocks");
        XMLElement* const holder = documents_.back()->NewElement("block");
        documents_.back()->InsertEndChild(holder);
        const int line = line_;
        expand_node(*child, *holder, scope);
        line_ = line;
        block = holder;
      }
      inner.set(parameter.name, {"", true, {block}});
      child = child->NextSiblingElement();
    }
    if (child != nullptr)
      fail_here(fmt::format("the macro '{}' does not take the block <{}>", name, child->Name()),
                "it declares one as *name in its params");
  }

  void check_arguments(const std::string& path) const {
    for (const auto& [name, value] : given_) {
      if (defaults_.count(name) != 0 || std::find(asked_.begin(), asked_.end(), name) != asked_.end()) continue;
      std::vector<std::string> names;
      for (const auto& [key, fallback] : defaults_) names.push_back(key);
      throw Failure{{path, "declares no argument '" + name.substr(0, 60) + "'", suggestion(name.substr(0, 60), names)}};
    }
  }

  const std::map<std::string, std::string>& given_;
  const XacroEnvironment& environment_;
  std::map<std::string, std::optional<std::string>> defaults_;
  std::vector<std::string> asked_;
  std::map<std::string, Macro> macros_;
  std::vector<std::unique_ptr<XMLDocument>> documents_;  // what macros and blocks point into
  std::vector<Trail> trail_;
  std::vector<Reading> being_read_;
  std::vector<std::string> warnings_;
  int line_ = 0;
  std::size_t elements_ = 0, depth_ = 0, reads_ = 0;
};

Result<std::string, Problem> read_whole(const std::string& path) {
  std::error_code fault;
  if (std::filesystem::is_directory(path, fault)) return err(Problem{path, "is a folder", "give a file"});
  std::ifstream file(path, std::ios::binary);
  if (!file) return err(Problem{path, "cannot be read", "is it there, and may this user read it?"});
  std::string text;
  for (char block[65536]; file.read(block, sizeof block) || file.gcount() > 0;) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxFileBytes)
      return err(Problem{path, "is larger than 16 MiB, which no robot description is", ""});
  }
  return text;
}

}  // namespace

XacroEnvironment machine(std::vector<std::string> prefixes) {
  return {read_whole,
          [prefixes = std::move(prefixes)](const std::string& package) {
            for (const auto& prefix : prefixes) {
              std::error_code fault;
              std::string folder = prefix + "/share/" + package;
              if (package.find('/') == std::string::npos && std::filesystem::is_directory(folder, fault)) return folder;
            }
            return std::string{};
          },
          [](const std::string& name) {
            const char* const value = std::getenv(name.c_str());
            return value == nullptr ? std::nullopt : std::optional<std::string>{value};
          }};
}

Result<XacroResult, Problem> expand_xacro(const std::string& path, const std::map<std::string, std::string>& arguments,
                                          const XacroEnvironment& environment) {
  try {
    return Expander{arguments, environment}.expand(path);
  } catch (const Failure& failure) { return err(failure.problem); }
}

}  // namespace nacelle::description
