// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::record {

/// Which topics are wanted, in the words of `ros2 bag record`.
struct TopicWish {
  bool all = false;
  std::vector<std::string> topics;          ///< Full names.
  std::string regex;                        ///< And topics in which this is found; empty: none.
  std::string exclude_regex;                ///< But none in which this is found; empty: none.
  std::vector<std::string> exclude_topics;  ///< Nor these.
  bool hidden = false;                      ///< Of all and of `regex`, those of which a part begins with '_', too.
};

/// Decides which topics are taken. A topic that is named is taken although it is hidden.
class TopicChoice {
 public:
  /// Errors: a regular expression (ECMAScript) that is none; `where` is "regex" or "exclude_regex".
  [[nodiscard]] static Result<TopicChoice, Problem> make(TopicWish wish);
  /// Returns the topics that are wanted by their names.
  [[nodiscard]] const std::vector<std::string>& named() const { return wish_.topics; }
  [[nodiscard]] bool takes(const std::string& topic) const;
  /// Returns whether it is taken by its name or by the regular expression, and not only because all are.
  [[nodiscard]] bool picks(const std::string& topic) const;
  /// Returns whether any topic can be taken at all.
  [[nodiscard]] bool is_any() const { return wish_.all || !wish_.topics.empty() || by_.has_value(); }

 private:
  [[nodiscard]] bool is_found(const std::string& topic) const;
  explicit TopicChoice(TopicWish wish) : wish_(std::move(wish)) {}

  TopicWish wish_;
  std::optional<std::regex> by_, without_;
};

}  // namespace nacelle::record
