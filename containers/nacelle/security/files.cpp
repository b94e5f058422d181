// SPDX-License-Identifier: Apache-2.0
#include "security/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "nacelle/base/files.hpp"
#include "security/security_fault.hpp"

namespace nacelle::security {
namespace {

namespace fs = std::filesystem;

Problem problem_at(const fs::path& path, const std::string& what, int error) {
  return {Place(path.string(), 0), what + ": " + std::strerror(error), "", file_fault_of(error, FileFault::Unwritable)};
}

bool write_all(int file, const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t wrote = ::write(file, text.data() + done, text.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return false;
    done += static_cast<std::size_t>(wrote);
  }
  return ::fsync(file) == 0;
}

}  // namespace

Result<std::string, Problem> read_file(const fs::path& path) {
  auto text = read_regular_file(path.string(), kMostFileBytes);
  if (!text) return err(moved(text.error(), Place(path.string(), 0), ""));
  return text;
}

Result<void, Problem> write_file(const fs::path& path, const std::string& text, Secrecy secrecy) {
  const std::string beside = path.string() + ".new";
  ::unlink(beside.c_str());  // left by a process that was killed
  const ::mode_t mode = secrecy == Secrecy::Private ? 0600 : 0644;
  const int file = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
  if (file < 0) return err(problem_at(path, "cannot be written", errno));
  const bool complete = write_all(file, text);
  const int error = errno;
  ::close(file);
  if (complete && ::rename(beside.c_str(), path.c_str()) == 0) return {};
  const Problem problem = problem_at(path, "cannot be written", complete ? errno : error);
  ::unlink(beside.c_str());
  return err(problem);
}

Result<void, Problem> make_folder(const fs::path& path, Secrecy secrecy) {
  std::error_code failed;
  if (fs::is_directory(path, failed)) return {};
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), failed);
  if (failed) return err(problem_at(path, "cannot be made", failed.value()));
  if (::mkdir(path.c_str(), secrecy == Secrecy::Private ? 0700 : 0755) == 0) return {};
  return err(problem_at(path, "cannot be made", errno));
}

Result<void, Problem> make_link(const fs::path& link, const fs::path& target) {
  std::error_code failed;
  fs::create_symlink(target, link, failed);
  return failed ? Result<void, Problem>{err(problem_at(link, "cannot be made", failed.value()))}
                : Result<void, Problem>{};
}

}  // namespace nacelle::security
