// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tinyxml2.h>

#include <deque>
#include <set>
#include <string>
#include <vector>

#include "trail.hpp"

namespace nacelle::description {

/// Which line of which file each element of a result stands for, kept beside it until the result is whole.
/// Outlives the documents whose elements it knows.
class Places {
 public:
  void remember(tinyxml2::XMLElement& made, const Trail& trail) {
    places_.push_back({&*files_.insert(trail.file()).first, trail.line});
    made.SetUserData(&places_.back());
  }
  /// `to` is a deep copy of `from`.
  static void copy(const tinyxml2::XMLNode& from, tinyxml2::XMLNode& to) {
    to.SetUserData(from.GetUserData());
    const tinyxml2::XMLNode* source = from.FirstChild();
    for (auto* child = to.FirstChild(); child != nullptr; child = child->NextSibling()) {
      copy(*source, *child);
      source = source->NextSibling();
    }
  }
  /// "robot.xacro:30" of the element and of all below it, in their order.
  static void collect(const tinyxml2::XMLElement& element, std::vector<Place>& into) {
    const auto& place = *static_cast<const Line*>(element.GetUserData());
    into.push_back({*place.file, place.line});
    for (const auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement())
      collect(*child, into);
  }

 private:
  struct Line {
    const std::string* file;
    int line;
  };
  std::set<std::string> files_;  // both keep their entries where they are
  std::deque<Line> places_;
};

}  // namespace nacelle::description
