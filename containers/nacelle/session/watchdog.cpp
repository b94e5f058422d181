// SPDX-License-Identifier: Apache-2.0
#include "session/watchdog.hpp"

#include <algorithm>

namespace nacelle::session {
namespace {

// One look may fall into a moment without progress, and the next one still comes in time.
constexpr int kFeedsPerPeriod = 4;
// Executors are compared from look to look (Container::stalled()).
constexpr Duration kShortestPause = 50ms;

}  // namespace

Watchdog::Watchdog(const process::ServiceManager& manager, std::function<std::string()> why_not, const Clock& clock,
                   Say say)
    : manager_(manager), why_not_(std::move(why_not)), clock_(clock), say_(std::move(say)) {}

void Watchdog::begin() {
  if (manager_.watchdog()) due_ = clock_.now();
}

void Watchdog::work() {
  if (!due_ || clock_.now() < *due_) return;
  due_ = clock_.now() + std::max(*manager_.watchdog() / kFeedsPerPeriod, kShortestPause);
  std::string why = why_not_();
  if (why.empty()) manager_.tell("WATCHDOG=1");
  if (why == told_) return;
  say_(why.empty() ? "nacelle: the watchdog of the service manager is fed again"
                   : "nacelle: the watchdog of the service manager is not fed: " + why);
  told_ = std::move(why);
}

}  // namespace nacelle::session
