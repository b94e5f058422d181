// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <variant>

#include "nacelle/base/bell.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::desk {

/// The answer to a request that has to wait for a component: the main thread goes on with others meanwhile.
/// Threads: the main thread's, but for the bell.
struct LateReply {
  /// Rung when the answer is ready.
  std::shared_ptr<Bell> bell = std::make_shared<Bell>();
  /// Called once, when the bell has been rung. Owns what the answer comes from: with it goes the question.
  std::function<nlohmann::json()> finish;
  MonotonicTime due;  ///< The caller waits no longer than this ...
  Problem too_late;   ///< ... and this is the answer then.
};

/// What a request is answered: at once, or later.
using Answer = std::variant<nlohmann::json, std::unique_ptr<LateReply>>;

}  // namespace nacelle::desk
