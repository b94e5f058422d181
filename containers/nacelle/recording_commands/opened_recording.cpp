// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/opened_recording.hpp"

#include <algorithm>

#include "cli/program.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {

std::optional<OpenedRecording> open_whole_recording(const std::string& path) {
  const auto files = recording_files(path);
  if (!files) {
    complain(files.error());
    return std::nullopt;
  }
  OpenedRecording opened;
  opened.files = *files;
  bool is_good = true, has_messages = false;
  for (const auto& file : opened.files) {
    auto source = record::FileSource::open(file);
    if (!source) {
      complain(source.error());
      return std::nullopt;
    }
    record::RecordingSummary summary;
    record::walk_mcap(**source, summary);
    opened.sources.push_back(std::move(*source));
    for (const auto& problem : summary.problems()) complain(problem_of(file, problem));
    is_good = is_good && summary.problems().empty();
    if (summary.messages() > 0) {
      opened.first = has_messages ? std::min(opened.first, summary.first()) : summary.first();
      has_messages = true;
    }
    for (const auto& [id, topic] : summary.topics()) {
      const auto [known, is_new] = opened.topics.try_emplace(topic.name, topic);
      if (!is_new) known->second.messages += topic.messages;
    }
  }
  if (!is_good) return std::nullopt;
  return opened;
}

}  // namespace nacelle::cli
