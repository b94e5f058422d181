// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace tinyxml2 {
class XMLDocument;
}

namespace nacelle {

/// Reads XML into `document`: the one way in which an XML text becomes a tree (test/policy/check_tree.py). Its depth is
/// bounded while it is parsed, so that recursion over it is bounded, too.
///
/// Errors: no well-formed XML, or deeper than kMostNesting, in words that do not depend on the parser's version; `where` is "<file>:<line>".
/// A text without any element is an error.
[[nodiscard]] Result<void, Problem> parse_xml(tinyxml2::XMLDocument& document, std::string_view text,
                                              const std::string& file);

/// Returns the text as it stands between tags or in an attribute with double quotes.
[[nodiscard]] std::string xml_escaped(std::string_view text);

}  // namespace nacelle
