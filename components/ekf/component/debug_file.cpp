// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/debug_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "nacelle/base/file_fault.hpp"

namespace nacelle::ekf {
namespace {

std::string variable(const char* name) {
  const char* const value = ::secure_getenv(name);
  return value == nullptr ? "" : value;
}

std::string default_folder() {
  const std::string of_service = variable("RUNTIME_DIRECTORY");  // of systemd: several, with ':' between
  if (!of_service.empty()) return of_service.substr(0, of_service.find(':'));
  const std::string of_user = variable("XDG_RUNTIME_DIR");
  return of_user.empty() ? fmt::format("/dev/shm/nacelle-{}", ::geteuid()) : of_user + "/nacelle";
}

Problem unwritable(const std::string& path, int error) {
  return {Place{path, 0}, std::generic_category().message(error),
          "give debug_out_file a path that this user may write to", file_fault_of(error, FileFault::Unwritable)};
}

bool is_in_memory(const std::string& folder) {
  struct statfs found {};
  if (::statfs(folder.c_str(), &found) != 0) return false;
  const auto kind = static_cast<std::uint32_t>(found.f_type);  // signed, and as wide as the machine's words
  return kind == TMPFS_MAGIC || kind == RAMFS_MAGIC;
}

}  // namespace

DebugFile::File DebugFile::create(const std::string& path) {
  const int number = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (number < 0) return nullptr;
  File file{::fdopen(number, "w")};
  if (file == nullptr) {
    ::close(number);
    return nullptr;
  }
  static_cast<void>(std::setvbuf(file.get(), nullptr, _IONBF, 0));  // a reader sees whole lines
  return file;
}

std::string DebugFile::path_for(const std::string& name, const std::string& node) {
  if (name.starts_with('/')) return name;
  if (!name.empty()) return default_folder() + "/" + name;
  std::string of_node = node;
  std::replace(of_node.begin(), of_node.end(), '/', '.');
  return fmt::format("{}/robot_localization_debug{}.txt", default_folder(), of_node);
}

Result<DebugFile, Problem> DebugFile::open(std::string path, std::size_t most_bytes) {
  const std::string folder = path.substr(0, std::max<std::size_t>(path.rfind('/'), 1));
  if (folder == default_folder() && ::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
    return err(unwritable(folder, errno));
  struct stat found {};
  if (::stat(folder.c_str(), &found) != 0) return err(unwritable(folder, errno));
  if (!is_in_memory(folder)) {
    return err(Problem{Place{path, 0}, "is not in memory; debug output would wear out the robot's card",
                       "leave debug_out_file out, or give a path in /dev/shm or /run", FileFault::NotPermitted});
  }
  File file = create(path);
  if (file == nullptr) return err(unwritable(path, errno));
  return DebugFile{std::move(path), most_bytes, std::move(file)};
}

bool DebugFile::write(std::string_view text) {
  if (file_ == nullptr) return false;
  if (bytes_ > 0 && bytes_ + text.size() > most_bytes_) {
    static_cast<void>(std::rename(path_.c_str(), (path_ + ".1").c_str()));
    file_ = create(path_);
    bytes_ = 0;
    if (file_ == nullptr) return false;
  }
  bytes_ += text.size();
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size()) return true;
  file_.reset();
  return false;
}

}  // namespace nacelle::ekf
