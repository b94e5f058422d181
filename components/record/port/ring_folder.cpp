// SPDX-License-Identifier: Apache-2.0
#include "record/port/ring_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <system_error>

#include "nacelle/base/file_fault.hpp"

namespace nacelle::record {
namespace {

constexpr const char* kPrefix = "nacelle-ring-";
constexpr std::size_t kRandomLetters = 6;  // mkdtemp's
constexpr std::size_t kLongestName = 160;

Problem problem_of(const std::string& path, int error, const char* what) {
  const bool is_full = error == ENOSPC || error == EDQUOT;
  return {Place{path, 0}, fmt::format("{}: {}", what, std::generic_category().message(error)),
          is_full ? "make room in it, or choose a smaller ring (storage.ring_size, --ring-size)"
                  : "the ring needs a /dev/shm that this user may write to",
          file_fault_of(error, FileFault::Unwritable)};
}

io::Descriptor open_folder(const std::string& path) {
  return io::Descriptor{::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)};
}

bool lock(const io::Descriptor& folder) { return ::flock(folder.number(), LOCK_EX | LOCK_NB) == 0; }

/// Nobody removed the folder, or put another one into its place, before it was locked.
bool is_still_at(const std::string& path, const struct stat& seen) {
  struct stat now {};
  return ::lstat(path.c_str(), &now) == 0 && now.st_dev == seen.st_dev && now.st_ino == seen.st_ino;
}

bool write_all(int file, ByteView bytes) {
  while (!bytes.empty()) {
    const auto count = ::write(file, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = ENOSPC;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

bool is_private(const struct stat& status, uid_t user) {
  return S_ISDIR(status.st_mode) && status.st_uid == user && (status.st_mode & 077U) == 0;
}

std::string ring_name(const std::string& container, const std::string& node) {
  std::string name = container + node;
  const auto checksum = std::hash<std::string>{}(name);
  name.erase(0, std::min(name.find_first_not_of('/'), name.size()));
  for (char& c : name) {
    const bool is_plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
    if (!is_plain) c = c == '/' ? '.' : '_';
  }
  if (name.size() > kLongestName) name = fmt::format("{}.{:016x}", name.substr(0, kLongestName - 17), checksum);
  return name;
}

RingFile::RingFile(std::shared_ptr<RingFolder> folder, std::string path, std::uint64_t bytes)
    : folder_(std::move(folder)), path_(std::move(path)), bytes_(bytes) {}
RingFile::~RingFile() { ::unlink(path_.c_str()); }

Result<std::shared_ptr<RingFolder>, Problem> RingFolder::make(const std::string& base, const std::string& name) {
  // Under another name until it is locked, so that no process takes it for what a killed one left.
  std::string made = base + "/." + kPrefix + "XXXXXX";
  if (::mkdtemp(made.data()) == nullptr) return err(problem_of(base, errno, "cannot hold a ring"));
  const std::string path = fmt::format("{}/{}{}.{}", base, kPrefix, name, made.substr(made.size() - kRandomLetters));
  io::Descriptor folder = open_folder(made);
  if (!folder.is_open() || !lock(folder) || ::rename(made.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::rmdir(made.c_str());
    return err(problem_of(base, error, "cannot hold a ring"));
  }
  return std::make_shared<RingFolder>(std::move(folder), path);
}

std::vector<std::shared_ptr<RingFolder>> RingFolder::left_behind(const std::string& base, const std::string& name) {
  const std::string prefix = kPrefix + name + ".";
  std::vector<std::shared_ptr<RingFolder>> found;
  std::error_code error;
  std::filesystem::directory_iterator entry{base, error};
  for (; !error && entry != std::filesystem::directory_iterator{}; entry.increment(error)) {
    const std::string file = entry->path().filename().string();
    if (!file.starts_with(prefix) || file.size() != prefix.size() + kRandomLetters) continue;
    const std::string path = entry->path().string();
    io::Descriptor folder = open_folder(path);
    struct stat status {};
    if (!folder.is_open() || ::fstat(folder.number(), &status) != 0 || !is_private(status, ::geteuid())) continue;
    if (!lock(folder) || !is_still_at(path, status)) continue;
    found.push_back(std::make_shared<RingFolder>(std::move(folder), path));
  }
  return found;
}

RingFolder::~RingFolder() { ::rmdir(path_.c_str()); }  // fails if a file is in it

Result<std::shared_ptr<RingFile>, Problem> RingFolder::add(const std::string& name, ByteView bytes) {
  const io::Descriptor file{
      ::openat(folder_.number(), name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600)};
  const std::string path = path_ + "/" + name;
  if (!file.is_open()) return err(problem_of(path, errno, "cannot be made"));
  if (!write_all(file.number(), bytes)) {
    const int error = errno;
    ::unlinkat(folder_.number(), name.c_str(), 0);
    return err(problem_of(path, error, "cannot be written"));
  }
  return std::make_shared<RingFile>(shared_from_this(), path, bytes.size());
}

std::vector<std::string> RingFolder::files() const {
  std::vector<std::string> all;
  std::error_code error;
  std::filesystem::directory_iterator entry{path_, error};
  for (; !error && entry != std::filesystem::directory_iterator{}; entry.increment(error)) {
    std::error_code unknown;
    if (std::filesystem::is_regular_file(entry->symlink_status(unknown))) all.push_back(entry->path().string());
  }
  return all;
}

std::uint64_t RingFolder::bytes() const {
  std::uint64_t sum = 0;
  for (const std::string& file : files()) {
    struct stat status {};
    if (::lstat(file.c_str(), &status) == 0) sum += static_cast<std::uint64_t>(status.st_size);
  }
  return sum;
}

void RingFolder::clear() {
  for (const std::string& file : files()) ::unlink(file.c_str());
}

std::uint64_t RingFolder::free_bytes() const {
  struct statvfs status {};
  if (::fstatvfs(folder_.number(), &status) != 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(status.f_bavail) * status.f_frsize;
}

}  // namespace nacelle::record
