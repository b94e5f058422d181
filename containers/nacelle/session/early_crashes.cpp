// SPDX-License-Identifier: Apache-2.0
#include "session/early_crashes.hpp"

#include <cxxabi.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "nacelle/base/json_text.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/runtime/crash_record.hpp"

namespace nacelle::session {
namespace {

using nlohmann::json;

constexpr const char* kCountsFormat = "nacelle_crash_counts";
constexpr std::size_t kLongestCounts = 1U << 20U, kMostCounted = 1000, kLongestSymbol = 160;

std::string demangled(const std::string& symbol) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> text{abi::__cxa_demangle(symbol.c_str(), nullptr, nullptr, &status),
                                                         &std::free};
  return (status == 0 && text ? std::string{text.get()} : symbol).substr(0, kLongestSymbol);
}

// "/crane or /patient"
std::vector<std::string> nodes_of(std::string_view owners) {
  constexpr std::string_view kBetween = " or ";
  std::vector<std::string> nodes;
  while (!owners.empty()) {
    const std::size_t end = std::min(owners.find(kBetween), owners.size());
    if (std::string node{owners.substr(0, end)}; validate_full_topic_name(node)) nodes.push_back(std::move(node));
    owners.remove_prefix(std::min(end + kBetween.size(), owners.size()));
  }
  return nodes;
}

}  // namespace

std::optional<CrashFacts> crash_facts(const std::string& record) {
  const auto line = [&](const char* key) { return runtime::crash_record_line(record, key); };
  const std::string signal = line("signal"), component = line("component"), callback = line("callback");
  if (signal.empty()) return std::nullopt;
  CrashFacts facts;
  facts.id = line("time") + "/" + line("process");
  facts.nodes = nodes_of(component);
  const std::string age = line("component age");
  std::int64_t age_ms = 0;
  facts.early = std::from_chars(age.data(), age.data() + age.size(), age_ms).ec == std::errc{} &&
                std::chrono::milliseconds{age_ms} <= EarlyCrashes::kEarly;
  const std::string where = component.empty() ? line("library") : component, symbol = line("symbol");
  facts.text = fmt::format("{}{}{}{}{}{}{}", signal, where.empty() ? "" : " in ", where, callback.empty() ? "" : ", ",
                           callback, symbol.empty() ? "" : ", at ", symbol.empty() ? "" : demangled(symbol));
  return facts;
}

void EarlyCrashes::begin(bool resume, const std::optional<CrashFacts>& last) {
  if (resume) read();
  last_run_crashed_ = resume && last && last->id != counted_;
  if (last) counted_ = last->id;
  if (last_run_crashed_) {
    for (const auto& node : last->nodes) {
      if (!last->early) {
        of_.erase(node);
      } else if (of_.size() < kMostCounted) {
        Entry& entry = of_[node];
        ++entry.count;
        entry.text = last->text;
      }
    }
  }
  // Before anything is loaded: the next crash may come at once.
  write();
}

bool EarlyCrashes::is_left_out(const std::string& node) const {
  const auto found = of_.find(node);
  return found != of_.end() && found->second.count >= kMost;
}

std::string EarlyCrashes::reason(const std::string& node) const {
  const auto found = of_.find(node);
  if (found == of_.end()) return {};
  return fmt::format("{} crashes within {:g} s of its activation, the last: {}", found->second.count,
                     to_seconds(kEarly), found->second.text);
}

std::vector<std::string> EarlyCrashes::nodes() const {
  std::vector<std::string> all;
  for (const auto& [node, entry] : of_) all.push_back(node);
  return all;
}

void EarlyCrashes::forget(const std::string& node) {
  if (of_.erase(node) != 0) write();
}

void EarlyCrashes::remove() { ::unlink(path_.c_str()); }

// A file that is damaged counts nothing: then a component has two more tries.
void EarlyCrashes::read() {
  const int file = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
  if (file < 0) return;
  std::string text(kLongestCounts + 1, '\0');
  const ssize_t size = ::read(file, text.data(), text.size());
  ::close(file);
  if (size <= 0 || static_cast<std::size_t>(size) > kLongestCounts) return;
  text.resize(static_cast<std::size_t>(size));
  const json all = parse_json_or_discard(text);
  if (!all.is_object() || !all.contains(kCountsFormat)) return;
  try {
    counted_ = all.at("counted").get<std::string>();
    for (const auto& [node, row] : all.at("components").items()) {
      if (of_.size() >= kMostCounted || !validate_full_topic_name(node) || !row.at("count").is_number_unsigned())
        continue;
      of_[node] = {row.at("count").get<std::uint32_t>(), row.at("text").get<std::string>()};
    }
  } catch (const json::exception&) { of_.clear(); }
}

void EarlyCrashes::write() const {
  if (of_.empty() && counted_.empty()) {
    ::unlink(path_.c_str());
    return;
  }
  json all{{kCountsFormat, 1}, {"counted", counted_}, {"components", json::object()}};
  for (const auto& [node, entry] : of_) all["components"][node] = {{"count", entry.count}, {"text", entry.text}};
  const std::string text = all.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
  const std::string beside = path_ + ".new";
  const int file = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return;  // as of the state file, whose failure is reported
  const bool whole = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::close(file);
  if (whole) static_cast<void>(std::rename(beside.c_str(), path_.c_str()));
}

}  // namespace nacelle::session
