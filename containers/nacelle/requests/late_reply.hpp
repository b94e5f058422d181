// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <variant>

#include "nacelle/base/bell.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::requests {

/// The pending answer to a request that waits for a component, while the main thread continues with other requests.
/// Threads: the main thread's, except the bell.
struct LateReply {
  /// Rung when the answer is ready.
  std::shared_ptr<Bell> bell = std::make_shared<Bell>();
  /// Called once after the bell has rung. Owns the source of the answer: destroying it cancels the request.
  std::function<nlohmann::json()> finish;
  MonotonicTime due;  ///< The caller waits at most until this time.
  Problem too_late;   ///< The answer after that.
};

/// The answer to a request: immediate, or later.
using Answer = std::variant<nlohmann::json, std::unique_ptr<LateReply>>;

}  // namespace nacelle::requests
