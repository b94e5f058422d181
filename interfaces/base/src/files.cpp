// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>

namespace nacelle {
namespace {

/// Closes at the end of its block; the errors of a file that was written are asked for with finish().
class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] bool finish() {
    const int descriptor = descriptor_;
    descriptor_ = -1;
    return ::close(descriptor) == 0;
  }

 private:
  int descriptor_;
};

const char* kind_of_file(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a FIFO";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

Problem unreadable(const std::string& path, int error) {
  return {Place(path, 0), std::string{"cannot be read: "} + std::strerror(error),
          error == ENOENT ? "is the path right?" : "is it there, and may this user read it?",
          file_fault_of(error, FileFault::Unreadable)};
}

Problem too_large(const std::string& path, std::size_t most_bytes) {
  constexpr std::size_t kMiB = std::size_t{1} << 20U;
  const std::string limit =
      most_bytes % kMiB == 0 ? std::to_string(most_bytes / kMiB) + " MiB" : std::to_string(most_bytes) + " bytes";
  return {Place(path, 0), "has more than " + limit + ", the limit for such a file", "give the file that was meant",
          FileFault::TooLarge};
}

Problem unwritable(const std::string& path, int error) {
  std::string way_out = "give another place";
  if (error == ENOENT || error == ENOTDIR) way_out = "is the folder there?";
  if (error == EACCES || error == EPERM || error == EROFS) way_out = "may this user write there?";
  if (error == ENOSPC || error == EDQUOT) way_out = "make room, or give another place";
  if (error == EFBIG) way_out = "raise the limit of file sizes (ulimit -f), or give another place";
  return {Place(path, 0), std::string{"cannot be written: "} + std::strerror(error), way_out,
          file_fault_of(error, FileFault::Unwritable)};
}

/// 0, or the error.
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return EIO;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

Result<void, Problem> write_directly(const std::string& path, std::string_view text) {
  OpenFile file{::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY)};
  if (file.get() < 0) return err(unwritable(path, errno));
  if (const int error = write_all(file.get(), text); error != 0) return err(unwritable(path, error));
  if (!file.finish()) return err(unwritable(path, errno));
  return {};
}

/// Writes to `beside` and gives it the name `real`. Returns 0, or the error.
int write_and_rename(const std::string& beside, const std::string& real, std::string_view text,
                     std::optional<mode_t> mode) {
  ::unlink(beside.c_str());  // left by a process of this number that was killed
  OpenFile file{::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666)};
  if (file.get() < 0) return errno;
  int error = mode && ::fchmod(file.get(), *mode) != 0 ? errno : write_all(file.get(), text);
  // On a disk, a name must not come before its content; some disks are full only here.
  if (error == 0 && (::fsync(file.get()) != 0 || !file.finish())) error = errno;
  if (error == 0 && ::rename(beside.c_str(), real.c_str()) != 0) error = errno;
  if (error != 0) ::unlink(beside.c_str());
  return error;
}

}  // namespace

Result<std::string, Problem> read_regular_file(const std::string& path, std::size_t most_bytes) {
  // Without O_NONBLOCK a FIFO without a writer would be waited for right here.
  const OpenFile file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)};
  if (file.get() < 0) return err(unreadable(path, errno));
  struct stat found {};
  if (::fstat(file.get(), &found) != 0) return err(unreadable(path, errno));
  if (!S_ISREG(found.st_mode))
    return err(Problem{Place(path, 0), std::string{"cannot be read: it is "} + kind_of_file(found.st_mode),
                       "give a regular file", FileFault::NotRegular});
  if (static_cast<std::size_t>(found.st_size) > most_bytes) return err(too_large(path, most_bytes));
  std::string text;
  std::size_t done = 0;
  // One byte more than it says it has, and than it may have: files of /proc say 0, others may grow meanwhile.
  text.resize(static_cast<std::size_t>(found.st_size) + 1);
  while (true) {
    const ssize_t got = ::read(file.get(), text.data() + done, text.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return err(unreadable(path, errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
    if (done > most_bytes) return err(too_large(path, most_bytes));
    if (done == text.size()) text.resize(std::min(2 * text.size() + 4096, most_bytes + 1));
  }
  text.resize(done);
  return text;
}

Result<void, Problem> write_whole_file(const std::string& path, std::string_view text) {
  struct stat found {};
  const bool is_there = ::stat(path.c_str(), &found) == 0;
  if (is_there && S_ISDIR(found.st_mode)) return err(unwritable(path, EISDIR));
  if (is_there && !S_ISREG(found.st_mode)) return write_directly(path, text);
  std::string real = path;
  if (is_there) {
    // A file that this user may not write to is not replaced either, whatever the owner of the folder.
    if (::access(path.c_str(), W_OK) != 0) return err(unwritable(path, errno));
    const std::unique_ptr<char, decltype(&std::free)> resolved{::realpath(path.c_str(), nullptr), &std::free};
    if (resolved == nullptr) return err(unwritable(path, errno));
    real = resolved.get();
  }
  const std::string beside = real + "." + std::to_string(::getpid()) + ".new";
  const auto mode = is_there ? std::optional<mode_t>{found.st_mode & 07777} : std::nullopt;
  const int error = write_and_rename(beside, real, text, mode);
  if (error != 0) return err(unwritable(path, error));
  return {};
}

}  // namespace nacelle
