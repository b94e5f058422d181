// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace nacelle {

enum class LogLevel : unsigned char { Debug = 10, Info = 20, Warn = 30, Error = 40, Fatal = 50 };  // rcl_interfaces/Log

/// Writes lines under one name, as rclcpp's loggers do. A small value; copy it freely.
///
/// The text is only built if its level is enabled. Threads: any. Allocates: yes, so not for hot paths; a message that
/// may repeat at a sensor's rate belongs into a counter.
class Logger {
 public:
  explicit Logger(std::string name) : name_(std::move(name)) {}

  template <typename... Args>
  void debug(fmt::format_string<Args...> format, Args&&... args) const {
    if (enabled(LogLevel::Debug)) write(LogLevel::Debug, fmt::format(format, std::forward<Args>(args)...));
  }
  template <typename... Args>
  void info(fmt::format_string<Args...> format, Args&&... args) const {
    if (enabled(LogLevel::Info)) write(LogLevel::Info, fmt::format(format, std::forward<Args>(args)...));
  }
  template <typename... Args>
  void warn(fmt::format_string<Args...> format, Args&&... args) const {
    if (enabled(LogLevel::Warn)) write(LogLevel::Warn, fmt::format(format, std::forward<Args>(args)...));
  }
  template <typename... Args>
  void error(fmt::format_string<Args...> format, Args&&... args) const {
    if (enabled(LogLevel::Error)) write(LogLevel::Error, fmt::format(format, std::forward<Args>(args)...));
  }
  template <typename... Args>
  void fatal(fmt::format_string<Args...> format, Args&&... args) const {
    if (enabled(LogLevel::Fatal)) write(LogLevel::Fatal, fmt::format(format, std::forward<Args>(args)...));
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] bool enabled(LogLevel level) const;
  void write(LogLevel level, std::string_view text) const;

 private:
  std::string name_;
};

/// Lowest level that is written; Info unless set. Threads: any.
void set_log_level(LogLevel level);
/// "debug", "info", "warn", "error" or "fatal", in any case. Returns false on another text.
[[nodiscard]] bool parse_log_level(std::string_view text, LogLevel& level);
/// Sends lines to a file instead of stderr. Errors: false if it cannot be opened; the lines stay on stderr.
[[nodiscard]] bool log_to_file(const std::string& path);

}  // namespace nacelle
