// SPDX-License-Identifier: Apache-2.0
// Any text as a tolerance file: it is refused with a place and a reason, or each of its rules can be asked for, and decides where its own
// path leads.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "nacelle/base/bytes.hpp"
#include "record/model/tolerances.hpp"

namespace nacelle::record {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

ToleranceScope at(ToleranceScope scope, const std::vector<PathStep>& steps) {
  for (const PathStep& step : steps)
    scope = step.kind == PathStep::Kind::Field ? scope.field(step.name) : scope.element(step.index);
  return scope;
}

void look_at(std::string_view text) {
  const auto parsed = Tolerances::parse(text, "any.yaml");
  if (!parsed) return require(parsed.error().where.file == "any.yaml" && !parsed.error().what.empty());
  for (const auto& [topic, rules] : parsed->rules()) {
    require(topic == "*" || topic.starts_with('/'));
    for (const ToleranceRule& rule : rules) {
      require(std::isfinite(rule.allowance.tolerance) && rule.allowance.tolerance >= 0.0);
      require(!rule.steps.empty() && parse_field_path(rule.path).value() == rule.steps);
      const Allowance found = at(parsed->of_topic(topic), rule.steps).allowance();
      // A rule of the same length may come later; that is one of those that have this path or "[*]" in it.
      const auto decides = [&](const ToleranceRule& other) {
        return other.steps.size() == rule.steps.size() && other.allowance.tolerance == found.tolerance &&
               other.allowance.ignore == found.ignore;
      };
      const auto all = parsed->rules().find("*");
      require(std::any_of(rules.begin(), rules.end(), decides) ||
              (all != parsed->rules().end() && std::any_of(all->second.begin(), all->second.end(), decides)));
    }
  }
}

}  // namespace
}  // namespace nacelle::record

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 4096) return 0;  // each rule is looked for among all
  nacelle::record::look_at(nacelle::as_text({data, size}));
  return 0;
}
