// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/recorder_words.hpp"

#include <utility>
#include <vector>

#include "record/model/bag_metadata.hpp"
#include "record/port/recording_file.hpp"
#include "record/protocol/mcap_walk.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

struct Words final : record::McapVisitor {
  void on_metadata_index(const record::McapMetadataIndex& index) override {
    if (index.name == record::kRecorderRecord) places.emplace_back(index.offset, index.length);
  }
  void on_metadata(const record::McapMetadata& metadata, const record::McapSpot&) override {
    if (metadata.name == record::kRecorderRecord) found = metadata.metadata;
  }
  void on_problem(const record::McapProblem&) override {}
  std::vector<std::pair<std::uint64_t, std::uint64_t>> places;
  std::map<std::string, std::string> found;
};

}  // namespace

std::map<std::string, std::string> recorder_words(const std::string& path) {
  const auto files = recording_files(path);
  if (!files || files->empty() || is_sqlite(files->back())) return {};
  auto source = record::FileSource::open(files->back());
  if (!source) return {};
  Words words;
  record::McapParts parts{**source, words};
  if (!parts.read_summary()) return {};
  for (const auto& [offset, length] : words.places) {
    if (!parts.read(offset, length)) return {};
  }
  return std::move(words.found);
}

}  // namespace nacelle::cli
