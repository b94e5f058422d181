// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "record/model/field_path.hpp"

namespace nacelle::record {

/// Why a tolerance file is refused. Problem::where is its line.
enum class ToleranceFault : std::uint8_t {
  WrongShape,  ///< Not a map of topics, each with a map of field paths, or a key of neither kind.
  WrongPath,   ///< A path that cannot be parsed, or that leads to no field of the topic's type.
  WrongValue,  ///< A tolerance that is no finite number of at least 0, or an `ignore` that is no bool.
};
[[nodiscard]] constexpr const char* code_text(ToleranceFault fault) {
  switch (fault) {
    case ToleranceFault::WrongShape: return "tolerance.wrong_shape";
    case ToleranceFault::WrongPath: return "tolerance.wrong_path";
    case ToleranceFault::WrongValue: return "tolerance.wrong_value";
  }
  return "";
}

/// By how much two values of a field may differ.
struct Allowance {
  double tolerance = 0.0;  ///< Absolute, in the field's unit; of times in s.
  bool ignore = false;     ///< They are not compared at all.
};

/// A field path of a tolerance file.
struct ToleranceRule {
  std::string path;
  std::vector<PathStep> steps;
  Allowance allowance;
  int line = 0;
};

/// The rules that still apply while a message is walked from its root to a field.
class ToleranceScope {
 public:
  ToleranceScope() = default;
  explicit ToleranceScope(std::vector<const ToleranceRule*> rules) : open_(std::move(rules)) {}

  /// Returns what is allowed here: as the longest path that leads here or to a field around it says; of equally long ones the last.
  [[nodiscard]] const Allowance& allowance() const { return allowance_; }
  [[nodiscard]] ToleranceScope field(std::string_view name) const;
  [[nodiscard]] ToleranceScope element(std::size_t index) const;
  /// Returns whether no rule tells the elements of this list apart.
  [[nodiscard]] bool elements_are_alike() const;

 private:
  template <typename Fits>
  [[nodiscard]] ToleranceScope inside(Fits fits) const;

  std::size_t depth_ = 0;
  Allowance allowance_;
  std::vector<const ToleranceRule*> open_;  // that reach deeper
};

/// Reads tolerances of fields:
///
///   "*":                             # every topic
///     header.stamp: {ignore: true}
///   /odom:
///     pose.pose.position: 0.001      # of each field in it
///     pose.covariance[*]: 1e-9
///
/// Scopes point into it. Threads: constant.
class Tolerances {
 public:
  /// Errors: a ToleranceFault, or that of parse_yaml().
  [[nodiscard]] static Result<Tolerances, Problem> parse(std::string_view yaml, const std::string& file_name);

  /// Returns the rules of a topic, those of "*" before its own.
  [[nodiscard]] ToleranceScope of_topic(const std::string& topic) const;
  /// The rules of each topic, and those of "*".
  [[nodiscard]] const std::map<std::string, std::vector<ToleranceRule>>& rules() const { return rules_; }
  /// Checks that the topic's own rules lead to fields of its type. Errors: ToleranceFault::WrongPath.
  [[nodiscard]] Result<void, Problem> check(const std::string& topic, const msgs::MessageType& type) const;

 private:
  std::string file_;
  std::map<std::string, std::vector<ToleranceRule>> rules_;
};

}  // namespace nacelle::record
