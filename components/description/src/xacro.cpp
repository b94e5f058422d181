// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/xacro.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "macro_parameters.hpp"
#include "nacelle/base/xml.hpp"
#include "places.hpp"
#include "scope.hpp"
#include "texts.hpp"
#include "trail.hpp"

namespace nacelle::description {
namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;
using tinyxml2::XMLNode;

constexpr std::size_t kMaxFiles = 200;
constexpr std::size_t kMaxElements = 200000;  // of the result
constexpr std::size_t kMaxNesting = 400;      // of elements, those of xacro and of macros on the way included

struct Macro {
  std::vector<Parameter> parameters;
  const XMLElement* body = nullptr;
  std::string file;
};

bool is_blank(std::string_view text) { return text.find_first_not_of(" \t\r\n") == std::string_view::npos; }

/// "xacro:macro" -> "macro"; empty for elements of the result.
std::string_view xacro_name(const XMLElement& element) {
  const std::string_view name = element.Name();
  return name.starts_with("xacro:") ? name.substr(6) : std::string_view{};
}

class Expander {
 public:
  Expander(const std::map<std::string, std::string>& arguments, const XacroEnvironment& environment)
      : environment_(environment), texts_(trail_, arguments, environment) {}

  XacroResult expand(const std::string& path) {
    const XMLElement& root = load(path);
    Scope global;
    XMLDocument out;
    const Trail::Frame here(trail_, path, "");
    // The root is an element of the result like any other; only its namespace goes.
    XMLElement* const made = out.NewElement(root.Name());
    out.InsertEndChild(made);
    trail_.line = root.GetLineNum();
    places_.remember(*made, trail_);
    copy_attributes(root, *made, global);
    expand_children(root, *made, global);
    texts_.check_arguments(path);
    tinyxml2::XMLPrinter printer;
    out.Print(&printer);
    XacroResult result{"<?xml version=\"1.0\"?>\n" + std::string(printer.CStr()), std::move(warnings_), {}};
    Places::collect(*made, result.places);
    return result;
  }

 private:
  // --- files ---

  const XMLElement& load(const std::string& path) {
    if (documents_.size() >= kMaxFiles) throw Failure{{path, "more than 200 files are included", ""}};
    if (!environment_.read_file) throw Failure{{path, "cannot be read: there are no files here", ""}};
    auto text = environment_.read_file(path);
    if (!text) {
      if (!trail_.steps().empty()) trail_.fail(text.error().text());
      throw Failure{text.error()};
    }
    auto document = std::make_unique<XMLDocument>(true, tinyxml2::PRESERVE_WHITESPACE);
    const std::string& content = text.value();
    if (auto parsed = parse_xml(*document, content, path); !parsed) throw Failure{parsed.error()};
    documents_.push_back(std::move(document));
    return *documents_.back()->RootElement();
  }

  void include(const XMLElement& element, XMLNode& into, Scope& scope) {
    allow_only(element, {"filename", "optional"});
    std::string name = required(element, "filename", scope);
    const bool optional = element.Attribute("optional") != nullptr && condition(element, "optional", scope);
    if (constexpr std::string_view kScheme = "package://"; name.starts_with(kScheme)) {
      const std::string path = name.substr(kScheme.size());
      const std::size_t slash = std::min(path.find('/'), path.size());
      trail_.fail("'" + name.substr(0, 80) + "' is an address for meshes; an include takes a path",
                  "write $(find " + path.substr(0, slash) + ")" + path.substr(slash));
    }
    if (!name.starts_with('/'))
      name = (std::filesystem::path(trail_.file()).parent_path() / name).lexically_normal().string();
    for (const auto& step : trail_.steps()) {
      if (step.file == name && step.reason.find("included") != std::string::npos)
        trail_.fail("the files include each other: '" + name + "'");
    }
    if (name == trail_.steps().front().file) trail_.fail("the files include each other: '" + name + "'");
    if (optional && environment_.read_file && !environment_.read_file(name)) return;
    const std::string reason = "included at " + trail_.place();
    const XMLElement& root = load(name);
    const Trail::Frame frame(trail_, name, reason);
    expand_children(root, into, scope);
  }

  // --- attributes ---

  std::string required(const XMLElement& element, const char* name, const Scope& scope) {
    const char* const text = element.Attribute(name);
    if (text == nullptr) trail_.fail(fmt::format("<{}> needs the attribute '{}'", element.Name(), name));
    return texts_.text_of(text, scope);
  }

  void allow_only(const XMLElement& element, const std::vector<std::string>& known) const {
    for (const auto* attribute = element.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
      if (std::find(known.begin(), known.end(), attribute->Name()) != known.end()) continue;
      if (element.Name() == std::string_view{"xacro:include"} && attribute->Name() == std::string_view{"ns"})
        trail_.fail("an include with a namespace (ns) is not available", "give the file's macros names of their own");
      trail_.fail(fmt::format("<{}> has no attribute '{}'", element.Name(), attribute->Name()),
                  suggestion(attribute->Name(), known));
    }
  }

