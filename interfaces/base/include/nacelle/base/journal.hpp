// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/un.h>

#include <optional>
#include <string>
#include <string_view>

#include "nacelle/base/log.hpp"

namespace nacelle {

/// Sends log lines to systemd's journal as entries with fields, so that `journalctl NACELLE_COMPONENT=/lidar` finds them.
///
/// Fields: MESSAGE ("[name] text"), PRIORITY, SYSLOG_IDENTIFIER, CODE_FILE, CODE_LINE, CODE_FUNC, NACELLE_LOGGER, and for the
/// logger of a node NACELLE_NODE and NACELLE_COMPONENT.
/// Threads: any.
/// Source: systemd, "Native Journal Protocol" (docs/JOURNAL_NATIVE_PROTOCOL.md).
class Journal {
 public:
  static constexpr const char* kSocket = "/run/systemd/journal/socket";
  /// Longer texts end with a mark. Entries stay below the size of a datagram, so that none needs a file of its own.
  static constexpr std::size_t kLongestText = 16'384;

  /// Returns the journal if `stream`, the value of JOURNAL_STREAM ("device:inode"), names the file behind `descriptor`: then
  /// the journal reads what is written there. `stream` may be null.
  [[nodiscard]] static std::optional<Journal> behind(const char* stream, int descriptor,
                                                     const std::string& socket = kSocket);
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();

  /// Sends one entry. Returns false if the journal cannot take it now. Allocates: nothing for a text without control characters.
  [[nodiscard]] bool send(LogLevel level, std::string_view name, std::string_view text, const LogPlace& place,
                          const LogOrigin& origin) const;

 private:
  Journal(int descriptor, const sockaddr_un& address) : descriptor_(descriptor), address_(address) {}
  int descriptor_;
  sockaddr_un address_;
};

/// Writes a line about a node (its full name) that the logger of another one writes, such as the container's about a fault. The
/// journal keeps it with the lines of that node.
void write_about(std::string_view node, const Logger& log, LogLevel level, std::string_view text,
                 const LogPlace& place = {__builtin_FILE(), __builtin_FUNCTION(), __builtin_LINE()});

}  // namespace nacelle
