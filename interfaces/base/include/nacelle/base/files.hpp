// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "nacelle/base/file_fault.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle {

/// What a file from outside may have unless its reader knows a smaller limit: 16 MiB.
inline constexpr std::size_t kMostFileBytes = std::size_t{16} << 20U;

/// Returns the content of a regular file. Never waits for a peer: a FIFO, a socket, a device and a folder are refused, and a file
/// that grows while it is read is refused at the limit.
///
/// Errors: a FileFault; `where` is the path.
/// Threads: any. A file on a file system that hangs hangs the calling thread.
[[nodiscard]] Result<std::string, Problem> read_regular_file(const std::string& path,
                                                             std::size_t most_bytes = kMostFileBytes);

/// Writes a whole file or leaves what was there: the text goes into a file beside it, which then takes its name. A symbolic link is
/// followed. What is no regular file (a terminal, /dev/stdout) is written to directly.
///
/// Errors: a FileFault; `where` is the path.
[[nodiscard]] Result<void, Problem> write_whole_file(const std::string& path, std::string_view text);

}  // namespace nacelle
