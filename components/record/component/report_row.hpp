// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::record {

/// The one row of a diagnostics message that a component fills each time anew.
class ReportRow {
 public:
  enum class Level : std::uint8_t { Ok, Warning, Error };  // DiagnosticStatus' numbers

  ReportRow(diagnostic_msgs::msg::DiagnosticArray& message, WallTime stamp, std::string name) {
    message.header.stamp = stamp;
    message.header.frame_id.clear();
    message.status.resize(1);
    status_ = &message.status.front();
    status_->name = std::move(name);
    status_->hardware_id.clear();
    status_->values.clear();
  }
  void say(Level level, std::string words) {
    status_->level = static_cast<std::uint8_t>(level);
    status_->message = std::move(words);
  }
  void add(std::string key, std::string value) {
    auto& entry = status_->values.emplace_back();
    entry.key = std::move(key);
    entry.value = std::move(value);
  }

 private:
  diagnostic_msgs::msg::DiagnosticStatus* status_ = nullptr;
};

}  // namespace nacelle::record
