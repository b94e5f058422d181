// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::record {

/// What a recorder has done so far.
struct RecorderFigures {
  struct Topic {
    std::string name, type;
    std::uint64_t messages = 0, bytes = 0;
    std::uint64_t lost_in_queue = 0;  ///< The recorder's thread was too late.
    std::uint64_t lost_to_disk = 0;   ///< The disk was too slow.
    std::uint64_t copies = 0;         ///< Of camera images: recording one copies it.
  };
  std::string folder, file;
  std::vector<Topic> topics;
  std::vector<std::string> absent;  ///< Topics that were named, and have had no message.
  std::size_t files = 0;
  std::uint64_t bytes = 0, messages = 0, lost = 0;
  std::uint64_t copies = 0, bytes_copied = 0;  ///< Of images.
  Duration recorded{};                         ///< Since its start.
  std::optional<Duration> reach;               ///< Of a ring: how far back it goes.
  std::optional<Problem> problem;              ///< It has ended by itself.
};

/// Returns the figures as words for the end of a log: "lost", "camera copies", and of topics what they lost.
[[nodiscard]] std::map<std::string, std::string> closing_words(const RecorderFigures& figures);

}  // namespace nacelle::record
