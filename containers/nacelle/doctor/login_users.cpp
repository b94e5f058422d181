// SPDX-License-Identifier: Apache-2.0
#include "doctor/login_users.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>

namespace nacelle::doctor {
namespace {

// Debian's UID_MIN, and the user "nobody".
constexpr uid_t kFirstPerson = 1000, kNobody = 65534;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ':');) fields.push_back(field);
  return fields;
}

bool lets_in(const std::string& shell) {
  return !shell.ends_with("/nologin") && !shell.ends_with("/false") && !shell.ends_with("/sync");
}

}  // namespace

std::vector<std::string> other_login_users(const Machine& machine, uid_t user) {
  std::vector<std::string> names;
  std::istringstream lines(machine.text("/etc/passwd").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const auto fields = fields_of(line);
    if (fields.size() < 6) continue;
    uid_t id = 0;
    const std::string& number = fields[2];
    const auto read = std::from_chars(number.data(), number.data() + number.size(), id);
    if (read.ec != std::errc{} || id < kFirstPerson || id == kNobody || id == user) continue;
    // Without a shell it is /bin/sh.
    if (fields.size() < 7 || lets_in(fields[6])) names.push_back(fields[0]);
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace nacelle::doctor
