// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace nacelle::look {

/// What a viewer may do.
enum class Right : std::uint8_t {
  None,
  View,    ///< See everything, and set the emergency stop.
  Operate  ///< Change the robot as well.
};
/// "none", "view" or "operate".
[[nodiscard]] const char* to_text(Right right);

/// Decides who gets in. Threads: constant.
///
/// A page of another site in the same browser can open connections to this machine: its Origin gives it away. So does its Host if it has
/// made a name of its own point here (DNS rebinding): a name is accepted only if it is one of this machine.
class Access {
 public:
  struct Options {
    std::string view_token, operate_token;     ///< Not empty.
    std::vector<std::string> allowed_hosts;    ///< Names of this machine, beside localhost and every IP address.
    std::vector<std::string> allowed_origins;  ///< Of other viewers' pages: "https://app.foxglove.dev".
  };
  explicit Access(Options options) : options_(std::move(options)) {}

  /// Takes the same time for every wrong token of one length.
  [[nodiscard]] Right right_of(std::string_view token) const;
  /// `host`: the header, with or without a port.
  [[nodiscard]] bool is_host_allowed(std::string_view host) const;
  /// `origin`: the header; empty: a program that is no browser. `host` is allowed.
  [[nodiscard]] bool is_origin_allowed(std::string_view origin, std::string_view host) const;

 private:
  Options options_;
};

}  // namespace nacelle::look
