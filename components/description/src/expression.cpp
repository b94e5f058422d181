// SPDX-License-Identifier: Apache-2.0
#include "expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::description {
namespace {

constexpr int kMaxDepth = 100;
constexpr std::size_t kMaxText = 65536;  // of a text that an expression makes

using Answer = Result<Value, std::string>;

bool is_name_start(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_name_part(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::optional<double> number_of(const Value& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? 1.0 : 0.0;
  if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
  if (const auto* d = std::get_if<double>(&value)) return *d;
  return std::nullopt;
}

std::optional<std::int64_t> integer_of(const Value& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? 1 : 0;
  if (const auto* i = std::get_if<std::int64_t>(&value)) return *i;
  return std::nullopt;
}

std::string shown(const Value& value) {
  const std::string text = to_text(value);
  return std::holds_alternative<std::string>(value) ? "'" + text.substr(0, 60) + "'" : text;
}

Answer domain_checked(const char* name, double result) {
  if (std::isnan(result)) return err(fmt::format("{}() has no value there", name));
  return Value{result};
}

/// A function of numbers; `most` arguments, at least `least`.
struct Function {
  std::string_view name;
  std::size_t least, most;
  Answer (*call)(const std::vector<Value>& arguments, const std::vector<double>& numbers);
};

Answer pick(const std::vector<Value>& values, const std::vector<double>& numbers, bool greatest) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    if (greatest ? numbers[i] > numbers[best] : numbers[i] < numbers[best]) best = i;
  }
  return values[best];
}

Answer whole(const char* name, double value) {
  if (!(std::abs(value) < 9.2e18)) return err(fmt::format("{}({}) is not a whole number", name, value));
  return Value{static_cast<std::int64_t>(value)};
}

using Values = std::vector<Value>;
using Numbers = std::vector<double>;

constexpr std::array kFunctions{
    Function{"sin", 1, 1, [](const Values&, const Numbers& x) -> Answer { return Value{std::sin(x[0])}; }},
    Function{"cos", 1, 1, [](const Values&, const Numbers& x) -> Answer { return Value{std::cos(x[0])}; }},
    Function{"tan", 1, 1, [](const Values&, const Numbers& x) -> Answer { return Value{std::tan(x[0])}; }},
    Function{"asin", 1, 1, [](const Values&, const Numbers& x) { return domain_checked("asin", std::asin(x[0])); }},
    Function{"acos", 1, 1, [](const Values&, const Numbers& x) { return domain_checked("acos", std::acos(x[0])); }},
    Function{"atan", 1, 1, [](const Values&, const Numbers& x) -> Answer { return Value{std::atan(x[0])}; }},
    Function{"atan2", 2, 2, [](const Values&, const Numbers& x) -> Answer { return Value{std::atan2(x[0], x[1])}; }},
    Function{"sqrt", 1, 1, [](const Values&, const Numbers& x) { return domain_checked("sqrt", std::sqrt(x[0])); }},
    Function{"hypot", 2, 2, [](const Values&, const Numbers& x) -> Answer { return Value{std::hypot(x[0], x[1])}; }},
    Function{"exp", 1, 1, [](const Values&, const Numbers& x) -> Answer { return Value{std::exp(x[0])}; }},
    Function{"log", 1, 1, [](const Values&, const Numbers& x) { return domain_checked("log", std::log(x[0])); }},
    Function{"log10", 1, 1, [](const Values&, const Numbers& x) { return domain_checked("log10", std::log10(x[0])); }},
    Function{"pow", 2, 2, [](const Values&, const Numbers& x) { return domain_checked("pow", std::pow(x[0], x[1])); }},
    Function{"fmod", 2, 2,
             [](const Values&, const Numbers& x) { return domain_checked("fmod", std::fmod(x[0], x[1])); }},
    Function{"fabs", 1, 1, [](const Values&, const Numbers& x) -> Answer { return Value{std::fabs(x[0])}; }},
    Function{"radians", 1, 1,
             [](const Values&, const Numbers& x) -> Answer { return Value{x[0] * std::numbers::pi / 180}; }},
    Function{"degrees", 1, 1,
             [](const Values&, const Numbers& x) -> Answer { return Value{x[0] * 180 / std::numbers::pi}; }},
    Function{"floor", 1, 1, [](const Values&, const Numbers& x) { return whole("floor", std::floor(x[0])); }},
    Function{"ceil", 1, 1, [](const Values&, const Numbers& x) { return whole("ceil", std::ceil(x[0])); }},
    Function{"round", 1, 2,
             [](const Values&, const Numbers& x) -> Answer {
               // As Python: halves to the even side; with digits a float.
               if (x.size() == 1) return whole("round", std::nearbyint(x[0]));
               const double scale = std::pow(10.0, std::clamp(std::trunc(x[1]), -300.0, 300.0));
               return Value{std::nearbyint(x[0] * scale) / scale};
             }},
    Function{"abs", 1, 1,
             [](const Values& v, const Numbers& x) -> Answer {
               if (const auto i = integer_of(v[0]); i && *i != std::numeric_limits<std::int64_t>::min())
                 return Value{*i < 0 ? -*i : *i};
               return Value{std::fabs(x[0])};
             }},
    Function{"min", 1, 16, [](const Values& v, const Numbers& x) { return pick(v, x, false); }},
    Function{"max", 1, 16, [](const Values& v, const Numbers& x) { return pick(v, x, true); }},
};

/// Recursive descent, from `a if c else b` down to names and numbers.
class Parser {
 public:
  Parser(std::string_view text, const Names& names) : text_(text), names_(names) {}

