// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/clock_skews.hpp"

namespace nacelle {

std::string ClockSkew::text() const {
  if (!*this) return {};
  const bool is_ahead = ahead_ > Duration::zero();
  const Duration by = is_ahead ? ahead_ : -ahead_;
  const std::string size = by < 10s ? std::to_string(by / 1ms) + " ms " : std::to_string(by / 1s) + " s ";
  return "host " + std::string(host()) + " is " + size +
         (is_ahead      ? "ahead"
          : is_certain_ ? "behind"
                        : "behind, or its messages come that late");
}

std::string as_cause(const ClockSkew& skew) { return skew ? "; clock skew: " + skew.text() : std::string{}; }

void ClockSkews::replace(Table table) {
  any_ = !table.empty();
  *table_.lock() = std::move(table);
}

ClockSkew ClockSkews::of_writer(std::uint64_t writer_id) const {
  if (!any_) return {};
  auto table = table_.lock();
  const auto found = table->find(writer_id);
  return found == table->end() ? ClockSkew{} : found->second;
}

std::string ClockSkews::cause(std::uint64_t writer_id) const { return as_cause(of_writer(writer_id)); }

std::shared_ptr<void> make_clock_skews() { return std::make_shared<ClockSkews>(); }

}  // namespace nacelle
