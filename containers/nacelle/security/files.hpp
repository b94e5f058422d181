// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::security {

// Reads and writes small files as a whole. Errors: a FileFault whose `where` is the file.

inline constexpr std::size_t kMostFileBytes = std::size_t{1} << 20U;

/// Returns the content of a regular file, without blocking. Errors: also anything else (a FIFO, a device), and a file
/// longer than kMostFileBytes.
[[nodiscard]] Result<std::string, Problem> read_file(const std::filesystem::path& path);

enum class Secrecy : std::uint8_t { Public, Private };
/// Replaces a file atomically: a concurrent reader sees the old file or the new one.
[[nodiscard]] Result<void, Problem> write_file(const std::filesystem::path& path, const std::string& text,
                                               Secrecy secrecy);
/// Creates a folder, and those above it. An existing folder keeps its mode.
[[nodiscard]] Result<void, Problem> make_folder(const std::filesystem::path& path, Secrecy secrecy);
/// Creates a symbolic link to `target`, which is relative to the link's folder.
[[nodiscard]] Result<void, Problem> make_link(const std::filesystem::path& link, const std::filesystem::path& target);

}  // namespace nacelle::security
