// SPDX-License-Identifier: Apache-2.0
#include "nacelle/host/remap_notes.hpp"

namespace nacelle {
namespace {

thread_local RemapNotes* innermost = nullptr;

}  // namespace

RemapNotes::RemapNotes(std::size_t rules) : used_(rules), outer_(innermost) { innermost = this; }
RemapNotes::~RemapNotes() { innermost = outer_; }

void RemapNotes::note(std::string_view full_name, const std::vector<RemapRule>& rules, RemapKind kind,
                      const RemapContext& context) {
  if (innermost == nullptr || innermost->used_.size() != rules.size()) return;
  const auto apply = kind == RemapKind::Service ? remap_service : remap_topic;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    // The first rule that fits decides; each one alone says whether it does.
    const auto changed = apply(full_name, {rules[i]}, context);
    if (!changed || *changed == full_name) continue;
    innermost->used_[i] = true;
    return;
  }
}

}  // namespace nacelle
