// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::security {

// Small files, whole. Errors: a FileFault whose `where` is the file.

inline constexpr std::size_t kMostFileBytes = std::size_t{1} << 20U;

/// Never waits for a writer. Errors: also what is no regular file (a FIFO, a device), and one with more than
/// kMostFileBytes, of which no more is read.
[[nodiscard]] Result<std::string, Problem> read_file(const std::filesystem::path& path);

enum class Secrecy : std::uint8_t { Public, Private };
/// Puts it there whole or not at all: a concurrent reader sees the old file or the new one.
[[nodiscard]] Result<void, Problem> write_file(const std::filesystem::path& path, const std::string& text,
                                               Secrecy secrecy);
/// A folder, with those above it. One that is there keeps its mode.
[[nodiscard]] Result<void, Problem> make_folder(const std::filesystem::path& path, Secrecy secrecy);
/// A link beside which `target`, as the link names it, is found.
[[nodiscard]] Result<void, Problem> make_link(const std::filesystem::path& link, const std::filesystem::path& target);

}  // namespace nacelle::security
