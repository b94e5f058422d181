// SPDX-License-Identifier: Apache-2.0
#include "security/policy_includes.hpp"

#include <tinyxml2.h>

#include <memory>
#include <string_view>
#include <vector>

#include "nacelle/base/xml.hpp"
#include "security/files.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

using tinyxml2::XMLElement;
using Document = std::unique_ptr<tinyxml2::XMLDocument>;

constexpr int kMostWithinEachOther = 8;
constexpr std::string_view kInclude = "xi:include";

Place place_of(const std::filesystem::path& file, const XMLElement& element) {
  return {file.string(), element.GetLineNum()};
}

/// The children of `above` with a name; "*" is any.
std::vector<const XMLElement*> named(const tinyxml2::XMLNode& above, const std::string& name) {
  std::vector<const XMLElement*> found;
  const char* const filter = name == "*" ? nullptr : name.c_str();
  for (auto* one = above.FirstChildElement(filter); one != nullptr; one = one->NextSiblingElement(filter))
    found.push_back(one);
  return found;
}

/// What "xpointer(/profile/*)" leads to in a document; without one its root. Errors: another form.
Result<std::vector<const XMLElement*>, Problem> selected(const tinyxml2::XMLDocument& document, std::string path) {
  if (path.empty()) return named(document, "*");
  if (!path.starts_with("xpointer(/") || !path.ends_with(')') || path.find("//") != path.npos)
    return err(Problem{"", "the xpointer '" + path.substr(0, 80) + "' is none that is read here",
                       "xpointer(/profile/*)", PolicyFault::WrongValue, path});
  path = path.substr(std::string_view("xpointer(").size());
  path.back() = '/';
  std::vector<const XMLElement*> found;
  for (std::size_t at = 1; at < path.size();) {
    const std::size_t end = path.find('/', at);
    const std::string name = path.substr(at, end - at);
    std::vector<const XMLElement*> below = at == 1 ? named(document, name) : std::vector<const XMLElement*>{};
    for (const XMLElement* one : found) {
      for (const XMLElement* child : named(*one, name)) below.push_back(child);
    }
    found = std::move(below);
    at = end + 1;
  }
  return found;
}

Result<Document, Problem> load(const std::filesystem::path& file, int depth);

/// Replaces an include element with the elements that it includes.
Result<void, Problem> replace(XMLElement& include, const std::filesystem::path& file, int depth) {
  const char *const href = include.Attribute("href"), *const pointer = include.Attribute("xpointer");
  if (href == nullptr)
    return err(Problem{place_of(file, include), "an include needs 'href'", "", PolicyFault::MissingAttribute});
  auto other = load(file.parent_path() / href, depth + 1);
  if (!other) return err(other.error());
  const auto parts = selected(*other.value(), pointer == nullptr ? "" : pointer);
  if (!parts) return err(moved(parts.error(), place_of(file, include), parts.error().way_out));
  tinyxml2::XMLNode* const above = include.Parent();
  tinyxml2::XMLNode* last = &include;
  for (const XMLElement* one : parts.value())
    last = above->InsertAfterChild(last, one->DeepClone(include.GetDocument()));
  above->DeleteChild(&include);
  return {};
}

Result<void, Problem> expand(tinyxml2::XMLNode& above, const std::filesystem::path& file, int depth) {
  for (auto* one = above.FirstChildElement(); one != nullptr;) {
    XMLElement* const next = one->NextSiblingElement();
    auto done = one->Name() == kInclude ? replace(*one, file, depth) : expand(*one, file, depth);
    if (!done) return done;
    one = next;
  }
  return {};
}

Result<Document, Problem> load(const std::filesystem::path& file, int depth) {
  if (depth > kMostWithinEachOther)
    return err(Problem{Place(file.string(), 0), "too many files include each other", "", PolicyFault::NestedIncludes});
  const auto xml = read_file(file);
  if (!xml) return err(xml.error());
  auto document = std::make_unique<tinyxml2::XMLDocument>();
  if (auto parsed = parse_xml(*document, xml.value(), file.string()); !parsed) {
    Problem problem = parsed.error();
    problem.code = PolicyFault::Malformed;
    return err(std::move(problem));
  }
  if (auto expanded = expand(*document, file, depth); !expanded) return err(expanded.error());
  return document;
}

}  // namespace

Result<std::string, Problem> read_with_includes(const std::filesystem::path& file) {
  auto xml = read_file(file);
  if (!xml || xml.value().find(kInclude) == std::string::npos) return xml;
  const auto document = load(file, 1);
  if (!document) return err(document.error());
  tinyxml2::XMLPrinter text;
  document.value()->Print(&text);
  return std::string(text.CStr());
}

}  // namespace nacelle::security
