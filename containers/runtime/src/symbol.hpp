// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace nacelle::runtime {

using SymbolText = std::array<char, 256>;

/// Finds the mangled name of the function in an ELF file that contains an address; a longer name is cut off. `address`
/// is relative to the file, before relocation. Returns false if the file is not an ELF file, is damaged, or has no
/// symbol for it. Async-signal-safe: reads the file by pread() and calls nothing else.
[[nodiscard]] bool find_symbol(const char* file, std::uint64_t address, SymbolText& name) noexcept;

}  // namespace nacelle::runtime
