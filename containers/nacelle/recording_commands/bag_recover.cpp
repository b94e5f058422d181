// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_recover.hpp"

#include <filesystem>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "record/model/recording_copy.hpp"
#include "record/port/recording_file.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

/// The header's profile and library stay as they were.
class Header final : public record::McapVisitor {
 public:
  void on_header(const record::McapHeader& header) override {
    profile = header.profile;
    library = header.library;
  }
  void on_problem(const record::McapProblem& problem) override { last = problem; }

  std::string profile = "ros2", library = "nacelle";
  record::McapProblem last{};
};

std::string default_output(const std::string& file) {
  const std::filesystem::path path{file};
  return (path.parent_path() / (path.stem().string() + ".recovered.mcap")).string();
}

}  // namespace

int recover_bag(const BagRecoverWish& wish) {
  auto source = record::FileSource::open(wish.file);
  if (!source) return complain(source.error());
  Header header;
  record::walk_mcap(**source, header);
  if (header.last.fault == record::McapFault::NoMagic && header.last.what[0] != '\0')
    return complain(problem_of(wish.file, header.last));
  const std::string output = wish.output.empty() ? default_output(wish.file) : wish.output;
  auto sink = record::FileSink::create(output);
  if (!sink) return complain(sink.error());
  record::McapWriter writer{**sink,
                            {.compression = *record::compression_of(wish.compression == "none" ? "" : wish.compression),
                             .profile = header.profile,
                             .library = header.library}};
  record::RecordingCopy copy{writer};
  const bool started = writer.start();
  record::walk_mcap(**source, copy);
  if (!started || copy.has_failed() || !writer.finish() || !(*sink)->sync()) return complain((*sink)->problem());
  print_text("%s: %zu messages, %s; %zu place%s could not be read\n", output.c_str(),
             static_cast<std::size_t>(copy.messages()), size_text(writer.written()).c_str(),
             static_cast<std::size_t>(copy.problems()), copy.problems() == 1 ? "" : "s");
  return kDone;
}

}  // namespace nacelle::cli
