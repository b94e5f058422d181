// SPDX-License-Identifier: Apache-2.0
#include <tinyxml2.h>

#include "element.hpp"
#include "nacelle/base/xml.hpp"
#include "nacelle/launch/launch_fault.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::launch {
namespace {

constexpr std::size_t kMaxXmlBytes = kMaxYamlBytes;
constexpr std::size_t kMaxXmlElements = kMaxYamlNodes;

class XmlFront {
 public:
  explicit XmlFront(const std::string& file) : file_(file) {}

  // The recursion is as deep as the document, which parse_xml() bounds.
  void read(const tinyxml2::XMLElement& from, Element& into) {
    if (++elements_ > kMaxXmlElements) return;
    into.name = from.Name();
    into.line = from.GetLineNum();
    for (const auto* a = from.FirstAttribute(); a != nullptr; a = a->Next()) {
      if (into.attributes.size() >= 200)
        return report(a->GetLineNum(), LaunchFault::TooMuch, "more than 200 attributes");
      if (into.find(a->Name()) != nullptr)
        report(a->GetLineNum(), LaunchFault::Twice, std::string("the attribute '") + a->Name() + "' stands here twice");
      into.attributes.push_back({a->Name(), a->GetLineNum(), false, {{a->Value(), false, a->GetLineNum()}}});
    }
    for (const auto* node = from.FirstChild(); node != nullptr; node = node->NextSibling()) {
      if (const auto* child = node->ToElement(); child != nullptr) {
        into.children.emplace_back();
        read(*child, into.children.back());
      } else if (node->ToText() != nullptr) {
        report(node->GetLineNum(), LaunchFault::Misplaced, "text inside <" + into.name + ">", "values are attributes");
      }
    }
  }
  void report(int line, LaunchFault fault, std::string what, std::string way_out = {}) {
    if (problems.size() < 100) problems.push_back({Place(file_, line), std::move(what), std::move(way_out), fault});
  }
  [[nodiscard]] bool too_many() const { return elements_ > kMaxXmlElements; }
  std::vector<Problem> problems;

 private:
  const std::string& file_;
  std::size_t elements_ = 0;
};

}  // namespace

Result<Element, std::vector<Problem>> read_xml(std::string_view text, const std::string& file) {
  if (text.size() > kMaxXmlBytes) {
    return err(std::vector<Problem>{
        {file, "the file has more than " + std::to_string(kMaxXmlBytes) + " bytes", "", LaunchFault::TooMuch}});
  }
  tinyxml2::XMLDocument document;
  if (auto parsed = parse_xml(document, text, file); !parsed)
    return err(std::vector<Problem>{coded(parsed.error(), LaunchFault::Form)});
  XmlFront front(file);
  const auto* root = document.RootElement();
  if (std::string_view(root->Name()) != "launch") {
    front.report(root->GetLineNum(), LaunchFault::Form, std::string("the root element is <") + root->Name() + ">",
                 "it must be <launch>");
  }
  if (root->NextSiblingElement() != nullptr) {
    front.report(root->NextSiblingElement()->GetLineNum(), LaunchFault::Twice, "a second root element",
                 "put all into one <launch>");
  }
  Element launch;
  if (front.problems.empty()) front.read(*root, launch);
  if (front.too_many())
    front.report(root->GetLineNum(), LaunchFault::TooMuch,
                 "more than " + std::to_string(kMaxXmlElements) + " elements");
  if (!front.problems.empty()) return err(std::move(front.problems));
  return launch;
}

Result<Element, std::vector<Problem>> read_launch_file(std::string_view text, const std::string& file) {
  if (file.ends_with(".xml")) return read_xml(text, file);
  if (file.ends_with(".yaml") || file.ends_with(".yml")) return read_yaml(text, file);
  if (file.ends_with(".py")) {
    return err(std::vector<Problem>{{file, "a launch file in Python is a program, which Nacelle does not run",
                                     "write the same in YAML or XML", LaunchFault::Refused}});
  }
  return err(std::vector<Problem>{
      {file, "the name says neither YAML nor XML", "name it .launch.yaml or .launch.xml", LaunchFault::Unreadable}});
}

}  // namespace nacelle::launch
