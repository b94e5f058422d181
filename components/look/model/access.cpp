// SPDX-License-Identifier: Apache-2.0
#include "look/model/access.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <cctype>
#include <utility>

namespace nacelle::look {
namespace {

bool is_same(std::string_view given, std::string_view right) {
  if (given.size() != right.size() || right.empty()) return false;
  unsigned different = 0;
  for (std::size_t i = 0; i < right.size(); ++i)
    different |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(right[i]);
  return different == 0;
}

std::string lower(std::string_view text) {
  std::string made{text};
  std::transform(made.begin(), made.end(), made.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return made;
}

/// "robot.local" of "Robot.local:8080", "::1" of "[::1]:8080". Empty: it is no host.
std::string name_of(std::string_view host) {
  if (host.starts_with('[')) {
    const auto end = host.find(']');
    return end == std::string_view::npos ? "" : lower(host.substr(1, end - 1));
  }
  return lower(host.substr(0, host.find(':')));
}

bool is_address(const std::string& name) {
  in6_addr address{};
  return ::inet_pton(AF_INET, name.c_str(), &address) == 1 || ::inet_pton(AF_INET6, name.c_str(), &address) == 1;
}

}  // namespace

const char* to_text(Right right) {
  switch (right) {
    case Right::None: return "none";
    case Right::View: return "view";
    case Right::Operate: return "operate";
  }
  return "";
}

Right Access::right_of(std::string_view token) const {
  if (is_same(token, options_.operate_token)) return Right::Operate;
  return is_same(token, options_.view_token) ? Right::View : Right::None;
}

bool Access::is_host_allowed(std::string_view host) const {
  const std::string name = name_of(host);
  if (name.empty()) return false;
  if (name == "localhost" || is_address(name)) return true;
  return std::any_of(options_.allowed_hosts.begin(), options_.allowed_hosts.end(),
                     [&](const std::string& one) { return lower(one) == name; });
}

bool Access::is_origin_allowed(std::string_view origin, std::string_view host) const {
  if (origin.empty()) return true;
  if (lower(origin) == "http://" + lower(host)) return true;
  return std::find(options_.allowed_origins.begin(), options_.allowed_origins.end(), origin) !=
         options_.allowed_origins.end();
}

}  // namespace nacelle::look
