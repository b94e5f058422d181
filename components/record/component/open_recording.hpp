// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "record/model/ordered_messages.hpp"
#include "record/port/recording_file.hpp"

namespace nacelle::record {

/// The files of a recording, and their messages.
struct OpenRecording {
  std::vector<std::unique_ptr<FileSource>> files;
  std::unique_ptr<OrderedMessages> messages;

  /// Opens a file, or the files of a folder. Errors: a FileFault or an McapFault; `where` is the file.
  [[nodiscard]] static Result<OpenRecording, Problem> open(const std::string& path);
};

}  // namespace nacelle::record
