// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/attribute_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "nacelle/io/descriptor.hpp"

namespace nacelle::io {

std::optional<std::string> read_attribute(const std::string& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  std::array<char, 256> text{};
  const ssize_t length = file.is_open() ? ::read(file.number(), text.data(), text.size()) : -1;
  if (length < 0) return std::nullopt;
  const std::string_view all{text.data(), static_cast<std::size_t>(length)};
  return std::string{all.substr(0, all.find('\n'))};
}

int write_attribute(const std::string& path, std::string_view text) {
  const Descriptor file{::open(path.c_str(), O_WRONLY | O_CLOEXEC)};
  if (!file.is_open()) return errno;
  const ssize_t written = ::write(file.number(), text.data(), text.size());
  if (written < 0) return errno;
  return static_cast<std::size_t>(written) == text.size() ? 0 : EIO;
}

}  // namespace nacelle::io
