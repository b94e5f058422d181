// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/flat_json.hpp"

#include <charconv>
#include <cmath>

namespace nacelle::diff_drive {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Length of the JSON number at the front; 0 if there is none. std::from_chars alone also takes "inf", "nan" and "1.".
std::size_t number_length(std::string_view text) {
  std::size_t at = 0;
  const auto digits = [&] {
    const std::size_t from = at;
    while (at < text.size() && is_digit(text[at])) ++at;
    return at - from;
  };
  if (at < text.size() && text[at] == '-') ++at;
  const std::size_t first = at;
  const std::size_t whole = digits();
  if (whole == 0 || (whole > 1 && text[first] == '0')) return 0;
  if (at < text.size() && text[at] == '.') {
    ++at;
    if (digits() == 0) return 0;
  }
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    ++at;
    if (at < text.size() && (text[at] == '+' || text[at] == '-')) ++at;
    if (digits() == 0) return 0;
  }
  return at;
}

}  // namespace

std::nullopt_t FlatJsonReader::fail() {
  state_ = State::Failed;
  return std::nullopt;
}

void FlatJsonReader::skip_space() {
  while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\t' || rest_[0] == '\r' || rest_[0] == '\n'))
    rest_.remove_prefix(1);
}

bool FlatJsonReader::take(char expected) {
  skip_space();
  if (rest_.empty() || rest_[0] != expected) return false;
  rest_.remove_prefix(1);
  return true;
}

bool FlatJsonReader::take_word(std::string_view word) {
  if (!rest_.starts_with(word)) return false;
  rest_.remove_prefix(word.size());
  return true;
}

std::optional<std::string_view> FlatJsonReader::take_string() {
  if (!take('"')) return std::nullopt;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (static_cast<unsigned char>(rest_[i]) < 0x20) return std::nullopt;
    if (rest_[i] == '\\') {
      ++i;  // an escaped character does not end the text
    } else if (rest_[i] == '"') {
      const std::string_view text = rest_.substr(0, i);
      rest_.remove_prefix(i + 1);
      return text;
    }
  }
  return std::nullopt;
}

std::optional<double> FlatJsonReader::take_number() {
  const std::size_t length = number_length(rest_);
  if (length == 0) return std::nullopt;
  double value = 0.0;
  const auto result = std::from_chars(rest_.data(), rest_.data() + length, value);
  if (result.ec != std::errc{} || result.ptr != rest_.data() + length || !std::isfinite(value)) return std::nullopt;
  rest_.remove_prefix(length);
  return value;
}

std::optional<FlatJsonReader::Member> FlatJsonReader::take_member() {
  const auto key = take_string();
  if (!key || !take(':')) return std::nullopt;
  skip_space();
  Member member{*key, std::nullopt};
  if (rest_.empty()) return std::nullopt;
  if (rest_[0] == '"') {
    if (!take_string()) return std::nullopt;
  } else if (rest_[0] == 't' || rest_[0] == 'f' || rest_[0] == 'n') {
    if (!take_word("true") && !take_word("false") && !take_word("null")) return std::nullopt;
  } else {
    member.number = take_number();
    if (!member.number) return std::nullopt;
  }
  return member;
}

std::optional<FlatJsonReader::Member> FlatJsonReader::next() {
  if (state_ == State::Done || state_ == State::Failed) return std::nullopt;

  const bool first = state_ == State::Start;
  if (first && !take('{')) return fail();
  state_ = State::Members;
  if (take('}')) {
    skip_space();
    if (!rest_.empty()) return fail();
    state_ = State::Done;
    return std::nullopt;
  }
  if (!first && !take(',')) return fail();
  auto member = take_member();
  if (!member) return fail();
  return member;
}

}  // namespace nacelle::diff_drive
