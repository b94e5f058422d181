// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/recording_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/file_fault.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "record/model/bag_rows_reader.hpp"
#include "record/port/recording_file.hpp"
#include "record/port/sqlite_fault.hpp"
#include "record/port/sqlite_file.hpp"

namespace nacelle::cli {
namespace {

/// "bag_2" is before "bag_10".
bool is_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const auto number = [](const std::string& text, std::size_t& at) {
      const std::size_t begin = std::min(text.find_first_not_of('0', at), text.size());
      at = begin;
      while (at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0) ++at;
      return text.substr(begin, at - begin);
    };
    if (std::isdigit(static_cast<unsigned char>(a[i])) != 0 && std::isdigit(static_cast<unsigned char>(b[j])) != 0) {
      const std::string left = number(a, i), right = number(b, j);
      if (left != right) return left.size() != right.size() ? left.size() < right.size() : left < right;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

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
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return std::vector{path};
  std::vector<std::string> files;
  std::filesystem::directory_iterator entry{path, error};
  for (; !error && entry != std::filesystem::directory_iterator{}; entry.increment(error)) {
    const auto extension = entry->path().extension();
    if (extension == ".mcap" || extension == ".db3") files.push_back(entry->path().string());
  }
  if (error)
    return err(Problem{Place{path, 0}, "cannot be read: " + error.message(), "",
                       file_fault_of(error.value(), FileFault::Unreadable)});
  if (auto wrong = compressed(path)) return err(std::move(*wrong));
  const auto databases = std::count_if(files.begin(), files.end(), is_sqlite);
  if (databases > 0 && static_cast<std::size_t>(databases) < files.size())
    return err(Problem{Place{path, 0}, "has files that end in .mcap and in .db3", "name the files that are meant",
                       FileFault::NotFound, ""});
  if (files.empty())
    return err(Problem{Place{path, 0}, "has no file that ends in .mcap or .db3",
                       "name a recording, or the folder of one", FileFault::NotFound});
  std::sort(files.begin(), files.end(), is_before);
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
