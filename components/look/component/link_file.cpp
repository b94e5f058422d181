// SPDX-License-Identifier: Apache-2.0
#include "look/component/link_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/file_fault.hpp"

namespace nacelle::look {
namespace {

std::string variable(const char* name) {
  const char* const value = ::secure_getenv(name);
  return value == nullptr ? "" : value;
}

/// The folder of a service: its group may read what is in it.
std::string service_folder() {
  const std::string folders = variable("RUNTIME_DIRECTORY");  // of systemd: several, with ':' between
  return folders.substr(0, folders.find(':'));
}

std::string folder() {
  if (std::string of_service = service_folder(); !of_service.empty()) return of_service;
  const std::string of_user = variable("XDG_RUNTIME_DIR");
  return of_user.empty() ? fmt::format("/tmp/nacelle-{}", ::getuid()) : of_user + "/nacelle";
}

Problem unwritable(const std::string& path, std::string what) {
  return {Place{path, 0}, std::move(what), "set XDG_RUNTIME_DIR to a folder of this user", FileFault::Unwritable};
}

}  // namespace

Result<std::string, Problem> random_token() {
  std::array<std::uint8_t, 16> bytes{};
  if (::getentropy(bytes.data(), bytes.size()) != 0)
    return err(Problem{"random numbers", std::strerror(errno), "the system has none yet: try again later"});
  return to_hex(bytes);
}

std::string LinkFile::path_for(const std::string& node) {
  std::string name = "look" + node + ".json";
  std::replace(name.begin(), name.end(), '/', '.');
  return folder() + "/" + name;
}

Result<LinkFile, Problem> LinkFile::write(const std::string& path, const std::string& text) {
  const std::string in = path.substr(0, path.rfind('/'));
  if (::mkdir(in.c_str(), 0700) != 0 && errno != EEXIST) return err(unwritable(in, std::strerror(errno)));
  struct stat found {};
  if (::lstat(in.c_str(), &found) != 0) return err(unwritable(in, std::strerror(errno)));
  if (!S_ISDIR(found.st_mode) || found.st_uid != ::geteuid() || (found.st_mode & S_IWOTH) != 0)
    return err(unwritable(in, "is not a folder of this user alone"));
  // What is there was this user's own: an earlier server's.
  static_cast<void>(::unlink(path.c_str()));
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return err(unwritable(path, std::strerror(errno)));
  LinkFile made{path};
  const bool is_shared = in == service_folder();
  const bool done = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
                    (!is_shared || ::fchmod(file, 0640) == 0);
  const int fault = errno;
  ::close(file);
  if (!done) return err(unwritable(path, std::strerror(fault)));
  return made;
}

LinkFile::~LinkFile() {
  if (!path_.empty()) static_cast<void>(::unlink(path_.c_str()));
}

}  // namespace nacelle::look
