// SPDX-License-Identifier: Apache-2.0
#include "process/service_manager.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

namespace nacelle::process {
namespace {

std::string take(const char* name) {
  const char* const value = std::getenv(name);
  std::string text = value == nullptr ? "" : value;
  ::unsetenv(name);
  return text;
}

std::optional<std::int64_t> number_of(const std::string& text) {
  std::int64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc{} || read.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

ServiceManager ServiceManager::take_from_environment() {
  const std::string path = take("NOTIFY_SOCKET"), period = take("WATCHDOG_USEC"), process = take("WATCHDOG_PID");
  ServiceManager made;
  // '@' stands for the NUL of an abstract name.
  if (path.size() < 2 || path.size() >= sizeof made.address_.sun_path || (path[0] != '/' && path[0] != '@'))
    return made;
  made.address_.sun_family = AF_UNIX;
  std::memcpy(made.address_.sun_path, path.data(), path.size());
  if (path[0] == '@') made.address_.sun_path[0] = '\0';
  made.length_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  made.descriptor_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (made.descriptor_ < 0) return made;
  const timeval limit{1, 0};
  ::setsockopt(made.descriptor_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  const auto microseconds = number_of(period);
  const bool is_meant = process.empty() || number_of(process) == ::getpid();
  // A day is more than any service has, and its nanoseconds fit.
  constexpr std::int64_t kMost = 86'400'000'000;
  if (microseconds && *microseconds > 0 && *microseconds <= kMost && is_meant)
    made.watchdog_ = std::chrono::microseconds{*microseconds};
  return made;
}

ServiceManager::ServiceManager(ServiceManager&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      address_(other.address_),
      length_(other.length_),
      watchdog_(other.watchdog_) {}

ServiceManager::~ServiceManager() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void ServiceManager::tell(std::string_view assignments) const {
  if (descriptor_ < 0) return;
  static_cast<void>(!::sendto(descriptor_, assignments.data(), assignments.size(), MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&address_), length_));
}

}  // namespace nacelle::process
