// SPDX-License-Identifier: Apache-2.0
#include "substitution.hpp"

#include <algorithm>
#include <map>

#include "nacelle/launch/launch_fault.hpp"
#include "shown.hpp"
#include "unsupported.hpp"

namespace nacelle::launch {
namespace {

constexpr int kMaxDepth = 16;

struct Call;
struct Part {
  std::string literal;
  std::vector<Call> call;  // one or none
};
using Template = std::vector<Part>;
struct Call {
  std::string name;
  std::vector<Template> arguments;
};

struct Arity {
  std::size_t least, most;
};
const std::map<std::string, Arity, std::less<>>& known() {
  static const std::map<std::string, Arity, std::less<>> all{
      {"var", {1, 1}},       {"env", {1, 2}}, {"dirname", {0, 0}}, {"filename", {0, 0}}, {"find-pkg-share", {1, 1}},
      {"anon", {1, 1}},      {"not", {1, 1}}, {"and", {2, 8}},     {"or", {2, 8}},       {"equals", {2, 2}},
      {"not-equals", {2, 2}}};
  return all;
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_escapable(char c) { return c == '$' || c == '\\' || c == '\'' || c == '"'; }

void add_literal(Template& into, char c) {
  if (into.empty() || !into.back().call.empty()) into.push_back({});
  into.back().literal += c;
}

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  // The whole text; quotes are ordinary characters here.
  bool parse(Template& into) {
    while (!at_end()) {
      if (!piece(into, 0)) return false;
    }
    return true;
  }
  Problem problem;

 private:
  [[nodiscard]] bool at_end() const { return at_ >= text_.size(); }
  [[nodiscard]] bool starts_call() const { return text_.substr(at_).starts_with("$("); }
  bool fail(std::string what, std::string way_out = {}) {
    problem = {"", std::move(what), std::move(way_out), LaunchFault::Form};
    return false;
  }

  // One character, one escape or one substitution.
  bool piece(Template& into, int depth) {
    if (starts_call()) return call(into, depth + 1);
    if (text_[at_] == '\\' && at_ + 1 < text_.size() && is_escapable(text_[at_ + 1])) ++at_;
    add_literal(into, text_[at_++]);
    return true;
  }

  bool call(Template& into, int depth) {
    if (depth > kMaxDepth) return fail("substitutions are nested more than " + std::to_string(kMaxDepth) + " deep");
    const std::size_t start = at_;
    at_ += 2;
    while (!at_end() && is_space(text_[at_])) ++at_;
    Call made;
    while (!at_end() && !is_space(text_[at_]) && text_[at_] != ')') made.name += text_[at_++];
    const std::string name = "$(" + shown(made.name) + ")";
    // Before its arguments, which follow another grammar.
    if (const char* why = refused_substitution(made.name)) return fail(name + " is refused: " + why);
    const auto rule = known().find(made.name);
    if (rule == known().end() && !at_end()) {
      std::vector<std::string> names;
      for (const auto& [word, arity] : known()) names.push_back(word);
      return fail("unknown substitution " + name, suggestion(shown(made.name), names));
    }
    while (true) {
      while (!at_end() && is_space(text_[at_])) ++at_;
      if (at_end())
        return fail("'" + shown(text_.substr(start)) + "' lacks its ')'", "write \\$( for the characters themselves");
      if (text_[at_] == ')') break;
      made.arguments.emplace_back();
      if (!argument(made.arguments.back(), depth)) return false;
    }
    ++at_;
    const auto [least, most] = rule->second;
    const std::size_t count = made.arguments.size();
    if (count < least || count > most) {
      return fail(name + " has " + std::to_string(count) + " arguments; it takes " + std::to_string(least) +
                      (most > least ? " to " + std::to_string(most) : ""),
                  count > most ? "put quotes around a text with spaces" : "");
    }
    into.push_back({"", {std::move(made)}});
    return true;
  }

  bool argument(Template& into, int depth) {
    while (!at_end() && !is_space(text_[at_]) && text_[at_] != ')') {
      const char quote = text_[at_];
      if (quote != '\'' && quote != '"') {
        if (!piece(into, depth)) return false;
        continue;
      }
      ++at_;
      while (!at_end() && text_[at_] != quote) {
        if (!piece(into, depth)) return false;
      }
      if (at_end()) return fail(std::string("the quote ") + quote + " does not end");
      ++at_;
    }
    return true;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

Result<std::string, Problem> evaluate(const Template& parts, const SubstitutionLookup& lookup) {
  std::string all;
  for (const auto& part : parts) {
    all += part.literal;
    for (const auto& call : part.call) {
      std::vector<std::string> arguments;
      for (const auto& argument : call.arguments) {
        auto value = evaluate(argument, lookup);
        if (!value) return value;
        arguments.push_back(std::move(*value));
      }
      auto value = lookup(call.name, arguments);
      if (!value) return value;
      all += *value;
    }
    if (all.size() > kMaxSubstitutedBytes) {
      return err(Problem{"", "the substituted text is longer than " + std::to_string(kMaxSubstitutedBytes) + " bytes",
                         "", LaunchFault::TooMuch});
    }
  }
  return all;
}

}  // namespace

Result<void, Problem> check_template(std::string_view text) {
  Parser parser(text);
  Template parts;
  if (!parser.parse(parts)) return err(std::move(parser.problem));
  return {};
}

Result<std::string, Problem> substitute(std::string_view text, const SubstitutionLookup& lookup) {
  Parser parser(text);
  Template parts;
  if (!parser.parse(parts)) return err(std::move(parser.problem));
  return evaluate(parts, lookup);
}

Result<std::vector<std::string>, Problem> split_words(std::string_view text) {
  std::vector<std::string> words;
  bool in_word = false;
  char quote = 0;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (depth == 0 && quote == 0 && is_space(c)) {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back();
    in_word = true;
    if (c == '\\' && i + 1 < text.size()) {
      words.back() += c;
      words.back() += text[++i];
    } else if (text.substr(i).starts_with("$(")) {
      ++depth;
      words.back() += "$(";
      ++i;
    } else if (depth > 0) {
      // Inside a substitution everything, quotes included, is for substitute().
      depth -= c == ')' ? 1 : 0;
      words.back() += c;
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    } else if (quote == c) {
      quote = 0;
    } else {
      words.back() += c;
    }
  }
  if (quote != 0) return err(Problem{"", std::string("the quote ") + quote + " does not end", "", LaunchFault::Form});
  return words;
}

}  // namespace nacelle::launch
