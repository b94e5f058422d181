// SPDX-License-Identifier: Apache-2.0
#include "symbol.hpp"

#include <elf.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

namespace nacelle::runtime {
namespace {

constexpr std::size_t kMostSections = 1024;
constexpr std::uint64_t kMostSymbols = 4'000'000;

class SymbolFile {
 public:
  explicit SymbolFile(const char* path) : file_(::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~SymbolFile() {
    if (file_ >= 0) ::close(file_);
  }
  SymbolFile(const SymbolFile&) = delete;
  SymbolFile& operator=(const SymbolFile&) = delete;

  /// Reads the available bytes, at most `size`.
  [[nodiscard]] std::size_t read(void* into, std::size_t size, std::uint64_t at) const noexcept {
    if (file_ < 0 || at > static_cast<std::uint64_t>(INT64_MAX)) return 0;
    const ssize_t n = ::pread(file_, into, size, static_cast<off_t>(at));
    return n > 0 ? static_cast<std::size_t>(n) : 0;
  }
  template <typename T>
  [[nodiscard]] bool read_whole(T& into, std::uint64_t at) const noexcept {
    return read(&into, sizeof into, at) == sizeof into;
  }

 private:
  const int file_;
};

bool name_at(const SymbolFile& file, std::uint64_t at, SymbolText& name) noexcept {
  name.fill('\0');
  static_cast<void>(file.read(name.data(), name.size() - 1, at));
  return name.front() != '\0';
}

bool search_symbols(const SymbolFile& file, const Elf64_Shdr& symbols, std::uint64_t names_at, std::uint64_t address,
                    SymbolText& name) noexcept {
  std::array<Elf64_Sym, 128> block{};
  const std::uint64_t count = std::min(symbols.sh_size / sizeof(Elf64_Sym), kMostSymbols);
  for (std::uint64_t done = 0; done < count;) {
    const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), count - done));
    const std::size_t here =
        file.read(block.data(), wanted * sizeof(Elf64_Sym), symbols.sh_offset + done * sizeof(Elf64_Sym)) /
        sizeof(Elf64_Sym);
    if (here == 0) return false;
    for (std::size_t i = 0; i < here; ++i) {
      const Elf64_Sym& symbol = block[i];
      if (ELF64_ST_TYPE(symbol.st_info) != STT_FUNC || symbol.st_shndx == SHN_UNDEF) continue;
      if (address >= symbol.st_value && address - symbol.st_value < symbol.st_size)
        return name_at(file, names_at + symbol.st_name, name);
    }
    done += here;
  }
  return false;
}

}  // namespace

bool find_symbol(const char* path, std::uint64_t address, SymbolText& name) noexcept {
  const SymbolFile file{path};
  Elf64_Ehdr header{};
  if (!file.read_whole(header, 0) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
      header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_shentsize != sizeof(Elf64_Shdr) ||
      header.e_shnum > kMostSections)
    return false;
  const auto section = [&](std::size_t index, Elf64_Shdr& into) {
    return index < header.e_shnum && file.read_whole(into, header.e_shoff + index * sizeof(Elf64_Shdr));
  };
  // The full table first; a library that was stripped keeps the other.
  for (const std::uint32_t kind : {std::uint32_t{SHT_SYMTAB}, std::uint32_t{SHT_DYNSYM}}) {
    for (std::size_t i = 0; i < header.e_shnum; ++i) {
      Elf64_Shdr symbols{}, names{};
      if (!section(i, symbols)) return false;
      if (symbols.sh_type != kind || symbols.sh_entsize != sizeof(Elf64_Sym) || !section(symbols.sh_link, names))
        continue;
      if (search_symbols(file, symbols, names.sh_offset, address, name)) return true;
    }
  }
  return false;
}

}  // namespace nacelle::runtime