  bool condition(const XMLElement& element, const char* name, const Scope& scope) {
    const char* const text = element.Attribute(name);
    if (text == nullptr) trail_.fail(fmt::format("<{}> needs the attribute '{}'", element.Name(), name));
    Value value = texts_.evaluate_text(text, scope);
    if (const auto* word = std::get_if<std::string>(&value)) value = value_of(*word);
    if (std::holds_alternative<std::string>(value))
      trail_.fail(fmt::format("{}=\"{}\" is neither true nor false: '{}'", name, text, to_text(value).substr(0, 60)),
                  "write true, false, a number or a comparison");
    return is_true(value);
  }

  void copy_attributes(const XMLElement& from, XMLElement& to, const Scope& scope) {
    for (const auto* attribute = from.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
      if (std::string_view{attribute->Name()} == "xmlns:xacro") continue;
      to.SetAttribute(attribute->Name(), texts_.text_of(attribute->Value(), scope).c_str());
    }
  }

  // --- elements ---

  void expand_children(const XMLElement& from, XMLNode& into, Scope& scope) {
    for (const XMLNode* node = from.FirstChild(); node != nullptr; node = node->NextSibling()) {
      expand_node(*node, into, scope);
    }
  }

  void expand_node(const XMLNode& node, XMLNode& into, Scope& scope) {
    trail_.line = node.GetLineNum();
    XMLDocument& out = *into.GetDocument();
    if (const auto* text = node.ToText()) {
      if (!is_blank(text->Value())) into.InsertEndChild(out.NewText(texts_.text_of(text->Value(), scope).c_str()));
      return;
    }
    const XMLElement* const element = node.ToElement();
    if (element == nullptr) return;  // comments and declarations stay behind
    if (++depth_ > kMaxNesting) trail_.fail("elements are nested too deeply", "does a macro call itself?");
    if (const std::string_view name = xacro_name(*element); !name.empty()) {
      expand_xacro_element(name, *element, into, scope);
    } else {
      if (++elements_ > kMaxElements) trail_.fail("the result would have more than 200000 elements");
      XMLElement* const made = out.NewElement(element->Name());
      into.InsertEndChild(made);
      places_.remember(*made, trail_);
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
      if (!is_element_name(made_name)) trail_.fail("'" + made_name.substr(0, 60) + "' is not a name of an element");
      XMLElement* const made = into.GetDocument()->NewElement(made_name.c_str());
      into.InsertEndChild(made);
      places_.remember(*made, trail_);
      copy_attributes(element, *made, scope);
      made->DeleteAttribute("xacro:name");
      return expand_children(element, *made, scope);
    }
    if (name == "attribute") {
      allow_only(element, {"name", "value"});
      XMLElement* const parent = into.ToElement();
      const std::string made_name = required(element, "name", scope);
      if (parent == nullptr || !is_element_name(made_name))
        trail_.fail("'" + made_name.substr(0, 60) + "' is not a name of an attribute");
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
    if (name.empty() || name.starts_with("__")) trail_.fail("'" + name + "' is not a name of a property");
    Scope* target = &scope;
    bool is_local = true;
    if (const char* where = element.Attribute("scope")) {
      const std::string_view word = where;
      if (word != "parent" && word != "global" && word != "local")
        trail_.fail("scope cannot be '" + std::string(word.substr(0, 60)) + "'",
                    suggestion(word, {"parent", "global", "local"}));
      if (word == "global") target = &scope.root();
      if (word == "parent") target = scope.above() != nullptr ? scope.above() : &scope;
      is_local = word == "local";
    }
    Property made;
    for (const char* const text : {element.Attribute("value"), element.Attribute("default")}) {
      // An unused property would hide the problem until it is used.
      if (text != nullptr && std::string_view{text}.find("load_yaml(") != std::string_view::npos)
        trail_.fail("property '" + name.substr(0, 60) + "': load_yaml is not available",
                    "write its values as properties");
    }
    if (const char* value = element.Attribute("value")) {
      made.text = value;
      // What leaves its scope is evaluated here, where its names are known.
      if (!is_local) made.text = texts_.text_of(value, scope);
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
    texts_.declare_argument(name, std::move(value));
  }

  void macro(const XMLElement& element, Scope& scope) {
    allow_only(element, {"name", "params"});
    std::string name = required(element, "name", scope);
    if (name.starts_with("xacro:")) name.erase(0, 6);
    const char* const text = element.Attribute("params");
    auto parameters = macro_parameters(text == nullptr ? "" : text);
    if (!parameters) trail_.fail(parameters.error());
    Macro made{std::move(*parameters), &element, trail_.file()};
    for (const char* const word :
         {"property", "macro", "arg", "include", "if", "unless", "insert_block", "call", "element", "attribute"}) {
      if (name == word) trail_.fail("a macro cannot be called '" + name + "': that is a word of xacro");
    }
    if (macros_.count(name) != 0) warnings_.push_back(trail_.place() + ": the macro '" + name + "' is defined anew");
    macros_.insert_or_assign(name, std::move(made));
  }

  /// A copy of the children with everything in them done, in a document that stays.
  Block evaluated_block(const XMLElement& element, Scope& scope) {
    documents_.push_back(std::make_unique<XMLDocument>());
    XMLElement* const holder = documents_.back()->NewElement("block");
    documents_.back()->InsertEndChild(holder);
    if (documents_.size() > 20000) trail_.fail("there are more than 20000 blocks");
    const int line = trail_.line;
    expand_children(element, *holder, scope);
    trail_.line = line;
    return holder;
  }

  void insert_block(const XMLElement& element, XMLNode& into, Scope& scope) {
    allow_only(element, {"name"});
    const std::string name = required(element, "name", scope);
    const Property* const property = scope.find(name);
    if (property == nullptr) {
      std::vector<std::string> names;
      scope.append_names(names);
      trail_.fail("there is no block '" + name.substr(0, 60) + "'", suggestion(name.substr(0, 60), names));
    }
    if (!property->is_block) trail_.fail("'" + name + "' is a value, not a block", "write ${" + name + "}");
    for (const Block block : property->blocks) {
      for (const XMLNode* node = block->FirstChild(); node != nullptr; node = node->NextSibling()) {
        elements_ += count_of(*node);
        if (elements_ > kMaxElements) trail_.fail("the result would have more than 200000 elements");
        Places::copy(*node, *into.InsertEndChild(node->DeepClone(into.GetDocument())));
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
      trail_.fail("there is no macro '" + name.substr(0, 60) + "'", suggestion(name.substr(0, 60), names));
    }
    const Macro macro = found->second;  // a copy: the body may redefine it
    if (++elements_ > kMaxElements)
      trail_.fail("macros are called more than 200000 times", "does a macro call itself?");
    Scope inner(&scope);
    pass_values(name, macro, element, scope, inner);
    pass_blocks(name, macro, element, scope, inner);
    const std::string reason = "in macro '" + name + "', called at " + trail_.place();
    const Trail::Frame frame(trail_, macro.file, reason);
    expand_children(*macro.body, into, inner);
  }

  void pass_values(const std::string& name, const Macro& macro, const XMLElement& element, Scope& scope, Scope& inner) {
    for (const auto* attribute = element.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
      if (element.Name() == std::string_view{"xacro:call"} && attribute->Name() == std::string_view{"macro"}) continue;
      std::vector<std::string> names;
      for (const auto& parameter : macro.parameters) {
        if (parameter.stars == 0) names.push_back(parameter.name);
      }
      if (std::find(names.begin(), names.end(), attribute->Name()) == names.end())
        trail_.fail(fmt::format("the macro '{}' has no parameter '{}'", name, attribute->Name()),
                    suggestion(attribute->Name(), names));
      inner.set(attribute->Name(), {escaped(texts_.text_of(attribute->Value(), scope)), false, {}});
    }
    for (const auto& parameter : macro.parameters) {
      if (parameter.stars != 0 || inner.has_own(parameter.name)) continue;
      if (parameter.from_outside && scope.find(parameter.name) != nullptr) {
        const Property& outside = *scope.find(parameter.name);
        inner.set(parameter.name,
                  outside.is_block ? outside
                                   : Property{escaped(texts_.text_of("${" + parameter.name + "}", scope)), false, {}});
      } else if (parameter.has_default) {
        inner.set(parameter.name, {escaped(texts_.text_of(parameter.default_text, inner)), false, {}});
      } else {
        trail_.fail("the macro '" + name + "' needs the parameter '" + parameter.name + "'");
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
        trail_.fail("the macro '" + name + "' needs the block '" + parameter.name + "'",
                    "put an element into its call");
      // *: the element itself; **: what is in it.
      Block block = nullptr;
      if (parameter.stars == 2) {
        block = evaluated_block(*child, scope);
      } else {
        documents_.push_back(std::make_unique<XMLDocument>());
        if (documents_.size() > 20000) trail_.fail("there are more than 20000 blocks");
        XMLElement* const holder = documents_.back()->NewElement("block");
        documents_.back()->InsertEndChild(holder);
        const int line = trail_.line;
        expand_node(*child, *holder, scope);
        trail_.line = line;
        block = holder;
      }
      inner.set(parameter.name, {"", true, {block}});
      child = child->NextSiblingElement();
    }
    if (child != nullptr)
      trail_.fail(fmt::format("the macro '{}' does not take the block <{}>", name, child->Name()),
                  "it declares one as *name in its params");
  }

  const XacroEnvironment& environment_;
  Trail trail_;
  Places places_;
  Texts texts_;
  std::map<std::string, Macro> macros_;
  std::vector<std::unique_ptr<XMLDocument>> documents_;  // what macros and blocks point into
  std::vector<std::string> warnings_;
  std::size_t elements_ = 0, depth_ = 0;
};

}  // namespace

Result<XacroResult, Problem> expand_xacro(const std::string& path, const std::map<std::string, std::string>& arguments,
                                          const XacroEnvironment& environment) {
  try {
    return Expander{arguments, environment}.expand(path);
  } catch (const Failure& failure) { return err(failure.problem); }
}

}  // namespace nacelle::description
