// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/recording_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

#include "nacelle/base/file_fault.hpp"
#include "record/port/recording_file.hpp"

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
  std::unique_ptr<record::RecordingReader> read(record::McapVisitor& visitor) override {
    return record::read_mcap(*source_, visitor);
  }

 private:
  const std::unique_ptr<record::FileSource> source_;
};

}  // namespace

bool RecordingFile::walk(record::McapVisitor& visitor) {
  const auto reader = read(visitor);
  while (reader->next()) {}
  return reader->is_complete();
}

Result<std::unique_ptr<RecordingFile>, Problem> open_recording(const std::string& path) {
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
    if (entry->path().extension() == ".mcap") files.push_back(entry->path().string());
  }
  if (error)
    return err(Problem{Place{path, 0}, "cannot be read: " + error.message(), "",
                       file_fault_of(error.value(), FileFault::Unreadable)});
  if (files.empty())
    return err(Problem{Place{path, 0}, "has no file that ends in .mcap", "name a recording, or the folder of one",
                       FileFault::NotFound});
  std::sort(files.begin(), files.end(), is_before);
  return files;
}

Problem problem_of(const std::string& file, const record::McapProblem& problem) {
  const bool mends = problem.fault != record::McapFault::NoMagic && problem.fault != record::McapFault::Unreadable &&
                     problem.fault != record::McapFault::BadPayload;
  return {Place{file, 0}, fmt::format("{} (byte {})", problem.what, problem.offset),
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
