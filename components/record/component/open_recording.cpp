// SPDX-License-Identifier: Apache-2.0
#include "record/component/open_recording.hpp"

#include <fmt/format.h>

#include <utility>

#include "record/port/recording_folder.hpp"

namespace nacelle::record {

Result<OpenRecording, Problem> OpenRecording::open(const std::string& path) {
  const auto paths = recording_files(path);
  if (!paths) return err(paths.error());
  OpenRecording made;
  std::vector<ByteSource*> sources;
  for (const std::string& one : *paths) {
    auto file = FileSource::open(one);
    if (!file) return err(file.error());
    made.files.push_back(std::move(*file));
    sources.push_back(made.files.back().get());
  }
  auto messages = OrderedMessages::open(sources);
  if (!messages) {
    const auto& [file, problem] = messages.error();
    return err(Problem{Place{(*paths)[file], 0}, fmt::format("{} (byte {})", problem.what, problem.offset),
                       problem.fault == McapFault::NoMagic
                           ? "name an MCAP file; `nacelle bag convert` makes one of a .db3 file"
                           : "`nacelle bag recover` copies what can be read",
                       problem.fault});
  }
  made.messages = std::move(*messages);
  return made;
}

}  // namespace nacelle::record
