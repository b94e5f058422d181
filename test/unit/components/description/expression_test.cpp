// SPDX-License-Identifier: Apache-2.0
// Expected values: what python3 prints for the same expression.
#include "description/src/expression.hpp"

#include <gtest/gtest.h>

namespace nacelle::description {
namespace {

std::string answer(std::string_view expression) {
  const Names names = [](std::string_view name) -> Result<Value, std::string> {
    if (name == "x") return Value{std::int64_t{4}};
    if (name == "name") return Value{std::string{"left"}};
    if (name == "order") return Value{1.5};
    return err("there is no property '" + std::string(name) + "'");
  };
  auto value = evaluate(expression, names);
  return value ? to_text(*value) : "! " + value.error();
}

TEST(Expression, counts_as_python_does) {
  const std::pair<const char*, const char*> cases[]{
      {"1 + 2 * 3", "7"},
      {"(1 + 2) * 3", "9"},
      {"3 / 2", "1.5"},
      {"4 / 2", "2.0"},
      {"-7 // 2", "-4"},
      {"7 // -2.0", "-4.0"},
      {"-7 % 3", "2"},
      {"7 % -3", "-2"},
      {"-7.5 % 2", "0.5"},
      {"2 ** 10", "1024"},
      {"2 ** -1", "0.5"},
      {"-2 ** 2", "-4"},
      {"2 ** 3 ** 2", "512"},
      {"0.1 + 0.2", "0.30000000000000004"},
      {"1e-5", "1e-05"},
      {"1e16", "1e+16"},
      {"1e15", "1000000000000000.0"},
      {"1 - -1", "2"},
      {"x/2", "2.0"},
      {"order * 2", "3.0"},
      {"pi/2", "1.5707963267948966"},
      {"sin(pi/6)", "0.49999999999999994"},
      {"math.radians(180)", "3.141592653589793"},
      {"max(1, 2.5, x)", "4"},
      {"min(1, 2.5)", "1"},
      {"abs(-3)", "3"},
      {"round(2.5)", "2"},
      {"int('7') + 1", "8"},
      {"str(1) + 'a'", "1a"},
      {"'a' + \"b\"", "ab"},
      {"len(name)", "4"},
      {"9223372036854775807 + 1", "9.223372036854776e+18"},
  };
  for (const auto& [expression, expected] : cases) EXPECT_EQ(answer(expression), expected) << expression;
}

TEST(Expression, decides_as_python_does) {
  const std::pair<const char*, const char*> cases[]{
      {"1 < 2", "True"},
      {"x == 4.0", "True"},
      {"name == 'left'", "True"},
      {"name != 'left'", "False"},
      {"name == 4", "False"},
      {"not x", "False"},
      {"x and 0", "0"},
      {"0 or 'b'", "b"},
      {"1 if name == 'left' else -1", "1"},
      {"1 if name == 'right' else -1", "-1"},
      {"true and True", "True"},
      {"0 and missing", "0"},
      {"1 or missing", "1"},
  };
  for (const auto& [expression, expected] : cases) EXPECT_EQ(answer(expression), expected) << expression;
}

TEST(Expression, names_the_part_that_it_cannot_parse) {
  const std::pair<const char*, const char*> cases[]{
      {"1 +", "! it ends too early"},
      {"1 2", "! '2' is not understood there"},
      {"(1", "! a ')' is missing"},
      {"'a", "! a quotation mark is not closed"},
      {"1 / 0", "! division by zero"},
      {"1 % 0.0", "! division by zero"},
      {"missing", "! there is no property 'missing'"},
      {"sine(1)", "! there is no function 'sine'; did you mean 'sin'?"},
      {"sin(1, 2)", "! sin() takes 1 argument, not 2"},
      {"sin('a')", "! sin() needs numbers, not 'a'"},
      {"sqrt(-1)", "! sqrt() has no value there"},
      {"'a' * 2", "! '*' does not go with 'a' and 2"},
      {"'a' < 2", "! a number and a text have no order: 'a', 2"},
      {"[1, 2]", "! lists and dictionaries are not available; use one property each"},
      {"x[0]", "! lists and dictionaries are not available; use one property each"},
      {"1 if 2", "! `if` lacks its `else`"},
  };
  for (const auto& [expression, expected] : cases) EXPECT_EQ(answer(expression), expected) << expression;
}

TEST(Expression, ends_for_any_depth) {
  for (const char* piece : {"(", "-", "not ", "2**", "1 if ", "sin("}) {
    std::string deep;
    for (int i = 0; i < 20000; ++i) deep += piece;
    EXPECT_EQ(answer(deep).substr(0, 2), "! ") << piece;
  }
}

}  // namespace
}  // namespace nacelle::description
