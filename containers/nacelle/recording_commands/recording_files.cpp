// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/recording_files.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "record/model/bag_rows_reader.hpp"
#include "record/port/recording_file.hpp"
#include "record/port/recording_folder.hpp"
#include "record/port/sqlite_fault.hpp"
#include "record/port/sqlite_file.hpp"

namespace nacelle::cli {
namespace {

class McapFile final : public RecordingFile {
 public:
  explicit McapFile(std::unique_ptr<record::FileSource> source) : source_(std::move(source)) {}
  std::uint64_t size() const override { return source_->size(); }
  const char* storage() const override { return "mcap"; }
  std::unique_ptr<record::RecordingReader> read(record::McapVisitor& visitor) override {
    return record::read_mcap(*source_, visitor);
  }

 private:
  const std::unique_ptr<record::FileSource> source_;
};

/// Definitions that the file lacks are those of the message packages that are installed.
class DatabaseFile final : public RecordingFile {
 public:
  explicit DatabaseFile(std::unique_ptr<record::SqliteFile> rows)
      : rows_(std::move(rows)), library_(message_library_directories()) {}
  std::uint64_t size() const override { return rows_->size(); }
  const char* storage() const override { return "sqlite3"; }
  std::vector<std::string> undefined() const override { return {undefined_.begin(), undefined_.end()}; }
  std::unique_ptr<record::RecordingReader> read(record::McapVisitor& visitor) override {
    return std::make_unique<record::BagRowsReader>(*rows_, visitor,
                                                   [this](const std::string& type) { return definition_of(type); });
  }

 private:
  std::optional<std::string> definition_of(const std::string& type) {
    if (const auto message = library_.message(type)) return (*message)->definition;
    undefined_.insert(type);
    return std::nullopt;
  }

  const std::unique_ptr<record::SqliteFile> rows_;
  msgs::TypeLibrary library_;
  std::set<std::string> undefined_;
};

/// What metadata.yaml says of compression, which the files themselves do not say.
std::optional<Problem> compressed(const std::filesystem::path& folder) {
  const std::string path = (folder / "metadata.yaml").string();
  const auto text = read_regular_file(path);
  if (!text) return std::nullopt;  // the files are enough
  constexpr std::string_view kKey = "compression_mode:";
  const std::size_t at = text->find(kKey);
  if (at == std::string::npos) return std::nullopt;
  const std::string mode = text->substr(at + kKey.size(), text->find('\n', at) - at - kKey.size());
  for (const char* const packed : {"FILE", "file", "MESSAGE", "message"}) {
    if (mode.find(packed) != std::string::npos)
      return Problem{Place{path, 0}, fmt::format("its files are compressed by rosbag2 (mode {})", packed),
                     "convert it with `ros2 bag convert` first", record::SqliteFault::Compressed, packed};
  }
  return std::nullopt;
}

}  // namespace

bool is_sqlite(const std::string& path) { return std::filesystem::path{path}.extension() == ".db3"; }

bool RecordingFile::walk(record::McapVisitor& visitor) {
  const auto reader = read(visitor);
  while (reader->next()) {}
  return reader->is_complete();
}

Result<std::unique_ptr<RecordingFile>, Problem> open_recording(const std::string& path) {
  if (is_sqlite(path)) {
    auto rows = record::SqliteFile::open(path);
    if (!rows) return err(rows.error());
    return std::unique_ptr<RecordingFile>{std::make_unique<DatabaseFile>(std::move(*rows))};
  }
  auto source = record::FileSource::open(path);
  if (!source) return err(source.error());
  return std::unique_ptr<RecordingFile>{std::make_unique<McapFile>(std::move(*source))};
}

Result<std::vector<std::string>, Problem> recording_files(const std::string& path) {
  auto files = record::recording_files(path);
  if (files) {
    if (auto wrong = compressed(path)) return err(std::move(*wrong));
  }
  return files;
}

void warn_of_undefined(const std::string& path, const RecordingFile& file) {
  const auto types = file.undefined();
  if (types.empty()) return;
  complain(Problem{Place{path, 0}, "has no definition of " + join(types) + ", and none is installed",
                   "install the package with its messages, or the copy has an empty schema",
                   record::McapFault::NoDefinition, join(types)});
}

Problem problem_of(const std::string& file, const record::McapProblem& problem) {
  const bool mends = problem.fault != record::McapFault::NoMagic && problem.fault != record::McapFault::Unreadable &&
                     problem.fault != record::McapFault::BadPayload;
  return {Place{file, 0}, fmt::format("{} ({} {})", problem.what, is_sqlite(file) ? "row" : "byte", problem.offset),
          mends ? "`nacelle bag recover` copies what can be read" : "", problem.fault, std::to_string(problem.offset)};
}

std::string size_text(std::uint64_t bytes) {
  constexpr std::array kUnits{"B", "KiB", "MiB", "GiB", "TiB"};
  auto size = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; size >= 1024.0 && unit + 1 < kUnits.size(); ++unit) size /= 1024.0;
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.1f} {}", size, kUnits[unit]);
}

}  // namespace nacelle::cli
