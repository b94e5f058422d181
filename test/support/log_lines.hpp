// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/log.hpp"

namespace nacelle::test {

/// The texts that are logged while it exists. Threads: that of the test alone logs meanwhile.
class LogLines final : public LogListener {
 public:
  LogLines() { add_log_listener(*this); }
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;
  ~LogLines() override { remove_log_listener(*this); }
  void on_line(LogLevel, std::string_view, std::string_view text, const LogPlace&) noexcept override {
    all.emplace_back(text);
  }
  std::vector<std::string> all;
};

}  // namespace nacelle::test
