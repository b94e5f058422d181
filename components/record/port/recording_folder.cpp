// SPDX-License-Identifier: Apache-2.0
#include "record/port/recording_folder.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <system_error>

#include "nacelle/base/file_fault.hpp"

namespace nacelle::record {
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

bool is_mcap(const std::filesystem::path& path) { return path.extension() == ".mcap"; }
bool is_database(const std::filesystem::path& path) { return path.extension() == ".db3"; }

}  // namespace

Result<std::vector<std::string>, Problem> recording_files(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return std::vector{path};
  std::vector<std::string> files;
  std::filesystem::directory_iterator entry{path, error};
  for (; !error && entry != std::filesystem::directory_iterator{}; entry.increment(error)) {
    if (is_mcap(entry->path()) || is_database(entry->path())) files.push_back(entry->path().string());
  }
  if (error)
    return err(Problem{Place{path, 0}, "cannot be read: " + error.message(), "",
                       file_fault_of(error.value(), FileFault::Unreadable)});
  if (files.empty())
    return err(Problem{Place{path, 0}, "has no file that ends in .mcap or .db3",
                       "name a recording, or the folder of one", FileFault::NotFound});
  const auto databases = std::count_if(files.begin(), files.end(), is_database);
  if (databases > 0 && static_cast<std::size_t>(databases) < files.size())
    return err(Problem{Place{path, 0}, "has files that end in .mcap and in .db3", "name the files that are meant",
                       FileFault::NotFound});
  std::sort(files.begin(), files.end(), is_before);
  return files;
}

std::optional<Problem> make_recording_folder(const std::string& path) {
  std::error_code error;
  const std::filesystem::path folder{path};
  if (folder.has_parent_path()) std::filesystem::create_directories(folder.parent_path(), error);
  if (!error && !std::filesystem::create_directory(folder, error) && !error)
    return Problem{Place{path, 0}, "exists already", "name another folder, or one with a time: bag_%Y%m%d_%H%M%S",
                   FileFault::Unwritable};
  if (error)
    return Problem{Place{path, 0}, "cannot be made: " + error.message(), "name a folder that this user may write to",
                   FileFault::Unwritable};
  return std::nullopt;
}

}  // namespace nacelle::record
