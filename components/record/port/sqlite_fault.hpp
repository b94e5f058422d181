// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::record {

/// Why a file cannot be read as rosbag2's SQLite recording. Problem::where is the file.
enum class SqliteFault : std::uint8_t {
  NotDatabase,  ///< It does not begin as a SQLite 3 file does.
  NotBag,       ///< A table or a column that rosbag2 makes is not there.
  Locked,       ///< Another program writes to it.
  Unfinished,   ///< A journal beside it has a part of its content: the program that wrote it was killed, or still runs.
  Compressed,   ///< Its messages are compressed one by one.
  TooLarge,     ///< More topics or longer texts than this reader accepts.
  Unreadable,   ///< SQLite cannot read it: it is damaged, or reading failed.
};
[[nodiscard]] constexpr const char* code_text(SqliteFault fault) {
  switch (fault) {
    case SqliteFault::NotDatabase: return "sqlite.not_database";
    case SqliteFault::NotBag: return "sqlite.not_bag";
    case SqliteFault::Locked: return "sqlite.locked";
    case SqliteFault::Unfinished: return "sqlite.unfinished";
    case SqliteFault::Compressed: return "sqlite.compressed";
    case SqliteFault::TooLarge: return "sqlite.too_large";
    case SqliteFault::Unreadable: return "sqlite.unreadable";
  }
  return "";
}

}  // namespace nacelle::record
