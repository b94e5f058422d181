// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "record/model/recording_summary.hpp"
#include "record/port/recording_file.hpp"

namespace nacelle::cli {

/// The files of a recording, each read once from its start to its end.
struct OpenedRecording {
  std::vector<std::string> files;
  std::vector<std::unique_ptr<record::FileSource>> sources;  ///< In the order of `files`.
  std::map<std::string, record::RecordedTopic> topics;       ///< By name. Of several types the first.
  std::uint64_t first = 0;                                   ///< Time of the first message.
};

/// Opens a recording and counts what it has. Returns nothing if it cannot be read to its end; the errors have been printed.
[[nodiscard]] std::optional<OpenedRecording> open_whole_recording(const std::string& path);

}  // namespace nacelle::cli
