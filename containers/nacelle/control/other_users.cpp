// SPDX-License-Identifier: Apache-2.0
// Source of the columns: proc(5), /proc/net/unix.
#include "control/other_users.hpp"

#include <fmt/format.h>
#include <pwd.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "control/socket_path.hpp"

namespace nacelle::control {
namespace {

constexpr std::string_view kSocketEnd = ".sock";
constexpr std::string_view kIsListening = "00010000";

/// Takes a number off the front.
std::optional<unsigned> take_number(std::string_view& text) {
  unsigned number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

bool take(std::string_view& text, std::string_view front) {
  if (!text.starts_with(front)) return false;
  text.remove_prefix(front.size());
  return true;
}

std::optional<OthersContainer> container_at(std::string_view path) {
  OthersContainer found;
  if (take(path, "/run/nacelle/") && path.ends_with(kSocketEnd)) {
    found.name = path.substr(0, path.size() - kSocketEnd.size());
    found.is_service = true;
    return validate_container_name(found.name) ? std::optional{found} : std::nullopt;
  }
  const bool in_runtime_dir = take(path, "/run/user/");
  if (!in_runtime_dir && !take(path, "/dev/shm/nacelle-")) return std::nullopt;
  const auto user = take_number(path);
  if (!user || !take(path, in_runtime_dir ? "/nacelle/" : "/") || !path.ends_with(kSocketEnd)) return std::nullopt;
  found.user = *user;
  found.name = path.substr(0, path.size() - kSocketEnd.size());
  if (!validate_container_name(found.name)) return std::nullopt;
  if (in_runtime_dir) found.runtime_dir = fmt::format("/run/user/{}", *user);
  return found;
}

std::string name_of_user(unsigned user) {
  const passwd* const entry = ::getpwuid(user);  // a command has one thread
  return entry == nullptr ? "#" + std::to_string(user) : entry->pw_name;
}

}  // namespace

std::vector<OthersContainer> containers_of_others(std::string_view sockets, unsigned own_user) {
  std::vector<OthersContainer> found;
  while (!sockets.empty()) {
    const std::size_t end = std::min(sockets.find('\n'), sockets.size());
    const std::string_view line = sockets.substr(0, end);
    sockets.remove_prefix(std::min(end + 1, sockets.size()));
    const std::size_t path = line.find('/');
    if (path == std::string_view::npos || line.substr(0, path).find(kIsListening) == std::string_view::npos) continue;
    auto container = container_at(line.substr(path));
    if (container && (container->is_service || container->user != own_user)) found.push_back(std::move(*container));
  }
  return found;
}

Problem problem_of_others(const std::vector<OthersContainer>& others) {
  std::string whose;
  for (const auto& other : others) {
    if (!whose.empty()) whose += ", ";
    whose += other.is_service ? fmt::format("the service nacelle@{} runs", other.name)
                              : fmt::format("user {} runs '{}'", name_of_user(other.user), other.name);
  }
  const OthersContainer& first = others.front();
  if (first.is_service)
    return {"", "no container of yours is running; " + whose,
            "join its group: sudo usermod -aG nacelle $USER, then log in again"};
  std::string who = name_of_user(first.user);
  if (who.starts_with('#')) who = "'" + who + "'";  // a shell takes it for a comment
  return {"", "no container of yours is running; " + whose,
          fmt::format("ask as its user: sudo -u {}{} nacelle ...", who,
                      first.runtime_dir.empty() ? "" : " XDG_RUNTIME_DIR=" + first.runtime_dir)};
}

}  // namespace nacelle::control
