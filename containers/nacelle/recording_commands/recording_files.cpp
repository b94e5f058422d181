// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/recording_files.hpp"

#include <fmt/format.h>

#include <array>

namespace nacelle::cli {
Problem problem_of(const std::string& file, const record::McapProblem& problem) {
  const bool mends = problem.fault != record::McapFault::NoMagic && problem.fault != record::McapFault::Unreadable &&
                     problem.fault != record::McapFault::BadPayload;
  return {Place{file, 0}, fmt::format("{} (byte {})", problem.what, problem.offset),
          mends ? "`nacelle bag recover` copies what can be read" : "", problem.fault, std::to_string(problem.offset)};
}

std::string size_text(std::uint64_t bytes) {
  constexpr std::array kUnits{"B", "KiB", "MiB", "GiB", "TiB"};
  auto size = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; size >= 1024.0 && unit + 1 < kUnits.size(); ++unit) size /= 1024.0;
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.1f} {}", size, kUnits[unit]);
}

}  // namespace nacelle::cli
