// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>

namespace nacelle::test {

/// The socket of a service manager: NOTIFY_SOCKET.
class NotifySocket {
 public:
  explicit NotifySocket(bool is_abstract = false) {
    EXPECT_NE(::mkdtemp(folder_.data()), nullptr);
    name_ = (is_abstract ? "@" : "") + folder_ + "/notify";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name_.data(), name_.size());
    if (is_abstract) address.sun_path[0] = '\0';
    descriptor_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(::bind(descriptor_, reinterpret_cast<sockaddr*>(&address),
                     static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name_.size())),
              0);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  ~NotifySocket() {
    ::close(descriptor_);
    std::filesystem::remove_all(folder_);
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Returns the next datagram; empty if there is none.
  [[nodiscard]] std::string receive() const {
    std::string text(4096, '\0');
    const auto size = ::recv(descriptor_, text.data(), text.size(), MSG_DONTWAIT);
    text.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    return text;
  }

 private:
  std::string folder_ = (std::filesystem::temp_directory_path() / "nacelle-notify-XXXXXX").string(), name_;
  int descriptor_ = -1;
};

}  // namespace nacelle::test
