// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "expression.hpp"

namespace tinyxml2 {
class XMLElement;
}

namespace nacelle::description {

/// XML of a document that outlives the expansion.
using Block = const tinyxml2::XMLElement*;

/// Text that is evaluated on first use, a value, or a block.
struct Property {
  std::string text;
  bool is_block = false;
  std::vector<Block> blocks;  ///< Evaluated already.
};

/// The names that can be seen: those of a macro call, then its caller's, down to the file's.
class Scope {
 public:
  explicit Scope(Scope* above = nullptr) : above_(above) {}

  [[nodiscard]] Scope* above() const { return above_; }
  [[nodiscard]] Scope& root() { return above_ == nullptr ? *this : above_->root(); }
  void set(const std::string& name, Property property) { properties_.insert_or_assign(name, std::move(property)); }
  [[nodiscard]] bool has_own(const std::string& name) const { return properties_.count(name) != 0; }
  [[nodiscard]] const Property* find(std::string_view name) const {
    const Scope* const owner = owner_of(name);
    return owner == nullptr ? nullptr : &owner->properties_.find(name)->second;
  }
  /// The innermost scope that has the name, or null.
  [[nodiscard]] const Scope* owner_of(std::string_view name) const {
    if (properties_.find(name) != properties_.end()) return this;
    return above_ == nullptr ? nullptr : above_->owner_of(name);
  }
  void append_names(std::vector<std::string>& into) const {
    for (const auto& [name, property] : properties_) into.push_back(name);
    if (above_ != nullptr) above_->append_names(into);
  }

 private:
  Scope* above_;
  std::map<std::string, Property, std::less<>> properties_;
};

}  // namespace nacelle::description
