// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/text.hpp"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace nacelle {
namespace {

template <typename Policy>
using Words = std::vector<std::pair<Policy, const char*>>;

const Words<Reliability>& reliability_words() {
  static const Words<Reliability> words{{Reliability::SystemDefault, "system_default"},
                                        {Reliability::Reliable, "reliable"},
                                        {Reliability::BestEffort, "best_effort"},
                                        {Reliability::Unknown, "unknown"},
                                        {Reliability::BestAvailable, "best_available"}};
  return words;
}
const Words<Durability>& durability_words() {
  static const Words<Durability> words{{Durability::SystemDefault, "system_default"},
                                       {Durability::TransientLocal, "transient_local"},
                                       {Durability::Volatile, "volatile"},
                                       {Durability::Unknown, "unknown"},
                                       {Durability::BestAvailable, "best_available"}};
  return words;
}
const Words<History>& history_words() {
  static const Words<History> words{{History::SystemDefault, "system_default"},
                                    {History::KeepLast, "keep_last"},
                                    {History::KeepAll, "keep_all"},
                                    {History::Unknown, "unknown"}};
  return words;
}
const Words<Liveliness>& liveliness_words() {
  static const Words<Liveliness> words{{Liveliness::SystemDefault, "system_default"},
                                       {Liveliness::Automatic, "automatic"},
                                       {Liveliness::ManualByTopic, "manual_by_topic"},
                                       {Liveliness::Unknown, "unknown"},
                                       {Liveliness::BestAvailable, "best_available"}};
  return words;
}

const Words<PoolPolicy>& pool_policy_words() {
  static const Words<PoolPolicy> words{
      {PoolPolicy::Grow, "grow"}, {PoolPolicy::Drop, "drop"}, {PoolPolicy::Fail, "fail"}};
  return words;
}

template <typename Policy>
std::string word_of(const Words<Policy>& words, Policy value) {
  for (const auto& [known, word] : words) {
    if (known == value) return word;
  }
  return "unknown";
}

// Text from outside, fit to be shown.
std::string shown(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 60)) out += (c >= ' ' && c < 0x7f) ? c : '?';
  return text.size() > 60 ? out + "..." : out;
}

template <typename Policy>
Result<Policy, Problem> value_of(const char* policy, const Words<Policy>& words, std::string_view text) {
  std::vector<std::string> known;
  for (const auto& [value, word] : words) {
    if (text == word) return value;
    known.emplace_back(word);
  }
  return err(Problem{"", "'" + shown(text) + "' is not a " + policy, suggestion(text.substr(0, 60), known)});
}

