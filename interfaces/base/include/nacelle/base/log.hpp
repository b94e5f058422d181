// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace nacelle {

enum class LogLevel : unsigned char { Debug = 10, Info = 20, Warn = 30, Error = 40, Fatal = 50 };  // rcl_interfaces/Log

/// Where a line is written in the source; rcl_interfaces/Log's words. The texts are literals of the writer.
struct LogPlace {
  const char *file = "", *function = "";
  unsigned line = 0;
};

/// The node that a logger belongs to, and the component that the node belongs to: full names. Empty: it belongs to none.
struct LogOrigin {
  std::string_view node, component;
};
/// Notes which component a node belongs to, for lines of the node's logger and of its child loggers ("lidar.driver") in the
/// journal. Takes full names. Threads: any.
void set_log_origin(const std::string& node, const std::string& component);
void forget_log_origin(const std::string& node);

/// A format, checked at compile time, and the place where it stands.
template <typename... Args>
struct PlacedFormat {
  template <typename Text>
  requires std::convertible_to<const Text&, std::string_view> FMT_CONSTEVAL
  PlacedFormat(const Text& text, const char* file = __builtin_FILE(),  // NOLINT(google-explicit-constructor)
               const char* function = __builtin_FUNCTION(), unsigned line = __builtin_LINE())
      : format(text), place{file, function, line} {}
  fmt::format_string<Args...> format;
  LogPlace place;
};

/// Called for each line that is written. Threads: the writer's, one line at a time, with a lock held: only record it and return;
/// it must not write a line itself. The texts are as they were written, not escaped, and gone when it returns.
class LogListener {
 public:
  virtual ~LogListener() = default;
  virtual void on_line(LogLevel level, std::string_view name, std::string_view text,
                       const LogPlace& place) noexcept = 0;
};
void add_log_listener(LogListener& listener);
/// After its return the listener is not called any more.
void remove_log_listener(LogListener& listener);

/// Writes entries under one name, as rclcpp's loggers do. A small value; copy it freely. Control characters in a text are escaped, and
/// its further lines begin with "  | ": text from outside cannot pass for an entry. The text is only built if its level is enabled.
/// Lines go to stderr; if that is systemd's journal, they go there as entries with fields (journal.hpp).
/// Threads: any. Allocates: nothing for a line of up to 200 bytes without control characters. A message that may repeat at a sensor's
/// rate belongs into a counter.
class Logger {
  template <typename... Args>
  using Format = PlacedFormat<std::type_identity_t<Args>...>;

 public:
  explicit Logger(std::string name) : name_(std::move(name)) {}

  template <typename... Args>
  void debug(Format<Args...> format, Args&&... args) const {
    log(LogLevel::Debug, format.place, format.format, args...);
  }
  template <typename... Args>
  void info(Format<Args...> format, Args&&... args) const {
    log(LogLevel::Info, format.place, format.format, args...);
  }
  template <typename... Args>
  void warn(Format<Args...> format, Args&&... args) const {
    log(LogLevel::Warn, format.place, format.format, args...);
  }
  template <typename... Args>
  void error(Format<Args...> format, Args&&... args) const {
    log(LogLevel::Error, format.place, format.format, args...);
  }
  template <typename... Args>
  void fatal(Format<Args...> format, Args&&... args) const {
    log(LogLevel::Fatal, format.place, format.format, args...);
  }

  /// At most once in `period` from one place of the source under one name; what comes between is left out. For what may repeat.
  template <typename... Args>
  void info_throttle(std::chrono::nanoseconds period, Format<Args...> format, Args&&... args) const {
    if (is_due(format.place, period)) log(LogLevel::Info, format.place, format.format, args...);
  }
  template <typename... Args>
  void warn_throttle(std::chrono::nanoseconds period, Format<Args...> format, Args&&... args) const {
    if (is_due(format.place, period)) log(LogLevel::Warn, format.place, format.format, args...);
  }
  template <typename... Args>
  void error_throttle(std::chrono::nanoseconds period, Format<Args...> format, Args&&... args) const {
    if (is_due(format.place, period)) log(LogLevel::Error, format.place, format.format, args...);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] bool enabled(LogLevel level) const;
  void write(LogLevel level, std::string_view text, const LogPlace& place = {}) const;

 private:
  template <typename... Args>
  void log(LogLevel level, const LogPlace& place, fmt::string_view format, Args&... args) const {
    if (enabled(level)) write_formatted(level, place, format, fmt::make_format_args(args...));
  }
  [[nodiscard]] bool is_due(const LogPlace& place, std::chrono::nanoseconds period) const;
  void write_formatted(LogLevel level, const LogPlace& place, fmt::string_view format, fmt::format_args args) const;

  std::string name_;
};

/// Lowest level that is written; Info unless set. Threads: any.
void set_log_level(LogLevel level);

}  // namespace nacelle
