// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace nacelle::runtime {

using SymbolText = std::array<char, 256>;

/// Finds the function of an ELF file that an address lies in, as the linker names it; a longer name is cut off. `address` is that of
/// the file, before it is moved to where it is loaded. Returns false for a file that is none, is damaged, or does not say.
/// Async-signal-safe: reads the file by pread() and calls nothing else.
[[nodiscard]] bool find_symbol(const char* file, std::uint64_t address, SymbolText& name) noexcept;

}  // namespace nacelle::runtime
