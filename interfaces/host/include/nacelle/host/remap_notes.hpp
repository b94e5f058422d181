// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/names.hpp"

namespace nacelle {

/// Notes which remap rules changed a name, while it lives: a rule that changed none in a constructor is a slip of the pen.
///
/// Threads: one; what nodes on other threads resolve is not noted. Notes may be nested, the innermost counts.
class RemapNotes {
 public:
  explicit RemapNotes(std::size_t rules);
  ~RemapNotes();
  RemapNotes(const RemapNotes&) = delete;
  RemapNotes& operator=(const RemapNotes&) = delete;

  /// By the rule's place in the node's list: it turned a name of a topic or service into another one.
  [[nodiscard]] const std::vector<bool>& used() const { return used_; }

  /// Called by a node for each name that it resolves.
  static void note(std::string_view full_name, const std::vector<RemapRule>& rules, RemapKind kind,
                   const RemapContext& context);

 private:
  std::vector<bool> used_;
  RemapNotes* const outer_;
};

}  // namespace nacelle
