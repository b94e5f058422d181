// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_merge.hpp"

#include <fmt/format.h>

#include <functional>
#include <memory>
#include <utility>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/file_fault.hpp"
#include "record/model/recording_merge.hpp"
#include "record/model/recording_summary.hpp"
#include "record/port/recording_file.hpp"
#include "record/protocol/compression.hpp"
#include "record/protocol/mcap_writer.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

struct Input {
  std::string path;
  std::unique_ptr<RecordingFile> file;
  std::unique_ptr<record::RecordingSummary> summary;
};

Result<std::vector<Input>, Problem> open_all(const std::vector<std::string>& paths) {
  std::vector<Input> inputs;
  for (const auto& path : paths) {
    const auto files = recording_files(path);
    if (!files) return err(files.error());
    for (const auto& name : *files) {
      auto file = open_recording(name);
      if (!file) return err(file.error());
      inputs.push_back({name, std::move(*file), std::make_unique<record::RecordingSummary>()});
    }
  }
  return inputs;
}

/// Reads each file once, and says what keeps them from being merged.
bool can_be_merged(std::vector<Input>& inputs) {
  bool good = true;
  std::vector<std::reference_wrapper<const record::RecordingSummary>> summaries;
  for (auto& input : inputs) {
    input.file->walk(*input.summary);
    for (const auto& problem : input.summary->problems()) complain(problem_of(input.path, problem));
    good = good && input.summary->problems().empty();
    summaries.emplace_back(*input.summary);
  }
  if (!good) return false;
  const auto conflict = record::type_conflict(summaries);
  if (!conflict) return true;
  complain(Problem{Place{inputs[conflict->recordings[1]].path, 0},
                   fmt::format("topic {} has the type {}, but {} in {}", conflict->topic, conflict->types[1],
                               conflict->types[0], inputs[conflict->recordings[0]].path),
                   "leave the topic out of one of them: `nacelle bag filter --exclude-regex`",
                   record::McapFault::Conflict, conflict->topic});
  return false;
}

/// The text that all have, or `otherwise`.
std::string common(const std::vector<Input>& inputs, const std::string& (record::RecordingSummary::*text)() const,
                   const char* otherwise) {
  const std::string& first = (*inputs.front().summary.*text)();
  for (const auto& input : inputs) {
    if ((*input.summary.*text)() != first) return otherwise;
  }
  return first;
}

}  // namespace

int merge_bags(const BagMergeWish& wish) {
  auto inputs = open_all(wish.paths);
  if (!inputs) return complain(inputs.error());
  if (!can_be_merged(*inputs)) return kFailed;
  for (const auto& input : *inputs) warn_of_undefined(input.path, *input.file);

  auto sink = record::FileSink::create(wish.output);
  if (!sink) return complain(sink.error());
  record::McapWriter writer{**sink,
                            {.compression = *record::compression_of(wish.compression == "none" ? "" : wish.compression),
                             .profile = common(*inputs, &record::RecordingSummary::profile, ""),
                             .library = common(*inputs, &record::RecordingSummary::library, "nacelle")}};
  std::vector<record::MergeSource> sources;
  for (const auto& input : *inputs) {
    RecordingFile* const file = input.file.get();
    sources.push_back({[file](record::McapVisitor& visitor) { return file->read(visitor); }, input.summary->first(),
                       input.summary->disorder()});
  }
  record::RecordingMerge merge{writer, std::move(sources)};
  if (!writer.start()) return complain((*sink)->problem());
  if (!merge.run()) {
    if (!(*sink)->has_failed())
      return complain(Problem{Place{wish.output, 0}, "is incomplete: a recording changed while it was read",
                              "merge them when nothing writes to them", FileFault::Unreadable});
    return complain((*sink)->problem());
  }
  if (!writer.finish() || !(*sink)->sync()) return complain((*sink)->problem());
  print_text("%s: %zu messages of %zu file%s, %s", wish.output.c_str(), static_cast<std::size_t>(merge.messages()),
             inputs->size(), inputs->size() == 1 ? "" : "s", size_text(writer.written()).c_str());
  if (merge.late() > 0)
    print_text("; %zu are behind later ones: a recording is too far out of order",
               static_cast<std::size_t>(merge.late()));
  print_text("\n");
  return kDone;
}

}  // namespace nacelle::cli
