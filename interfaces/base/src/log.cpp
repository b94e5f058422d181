// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/journal.hpp"
#include "nacelle/base/printable.hpp"

namespace nacelle {
namespace {

std::atomic<LogLevel> lowest_level{LogLevel::Info};

spdlog::level::level_enum to_spdlog(LogLevel level) {
  switch (level) {
    case LogLevel::Debug: return spdlog::level::debug;
    case LogLevel::Info: return spdlog::level::info;
    case LogLevel::Warn: return spdlog::level::warn;
    case LogLevel::Error: return spdlog::level::err;
    case LogLevel::Fatal: return spdlog::level::critical;
  }
  return spdlog::level::info;
}

constexpr const char* kPattern = "%H:%M:%S.%e %^%l%$ %v";
// On a terminal a line of progress without an end may stand there: it is cleared first.
constexpr const char* kTerminalPattern = "\r\033[K%H:%M:%S.%e %^%l%$ %v";

std::shared_ptr<spdlog::logger> with_format(std::shared_ptr<spdlog::logger> sink, bool on_terminal) {
  sink->set_pattern(on_terminal ? kTerminalPattern : kPattern);
  sink->set_level(spdlog::level::trace);
  sink->flush_on(spdlog::level::warn);
  return sink;
}

// The process's one log; the logger's name is part of each line, so that loggers are values and need no registry.
std::shared_ptr<spdlog::logger>& process_log() {
  static std::shared_ptr<spdlog::logger> log =
      with_format(std::make_shared<spdlog::logger>("nacelle", std::make_shared<spdlog::sinks::stderr_color_sink_mt>()),
                  ::isatty(STDERR_FILENO) == 1);
  return log;
}

// Empty unless stderr is the journal.
const std::optional<Journal>& journal() {
  static const std::optional<Journal> found = Journal::behind(std::getenv("JOURNAL_STREAM"), STDERR_FILENO);
  return found;
}

struct KnownOrigin {
  std::string node, component;
};
using Origins = std::map<std::string, KnownOrigin, std::less<>>;
Guarded<Origins>& origins() {
  static Guarded<Origins> all;
  return all;
}

// ROS names a node's logger with dots: "robot1.lidar".
std::string logger_of(std::string_view node) {
  std::string name{node.substr(1)};
  std::ranges::replace(name, '/', '.');
  return name;
}

bool send_to_journal(LogLevel level, std::string_view logger, std::string_view text, const LogPlace& place,
                     std::string_view about) {
  if (!journal()) return false;
  const std::string owner = about.empty() ? std::string{} : logger_of(about);
  auto all = origins().lock();
  for (std::string_view name = about.empty() ? logger : owner;;) {
    if (const auto found = all->find(name); found != all->end())
      return journal()->send(level, logger, text, place, {found->second.node, found->second.component});
    const auto dot = name.rfind('.');
    if (dot == std::string_view::npos) return journal()->send(level, logger, text, place, {});
    name = name.substr(0, dot);
  }
}

// The listeners, and whether there are any: without listeners a line costs one load more.
Guarded<std::vector<LogListener*>>& listeners() {
  static Guarded<std::vector<LogListener*>> all;
  return all;
}
std::atomic<bool> has_listeners{false};

}  // namespace

void set_log_origin(const std::string& node, const std::string& component) {
  origins().lock()->insert_or_assign(logger_of(node), KnownOrigin{node, component});
}

void forget_log_origin(const std::string& node) { origins().lock()->erase(logger_of(node)); }

void add_log_listener(LogListener& listener) {
  auto all = listeners().lock();
  all->push_back(&listener);
  has_listeners = true;
}

void remove_log_listener(LogListener& listener) {
  auto all = listeners().lock();
  std::erase(*all, &listener);
  has_listeners = !all->empty();
}

bool Logger::is_due(const LogPlace& place, std::chrono::nanoseconds period) const {
  // By hashes: the file's name may go with its library.
  using Key = std::tuple<std::size_t, std::size_t, unsigned>;  // logger, file, line
  static Guarded<std::map<Key, std::chrono::steady_clock::time_point>> next;
  constexpr std::hash<std::string_view> hash;
  const auto now = std::chrono::steady_clock::now();
  auto all = next.lock();
  const auto [entry, is_first] = all->try_emplace(Key{hash(name_), hash(place.file), place.line});
  if (!is_first && now < entry->second) return false;
  entry->second = now + period;
  return true;
}

bool Logger::enabled(LogLevel level) const { return level >= lowest_level.load(std::memory_order_relaxed); }

namespace {

void write_line(LogLevel level, std::string_view name, std::string_view text, const LogPlace& place,
                std::string_view about) {
  if (send_to_journal(level, name, text, place, about)) {
    // It is there, with its fields.
  } else if (is_printable_line(text)) {
    process_log()->log(to_spdlog(level), "[{}] {}", name, text);
  } else {
    process_log()->log(to_spdlog(level), "[{}] {}", name, printable_entry(text));
  }
  if (!has_listeners.load(std::memory_order_acquire)) return;
  auto all = listeners().lock();
  for (LogListener* const listener : *all) listener->on_line(level, name, text, place);
}

}  // namespace

void Logger::write(LogLevel level, std::string_view text, const LogPlace& place) const {
  write_line(level, name_, text, place, {});
}

void write_about(std::string_view node, const Logger& log, LogLevel level, std::string_view text,
                 const LogPlace& place) {
  if (log.enabled(level)) write_line(level, log.name(), text, place, node);
}

void Logger::write_formatted(LogLevel level, const LogPlace& place, fmt::string_view format,
                             fmt::format_args args) const {
  fmt::memory_buffer text;  // a line of the usual length needs no heap: real-time threads write lines, too
  fmt::vformat_to(std::back_inserter(text), format, args);
  write(level, {text.data(), text.size()}, place);
}

void set_log_level(LogLevel level) { lowest_level.store(level, std::memory_order_relaxed); }

}  // namespace nacelle
