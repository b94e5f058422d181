// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "record/protocol/mcap_fault.hpp"
#include "record/protocol/mcap_walk.hpp"

namespace nacelle::cli {

/// Returns the files of a recording: the file itself, or those with the ending .mcap or .db3 in a folder that `ros2 bag record`
/// made, in the order of the numbers in their names.
/// Errors: a FileFault, or a SqliteFault if metadata.yaml says that messages or files are compressed; `where` is the path.
[[nodiscard]] Result<std::vector<std::string>, Problem> recording_files(const std::string& path);

/// A file of a recording that is open.
class RecordingFile {
 public:
  RecordingFile() = default;
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;
  virtual ~RecordingFile() = default;

  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// "mcap" or "sqlite3", as rosbag2 names them.
  [[nodiscard]] virtual const char* storage() const = 0;
  /// Types of topics whose definition is known neither to the file nor to this program, sorted; after it was read.
  [[nodiscard]] virtual std::vector<std::string> undefined() const { return {}; }
  /// Returns a reader that begins at the start. `visitor` and this outlive it.
  [[nodiscard]] virtual std::unique_ptr<record::RecordingReader> read(record::McapVisitor& visitor) = 0;
  /// Hands over the whole file. Returns false if a problem ended it early.
  bool walk(record::McapVisitor& visitor);
};

/// The path ends in .db3: it is read as a file of rosbag2's SQLite storage, not as MCAP.
[[nodiscard]] bool is_sqlite(const std::string& path);

/// Opens an MCAP file, or a file of rosbag2's SQLite storage.
/// Errors: a FileFault or a SqliteFault; `where` is the path.
[[nodiscard]] Result<std::unique_ptr<RecordingFile>, Problem> open_recording(const std::string& path);

/// Warns of types without a definition, after the file was read: a schema without a text is legal, but its messages can be read only where
/// the type is known.
void warn_of_undefined(const std::string& path, const RecordingFile& file);

/// Returns the problem as it is printed: the file, the place in it, and what can be done.
[[nodiscard]] Problem problem_of(const std::string& file, const record::McapProblem& problem);

/// "1.2 MiB", as ros2 prints sizes.
[[nodiscard]] std::string size_text(std::uint64_t bytes);

}  // namespace nacelle::cli
