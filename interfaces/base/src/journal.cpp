// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/journal.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "nacelle/base/printable.hpp"

namespace nacelle {
namespace {

constexpr std::string_view kMark = " ... (truncated)";

std::string_view priority_of(LogLevel level) {
  switch (level) {  // as in syslog(3)
    case LogLevel::Debug: return "7";
    case LogLevel::Info: return "6";
    case LogLevel::Warn: return "4";
    case LogLevel::Error: return "3";
    case LogLevel::Fatal: return "2";
  }
  return "6";
}

/// Does not cut inside a UTF-8 character.
std::string_view cut(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return text;
  while (longest > 0 && (static_cast<unsigned char>(text[longest]) & 0xC0U) == 0x80U) --longest;
  return text.substr(0, longest);
}

/// An entry in the form that any value fits, also one of several lines:
///
///   | name | '\n' | length of the value, 64 bits, little-endian | value | '\n' |
class Entry {
 public:
  /// `parts` are joined to one value, and must outlive the entry. A field without a value is left out.
  void add(std::string_view name, std::initializer_list<std::string_view> parts) {
    std::uint64_t size = 0;
    for (const auto part : parts) size += part.size();
    if (size == 0) return;
    auto& length = lengths_[fields_++];
    for (unsigned i = 0; i < length.size(); ++i) length[i] = static_cast<char>((size >> (8 * i)) & 0xFFU);
    append(name);
    append("\n");
    append({length.data(), length.size()});
    for (const auto part : parts) append(part);
    append("\n");
  }
  [[nodiscard]] msghdr message(const sockaddr_un& to) {
    msghdr message{};
    message.msg_name = const_cast<sockaddr_un*>(&to);
    message.msg_namelen = sizeof to;
    message.msg_iov = parts_.data();
    message.msg_iovlen = used_;
    return message;
  }

 private:
  static constexpr std::size_t kFields = 10, kPartsOfMessage = 5;
  void append(std::string_view text) { parts_[used_++] = {const_cast<char*>(text.data()), text.size()}; }
  std::array<std::array<char, 8>, kFields> lengths_{};
  std::array<iovec, kFields * 5 + kPartsOfMessage> parts_{};
  std::size_t fields_ = 0, used_ = 0;
};

}  // namespace

std::optional<Journal> Journal::behind(const char* stream, int descriptor, const std::string& socket) {
  struct stat file {};
  if (stream == nullptr || ::fstat(descriptor, &file) != 0) return std::nullopt;
  std::uint64_t device = 0, inode = 0;
  const char* const end = stream + std::strlen(stream);
  const auto first = std::from_chars(stream, end, device);
  if (first.ec != std::errc{} || first.ptr == end || *first.ptr != ':') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, inode);
  if (second.ec != std::errc{} || second.ptr != end) return std::nullopt;
  if (device != file.st_dev || inode != file.st_ino) return std::nullopt;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket.size() >= sizeof address.sun_path) return std::nullopt;
  std::memcpy(address.sun_path, socket.c_str(), socket.size() + 1);
  const int opened = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (opened < 0) return std::nullopt;
  return Journal{opened, address};
}

Journal::Journal(Journal&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), address_(other.address_) {}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool Journal::send(LogLevel level, std::string_view name, std::string_view text, const LogPlace& place,
                   const LogOrigin& origin) const {
  std::string escaped;
  if (!is_printable_line(text)) text = escaped = printable(text);
  const std::string_view shown = cut(text, kLongestText);
  std::array<char, 12> line{};
  const auto digits = std::to_chars(line.data(), line.data() + line.size(), place.line);
  Entry entry;
  entry.add("MESSAGE", {"[", name, "] ", shown, shown.size() < text.size() ? kMark : std::string_view{}});
  entry.add("PRIORITY", {priority_of(level)});
  entry.add("SYSLOG_IDENTIFIER", {"nacelle"});
  entry.add("NACELLE_LOGGER", {name});
  entry.add("NACELLE_NODE", {origin.node});
  entry.add("NACELLE_COMPONENT", {origin.component});
  if (*place.file != '\0') {
    entry.add("CODE_FILE", {place.file});
    entry.add("CODE_LINE", {std::string_view{line.data(), static_cast<std::size_t>(digits.ptr - line.data())}});
    entry.add("CODE_FUNC", {place.function});
  }
  const msghdr message = entry.message(address_);
  // Without waiting: real-time threads write lines, too.
  return ::sendmsg(descriptor_, &message, MSG_NOSIGNAL | MSG_DONTWAIT) >= 0;
}

}  // namespace nacelle