struct Unit {
  const char* name;
  std::int64_t nanoseconds;
};
constexpr std::array<Unit, 6> kUnits{{{"ns", 1},
                                      {"us", 1'000},
                                      {"ms", 1'000'000},
                                      {"s", 1'000'000'000},
                                      {"min", 60'000'000'000},
                                      {"h", 3'600'000'000'000}}};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Exact to the nanosecond: a double would turn 0.1s into 99.999999ms somewhere.
bool scaled(std::string_view whole, std::string_view fraction, std::int64_t unit, std::int64_t& nanoseconds) {
  std::int64_t sum = 0;
  for (const char c : whole) {
    if (__builtin_mul_overflow(sum, std::int64_t{10}, &sum) || __builtin_add_overflow(sum, c - '0', &sum)) return false;
  }
  if (__builtin_mul_overflow(sum, unit, &sum)) return false;
  for (const char c : fraction) {
    unit /= 10;
    if (unit == 0) break;  // below a nanosecond
    if (__builtin_add_overflow(sum, (c - '0') * unit, &sum)) return false;
  }
  nanoseconds = sum;
  return true;
}

}  // namespace

std::string to_text(Reliability value) { return word_of(reliability_words(), value); }
std::string to_text(Durability value) { return word_of(durability_words(), value); }
std::string to_text(History value) { return word_of(history_words(), value); }
std::string to_text(Liveliness value) { return word_of(liveliness_words(), value); }
std::string to_text(PoolPolicy value) { return word_of(pool_policy_words(), value); }

std::string to_text(Duration value) {
  if (value == Duration::max()) return "infinite";
  const std::int64_t ns = value.count();
  if (ns == 0) return "0s";
  const Unit& unit = ns >= 1'000'000'000 ? kUnits[3]
                     : ns >= 1'000'000   ? kUnits[2]
                     : ns >= 1'000       ? kUnits[1]
                                         : kUnits[0];
  std::string text = std::to_string(ns / unit.nanoseconds);
  if (std::int64_t rest = ns % unit.nanoseconds; rest > 0) {
    text += '.';
    for (std::int64_t digit = unit.nanoseconds / 10; rest > 0; digit /= 10) {
      text += static_cast<char>('0' + rest / digit);
      rest %= digit;
    }
  }
  return text + unit.name;
}

std::string policy_duration_text(Duration value) {
  if (value == Duration::zero()) return "infinite";
  return value == kBestAvailableDuration ? "best_available" : to_text(value);
}

std::string to_text(const QoS& qos) {
  std::string text = to_text(qos.history());
  if (qos.history() == History::KeepLast) text += " " + std::to_string(qos.depth());
  text += ", " + to_text(qos.reliability()) + ", " + to_text(qos.durability());
  if (qos.deadline() != Duration::zero()) text += ", deadline " + policy_duration_text(qos.deadline());
  if (qos.lifespan() != Duration::zero()) text += ", lifespan " + policy_duration_text(qos.lifespan());
  if (qos.liveliness() != Liveliness::SystemDefault) text += ", liveliness " + to_text(qos.liveliness());
  if (const Duration lease = qos.liveliness_lease_duration(); lease != Duration::zero()) {
    text += ", lease " + policy_duration_text(lease);
  }
  if (qos.when_dry() != PoolPolicy::Grow) text += ", when dry: " + to_text(qos.when_dry());
  return text;
}

Result<Reliability, Problem> parse_reliability(std::string_view text) {
  return value_of("reliability", reliability_words(), text);
}
Result<Durability, Problem> parse_durability(std::string_view text) {
  return value_of("durability", durability_words(), text);
}
Result<History, Problem> parse_history(std::string_view text) { return value_of("history", history_words(), text); }
Result<Liveliness, Problem> parse_liveliness(std::string_view text) {
  return value_of("liveliness", liveliness_words(), text);
}
Result<PoolPolicy, Problem> parse_pool_policy(std::string_view text) {
  return value_of("policy for a dry pool", pool_policy_words(), text);
}

Result<Duration, Problem> parse_duration(std::string_view text) {
  if (text == "infinite") return Duration::max();
  std::size_t at = 0;
  while (at < text.size() && is_digit(text[at])) ++at;
  const auto whole = text.substr(0, at);
  std::string_view fraction;
  if (at < text.size() && text[at] == '.') {
    const std::size_t start = ++at;
    while (at < text.size() && is_digit(text[at])) ++at;
    fraction = text.substr(start, at - start);
  }
  const std::string shown_text = shown(text);
  if (whole.empty() && fraction.empty()) {
    return err(Problem{"", "'" + shown_text + "' is not a duration",
                       "write a number and its unit, such as 100ms or 1.5s, or infinite"});
  }
  while (at < text.size() && text[at] == ' ') ++at;
  for (const Unit& unit : kUnits) {
    if (text.substr(at) != unit.name) continue;
    std::int64_t nanoseconds = 0;
    if (scaled(whole, fraction, unit.nanoseconds, nanoseconds) && Duration{nanoseconds} < kBestAvailableDuration) {
      return Duration{nanoseconds};
    }
    return err(Problem{"", "the duration '" + shown_text + "' is longer than 292 years", "write infinite"});
  }
  if (at == text.size()) {
    return err(Problem{"", "the duration '" + shown_text + "' has no unit",
                       "write " + shown_text + "ms or " + shown_text + "s"});
  }
  return err(Problem{"", "the duration '" + shown_text + "' has an unknown unit", "one of ns, us, ms, s, min, h"});
}

}  // namespace nacelle