  Answer whole_expression() {
    auto value = conditional();
    if (!value) return value;
    skip_space();
    if (at_ != text_.size()) return unexpected();
    return value;
  }

 private:
  void skip_space() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool take(std::string_view token) {
    skip_space();
    if (!text_.substr(at_).starts_with(token)) return false;
    const char after = at_ + token.size() < text_.size() ? text_[at_ + token.size()] : ' ';
    if (is_name_start(token.front()) && is_name_part(after)) return false;  // `order` does not begin with `or`
    at_ += token.size();
    return true;
  }
  [[nodiscard]] char next() {
    skip_space();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  Answer unexpected() {
    skip_space();
    if (at_ == text_.size()) return err(std::string{"it ends too early"});
    return err("'" + std::string(text_.substr(at_, 20)) + "' is not understood there");
  }

  // What is skipped by `and`, `or` and `if` is parsed all the same, but its names and divisions may fail.
  Answer conditional() {
    if (++depth_ > kMaxDepth) return err(std::string{"it is nested too deeply"});
    auto value = either();
    if (value && take("if")) {
      auto condition = either();
      if (!condition) return condition;
      if (!take("else")) return err(std::string{"`if` lacks its `else`"});
      auto other = conditional();
      if (!is_true(*condition)) value = std::move(other);
    }
    --depth_;
    return value;
  }

  Answer either() {
    auto left = both();
    while (left && take("or")) {
      auto right = both();
      if (!is_true(*left)) left = std::move(right);
    }
    return left;
  }

  Answer both() {
    auto left = negation();
    while (left && take("and")) {
      auto right = negation();
      if (is_true(*left)) left = std::move(right);
    }
    return left;
  }

  Answer negation() {
    if (!take("not")) return comparison();
    if (++depth_ > kMaxDepth) return err(std::string{"it is nested too deeply"});
    auto value = negation();
    --depth_;
    if (!value) return value;
    return Value{!is_true(*value)};
  }

  Answer comparison() {
    auto left = sum();
    if (!left) return left;
    static constexpr std::array<std::string_view, 6> kTokens{"==", "!=", "<=", ">=", "<", ">"};
    for (std::size_t i = 0; i < kTokens.size(); ++i) {
      if (!take(kTokens[i])) continue;
      auto right = sum();
      if (!right) return right;
      return compare(i, *left, *right);
    }
    return left;
  }

  static Answer compare(std::size_t token, const Value& left, const Value& right) {
    const auto a = number_of(left), b = number_of(right);
    const auto* const s = std::get_if<std::string>(&left);
    const auto* const t = std::get_if<std::string>(&right);
    if (token < 2 && !(a && b) && !(s != nullptr && t != nullptr)) return Value{token == 1};  // never equal
    int order = 0;
    if (a && b) {
      if (std::isnan(*a) || std::isnan(*b)) return Value{token == 1};
      order = *a < *b ? -1 : *a > *b ? 1 : 0;
    } else if (s != nullptr && t != nullptr) {
      order = s->compare(*t);
    } else {
      return err("a number and a text have no order: " + shown(left) + ", " + shown(right));
    }
    const std::array<bool, 6> answers{order == 0, order != 0, order <= 0, order >= 0, order<0, order> 0};
    return Value{answers[token]};
  }

  Answer sum() {
    auto left = product();
    while (left) {
      const char sign = next();
      if (sign != '+' && sign != '-') break;
      ++at_;
      auto right = product();
      if (!right) return right;
      left = sign == '+' ? add(*left, *right) : subtract(*left, *right);
    }
    return left;
  }

  static Answer no_numbers(std::string_view sign, const Value& left, const Value& right) {
    return err(fmt::format("'{}' does not go with {} and {}", sign, shown(left), shown(right)));
  }

  static Answer add(const Value& left, const Value& right) {
    const auto* const s = std::get_if<std::string>(&left);
    const auto* const t = std::get_if<std::string>(&right);
    if (s != nullptr && t != nullptr) {
      if (s->size() + t->size() > kMaxText) return err(std::string{"the text becomes too long"});
      return Value{*s + *t};
    }
    std::int64_t exact = 0;
    const auto i = integer_of(left), j = integer_of(right);
    if (i && j && !__builtin_add_overflow(*i, *j, &exact)) return Value{exact};
    const auto a = number_of(left), b = number_of(right);
    if (!a || !b) return no_numbers("+", left, right);
    return Value{*a + *b};
  }

  static Answer subtract(const Value& left, const Value& right) {
    std::int64_t exact = 0;
    const auto i = integer_of(left), j = integer_of(right);
    if (i && j && !__builtin_sub_overflow(*i, *j, &exact)) return Value{exact};
    const auto a = number_of(left), b = number_of(right);
    if (!a || !b) return no_numbers("-", left, right);
    return Value{*a - *b};
  }

  Answer product() {
    auto left = signed_value();
    while (left) {
      std::string_view sign;
      for (const std::string_view token : {"//", "/", "%", "*"}) {
        if (token == "*" && text_.substr(std::min(at_, text_.size())).starts_with("**")) continue;
        if (take(token)) {
          sign = token;
          break;
        }
      }
      if (sign.empty()) break;
      auto right = signed_value();
      if (!right) return right;
      left = multiply(sign, *left, *right);
    }
    return left;
  }

  static Answer multiply(std::string_view sign, const Value& left, const Value& right) {
    const auto a = number_of(left), b = number_of(right);
    if (!a || !b) return no_numbers(sign, left, right);
    const auto i = integer_of(left), j = integer_of(right);
    if (sign == "*") {
      std::int64_t exact = 0;
      if (i && j && !__builtin_mul_overflow(*i, *j, &exact)) return Value{exact};
      return Value{*a * *b};
    }
    if (*b == 0) return err(std::string{"division by zero"});
    if (sign == "/") return Value{*a / *b};
    const bool exact = i && j && *i != std::numeric_limits<std::int64_t>::min();
    if (sign == "//") {
      if (!exact) return Value{std::floor(*a / *b)};
      return Value{*i / *j - ((*i % *j != 0 && (*i < 0) != (*j < 0)) ? 1 : 0)};
    }
    if (exact) {
      const std::int64_t rest = *i % *j;
      return Value{rest != 0 && (rest < 0) != (*j < 0) ? rest + *j : rest};
    }
    const double rest = std::fmod(*a, *b);
    return Value{rest != 0 && (rest < 0) != (*b < 0) ? rest + *b : rest};
  }

  Answer signed_value() {
    const char sign = next();
    if (sign != '-' && sign != '+') return power();
    ++at_;
    if (++depth_ > kMaxDepth) return err(std::string{"it is nested too deeply"});
    auto value = signed_value();
    --depth_;
    if (!value || sign == '+') return value;
    return subtract(Value{std::int64_t{0}}, *value);
  }

  Answer power() {
    auto base = atom();
    if (!base || !take("**")) return base;
    if (++depth_ > kMaxDepth) return err(std::string{"it is nested too deeply"});
    auto exponent = signed_value();  // binds to the right: 2**-1, 2**3**2
    --depth_;
    if (!exponent) return exponent;
    const auto a = number_of(*base), b = number_of(*exponent);
    if (!a || !b) return no_numbers("**", *base, *exponent);
    const double result = std::pow(*a, *b);
    const auto i = integer_of(*base), j = integer_of(*exponent);
    if (i && j && *j >= 0 && std::abs(result) < 9e15) return Value{static_cast<std::int64_t>(result)};
    return domain_checked("pow", result);
  }

  Answer atom() {
    const char c = next();
    if (c == '(') {
      ++at_;
      auto value = conditional();
      if (!value) return value;
      if (!take(")")) return err(std::string{"a ')' is missing"});
      return value;
    }
    if (c == '\'' || c == '"') return quoted(c);
    if (is_digit(c) || c == '.') return number();
    if (is_name_start(c)) return name();
    if (c == '[' || c == '{')
      return err(std::string{"lists and dictionaries are not available; use one property each"});
    return unexpected();
  }

  Answer quoted(char quote) {
    const auto end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) return err(std::string{"a quotation mark is not closed"});
    std::string text(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return Value{std::move(text)};
  }

  Answer number() {
    const std::string_view rest = text_.substr(at_);
    double value = 0;
    const auto [end, fault] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (fault != std::errc{}) return unexpected();
    const std::string_view digits(rest.data(), static_cast<std::size_t>(end - rest.data()));
    at_ += digits.size();
    std::int64_t exact = 0;
    const auto [stop, is_not] = std::from_chars(digits.data(), digits.data() + digits.size(), exact);
    if (is_not == std::errc{} && stop == digits.data() + digits.size()) return Value{exact};
    return Value{value};
  }

  Answer name() {
    std::size_t end = at_;
    while (end < text_.size() && (is_name_part(text_[end]) || text_[end] == '.')) ++end;
    std::string_view word = text_.substr(at_, end - at_);
    at_ = end;
    if (word.starts_with("math.")) word.remove_prefix(5);
    if (next() == '(') return call(word);
    if (next() == '[') return err(std::string{"lists and dictionaries are not available; use one property each"});
    if (auto known = names_(word)) return known;
    if (word == "True" || word == "true") return Value{true};
    if (word == "False" || word == "false") return Value{false};
    if (word == "pi") return Value{std::numbers::pi};
    if (word == "tau") return Value{2 * std::numbers::pi};
    if (word == "e") return Value{std::numbers::e};
    if (word == "inf") return Value{std::numeric_limits<double>::infinity()};
    if (word == "nan") return Value{std::numeric_limits<double>::quiet_NaN()};
    return names_(word);  // with the error's words
  }

  Answer call(std::string_view word) {
    ++at_;
    std::vector<Value> arguments;
    while (next() != ')') {
      auto value = conditional();
      if (!value) return value;
      arguments.push_back(std::move(*value));
      if (arguments.size() > 16) return err(std::string{"a function has more than 16 arguments"});
      if (next() == ',') {
        ++at_;
      } else if (next() != ')') {
        return err(std::string{"a ')' is missing"});
      }
    }
    ++at_;
    return apply(word, arguments);
  }

  static Answer apply(std::string_view word, const std::vector<Value>& arguments) {
    if (word == "str" && arguments.size() == 1) return Value{to_text(arguments[0])};
    if (word == "bool" && arguments.size() == 1) return Value{is_true(arguments[0])};
    if (word == "len" && arguments.size() == 1) {
      if (const auto* text = std::get_if<std::string>(&arguments[0]))
        return Value{static_cast<std::int64_t>(text->size())};
    }
    if ((word == "float" || word == "int") && arguments.size() == 1) {
      Value read = arguments[0];
      if (const auto* text = std::get_if<std::string>(&read)) read = value_of(*text);
      const auto number = number_of(read);
      if (!number) return err(fmt::format("{}() needs a number, not {}", word, shown(arguments[0])));
      return word == "float" ? Answer{Value{*number}} : whole("int", std::trunc(*number));
    }
    const auto found =
        std::find_if(kFunctions.begin(), kFunctions.end(), [&](const Function& f) { return f.name == word; });
    if (found == kFunctions.end()) {
      std::vector<std::string> known{"str", "bool", "len", "float", "int"};
      for (const auto& function : kFunctions) known.emplace_back(function.name);
      return err("there is no function '" + std::string(word.substr(0, 60)) + "'; " +
                 suggestion(word.substr(0, 60), known));
    }
    if (arguments.size() < found->least || arguments.size() > found->most)
      return err(fmt::format("{}() takes {} argument{}, not {}", word, found->least, found->least == 1 ? "" : "s",
                             arguments.size()));
    std::vector<double> numbers;
    for (const auto& argument : arguments) {
      const auto number = number_of(argument);
      if (!number) return err(fmt::format("{}() needs numbers, not {}", word, shown(argument)));
      numbers.push_back(*number);
    }
    return found->call(arguments, numbers);
  }

  std::string_view text_;
  const Names& names_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

std::string to_text(const Value& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? "True" : "False";
  if (const auto* i = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *i);
  if (const auto* s = std::get_if<std::string>(&value)) return *s;
  std::string text = fmt::format("{}", std::get<double>(value));
  if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
  return text;
}

Value value_of(std::string_view text) {
  std::string_view trimmed = text;
  while (!trimmed.empty() && std::isspace(static_cast<unsigned char>(trimmed.front())) != 0) trimmed.remove_prefix(1);
  while (!trimmed.empty() && std::isspace(static_cast<unsigned char>(trimmed.back())) != 0) trimmed.remove_suffix(1);
  if (trimmed == "true" || trimmed == "True") return true;
  if (trimmed == "false" || trimmed == "False") return false;
  std::string_view digits = trimmed;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  if (digits.empty() || !(is_digit(digits.front()) || digits.front() == '-' || digits.front() == '.'))
    return std::string(text);
  std::int64_t exact = 0;
  const char* const end = digits.data() + digits.size();
  if (const auto [stop, fault] = std::from_chars(digits.data(), end, exact); fault == std::errc{} && stop == end)
    return exact;
  double number = 0;
  if (const auto [stop, fault] = std::from_chars(digits.data(), end, number); fault == std::errc{} && stop == end)
    return number;
  return std::string(text);
}

bool is_true(const Value& value) {
  if (const auto* s = std::get_if<std::string>(&value)) return !s->empty();
  return *number_of(value) != 0;
}

Result<Value, std::string> evaluate(std::string_view expression, const Names& names) {
  return Parser{expression, names}.whole_expression();
}

}  // namespace nacelle::description
