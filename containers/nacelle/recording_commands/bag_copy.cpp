// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_copy.hpp"

#include <filesystem>
#include <memory>
#include <utility>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "record/model/recording_copy.hpp"
#include "record/model/recording_summary.hpp"
#include "record/model/topic_choice.hpp"
#include "record/port/recording_file.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

using Sources = std::vector<std::unique_ptr<RecordingFile>>;

std::uint64_t nanoseconds(double seconds) { return static_cast<std::uint64_t>(seconds * 1e9); }

/// What all files have together.
struct Found {
  std::string profile = "ros2", library = "nacelle";
  std::uint64_t messages = 0, first = 0;
  std::vector<Problem> problems;
  bool is_recording = true;
};

Found look_at(const std::vector<std::string>& files, Sources& sources) {
  Found found;
  for (std::size_t at = 0; at < files.size(); ++at) {
    record::RecordingSummary summary;
    sources[at]->walk(summary);
    for (const auto& problem : summary.problems()) {
      found.problems.push_back(problem_of(files[at], problem));
      if (problem.fault == record::McapFault::NoMagic) found.is_recording = false;
    }
    if (summary.messages() > 0 && (found.messages == 0 || summary.first() < found.first)) found.first = summary.first();
    found.messages += summary.messages();
    found.profile = summary.profile();
    found.library = summary.library();
  }
  return found;
}

record::RecordingSelection selection_of(const BagCopyWish& wish, std::uint64_t first) {
  record::RecordingSelection selection;
  selection.from = first + nanoseconds(wish.start_offset_s);
  if (wish.start_offset_s == 0.0)
    selection.from = 0;  // also what is before the first message by a clock that stepped back
  if (wish.duration_s > 0.0) selection.to = first + nanoseconds(wish.start_offset_s) + nanoseconds(wish.duration_s);
  if (wish.topics.empty() && wish.regex.empty() && wish.exclude_regex.empty()) return selection;
  record::TopicWish topics{
      .topics = wish.topics, .regex = wish.regex, .exclude_regex = wish.exclude_regex, .hidden = true};
  topics.all = wish.topics.empty() && wish.regex.empty();
  // The command line was checked (wrong_regex).
  selection.wants_topic = [choice = record::TopicChoice::make(std::move(topics)).value()](const std::string& topic) {
    return choice.takes(topic);
  };
  return selection;
}

std::string default_output(const std::string& path) {
  std::filesystem::path file = std::filesystem::path{path}.lexically_normal();
  if (!file.has_filename()) file = file.parent_path();  // "folder/"
  return (file.parent_path() / (file.stem().string() + ".recovered.mcap")).string();
}

}  // namespace

std::string wrong_regex(const std::string& text) {
  const auto made = record::TopicChoice::make({.regex = text});
  return made ? "" : made.error().what;
}

int copy_bag(const BagCopyWish& wish) {
  const auto files = recording_files(wish.path);
  if (!files) return complain(files.error());
  Sources sources;
  for (const auto& file : *files) {
    auto source = open_recording(file);
    if (!source) return complain(source.error());
    sources.push_back(std::move(*source));
  }
  const Found found = look_at(*files, sources);
  if (!found.problems.empty() && (!wish.despite_problems || !found.is_recording)) {
    for (const auto& problem : found.problems) complain(problem);
    return kFailed;
  }

  for (std::size_t at = 0; at < sources.size(); ++at) warn_of_undefined((*files)[at], *sources[at]);
  const std::string output = wish.output.empty() ? default_output(wish.path) : wish.output;
  auto sink = record::FileSink::create(output);
  if (!sink) return complain(sink.error());
  record::McapWriter writer{**sink,
                            {.compression = *record::compression_of(wish.compression == "none" ? "" : wish.compression),
                             .profile = found.profile,
                             .library = found.library}};
  bool good = writer.start();
  std::uint64_t messages = 0;
  for (const auto& source : sources) {
    record::RecordingCopy copy{writer, selection_of(wish, found.first)};
    source->walk(copy);
    good = good && !copy.has_failed();
    messages += copy.messages();
  }
  if (!good || !writer.finish() || !(*sink)->sync()) return complain((*sink)->problem());
  const std::size_t places = found.problems.size();
  print_text("%s: %zu of %zu messages, %s", output.c_str(), static_cast<std::size_t>(messages),
             static_cast<std::size_t>(found.messages), size_text(writer.written()).c_str());
  if (places > 0) print_text("; %zu place%s could not be read", places, places == 1 ? "" : "s");
  print_text("\n");
  return kDone;
}

}  // namespace nacelle::cli
