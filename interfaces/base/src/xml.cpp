// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/xml.hpp"

#include <tinyxml2.h>

#include <string>
#include <utility>

#include "nacelle/base/nesting.hpp"

namespace nacelle {
namespace {

/// "a" of "Error=XML_ERROR_MISMATCHED_ELEMENT ErrorID=14 (0xe) Line number=1: XMLElement name=a".
std::string element_named_in(std::string_view words) {
  constexpr std::string_view kKey = "name=";
  const auto at = words.find(kKey);
  return std::string{at == std::string_view::npos ? "" : words.substr(at + kKey.size()).substr(0, 60)};
}

Problem too_deep() {
  return {"", "the elements are nested deeper than " + std::to_string(kMostNesting) + " levels", ""};
}

/// The first element that is nested too deeply. The parser's own bound, which keeps this tree finite, differs between its releases.
const tinyxml2::XMLElement* deeper_than_allowed(const tinyxml2::XMLDocument& document) {
  const tinyxml2::XMLElement* at = document.RootElement();
  int depth = 1;
  while (at != nullptr) {
    if (depth > kMostNesting) return at;
    if (const auto* const child = at->FirstChildElement(); child != nullptr) {
      at = child;
      ++depth;
      continue;
    }
    while (at != nullptr && at->NextSiblingElement() == nullptr) {
      const auto* const above = at->Parent();
      at = above == nullptr ? nullptr : above->ToElement();
      --depth;
    }
    if (at != nullptr) at = at->NextSiblingElement();
  }
  return nullptr;
}

Problem problem_of(const tinyxml2::XMLDocument& document) {
  switch (document.ErrorID()) {
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      // The line is that of the element's begin; where its end should have been cannot be known.
      return {"",
              "the element <" + element_named_in(document.ErrorStr()) +
                  "> that begins here is not closed by its own </...>",
              "close it"};
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED: return too_deep();
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT: return {"", "this is not XML: there is no element in it", ""};
    case tinyxml2::XML_ERROR_PARSING_ELEMENT: return {"", "this is not XML: an element is not complete", ""};
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return {"", "this is not XML: an attribute is not complete, or stands twice", "write name=\"value\""};
    case tinyxml2::XML_ERROR_PARSING_TEXT:
      return {"", "this is not XML: a text does not end", "is an element left open?"};
    case tinyxml2::XML_ERROR_PARSING_CDATA: return {"", "this is not XML: a <![CDATA[ does not end", "end it with ]]>"};
    case tinyxml2::XML_ERROR_PARSING_COMMENT: return {"", "this is not XML: a comment does not end", "end it with -->"};
    case tinyxml2::XML_ERROR_PARSING_DECLARATION:
      return {"", "this is not XML: a <?...?> does not end, or does not come first", ""};
    case tinyxml2::XML_ERROR_PARSING_UNKNOWN: return {"", "this is not XML: a <!...> does not end", ""};
    default: return {"", "this is not XML", ""};
  }
}

}  // namespace

Result<void, Problem> parse_xml(tinyxml2::XMLDocument& document, std::string_view text, const std::string& file) {
  document.Parse(text.data(), text.size());
  if (!document.Error() && document.RootElement() == nullptr)
    return err(Problem{Place(file, 0), "this is not XML: there is no element in it", ""});
  if (!document.Error()) {
    const auto* const deep = deeper_than_allowed(document);
    if (deep == nullptr) return {};
    Problem problem = too_deep();
    problem.where = {file, deep->GetLineNum()};
    return err(std::move(problem));
  }
  Problem problem = problem_of(document);
  problem.where = {file, document.ErrorLineNum()};
  return err(std::move(problem));
}

std::string xml_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace nacelle
