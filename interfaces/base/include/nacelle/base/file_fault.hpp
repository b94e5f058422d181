// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cerrno>
#include <cstdint>

namespace nacelle {

/// Why a file cannot be read or written. Problem::where is its path.
enum class FileFault : std::uint8_t {
  NotFound,      ///< The file, or a folder of its path, does not exist.
  NotPermitted,  ///< The user may not read or write it, or the file system is read-only.
  NotRegular,    ///< It is a folder, a FIFO, a socket or a device.
  TooLarge,      ///< It has more bytes than its reader accepts.
  NoRoom,        ///< The disk, the user's quota or the limit of file sizes (ulimit -f) is exhausted.
  Unreadable,    ///< Reading failed for another reason; the text has the kernel's words.
  Unwritable,    ///< Writing failed for another reason; the text has the kernel's words.
};
[[nodiscard]] constexpr const char* code_text(FileFault fault) {
  switch (fault) {
    case FileFault::NotFound: return "file.not_found";
    case FileFault::NotPermitted: return "file.not_permitted";
    case FileFault::NotRegular: return "file.not_regular";
    case FileFault::TooLarge: return "file.too_large";
    case FileFault::NoRoom: return "file.no_room";
    case FileFault::Unreadable: return "file.unreadable";
    case FileFault::Unwritable: return "file.unwritable";
  }
  return "";
}

/// Returns the fault of an error number; `otherwise` for one that has no fault of its own.
[[nodiscard]] constexpr FileFault file_fault_of(int error, FileFault otherwise) {
  switch (error) {
    case ENOENT:
    case ENOTDIR: return FileFault::NotFound;
    case EACCES:
    case EPERM:
    case EROFS: return FileFault::NotPermitted;
    case EISDIR: return FileFault::NotRegular;
    case ENOSPC:
    case EDQUOT:
    case EFBIG: return FileFault::NoRoom;
    default: return otherwise;
  }
}

}  // namespace nacelle
