// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/pty_pair.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>

namespace nacelle::io {
namespace {

std::string target_of(const std::string& link) {
  std::array<char, PATH_MAX> target{};
  const ssize_t length = ::readlink(link.c_str(), target.data(), target.size());
  return length < 0 ? std::string{} : std::string{target.data(), static_cast<std::size_t>(length)};
}

Problem no_pty(const char* step) {
  return {"pseudo-terminal", fmt::format("{} failed ({})", step, std::strerror(errno)), "is /dev/pts mounted?"};
}

}  // namespace

PtyPair::PtyPair(Descriptor device_end, Descriptor program_end, std::string path)
    : device_end_(std::move(device_end)), program_end_(std::move(program_end)), path_(std::move(path)) {}

Result<std::unique_ptr<PtyPair>, Problem> PtyPair::create() {
  Descriptor device_end{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (!device_end.is_open()) return err(no_pty("posix_openpt"));
  std::array<char, 64> name{};
  if (::grantpt(device_end.number()) != 0 || ::unlockpt(device_end.number()) != 0 ||
      ::ptsname_r(device_end.number(), name.data(), name.size()) != 0) {
    return err(no_pty("unlocking it"));
  }
  Descriptor program_end{::open(name.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  termios options{};
  if (!program_end.is_open() || ::tcgetattr(program_end.number(), &options) != 0)
    return err(no_pty("opening its line"));
  ::cfmakeraw(&options);
  options.c_cflag |= CLOCAL | CREAD;
  if (::tcsetattr(program_end.number(), TCSANOW, &options) != 0) return err(no_pty("making it raw"));
  return std::unique_ptr<PtyPair>{new PtyPair{std::move(device_end), std::move(program_end), name.data()}};
}

PtyPair::~PtyPair() {
  if (!link_.empty() && target_of(link_) == path_) ::unlink(link_.c_str());
}

Result<void, Problem> PtyPair::link_as(const std::string& link) {
  struct stat status {};
  if (::lstat(link.c_str(), &status) == 0 && !S_ISLNK(status.st_mode)) {
    return err(Problem{link, "is there and is not a link", "choose another directory for the simulated devices"});
  }
  // The new link is renamed over the old one, so that the link is never missing.
  const std::string fresh = link + ".new";
  ::unlink(fresh.c_str());
  if (::symlink(path_.c_str(), fresh.c_str()) != 0 || ::rename(fresh.c_str(), link.c_str()) != 0) {
    const int code = errno;
    ::unlink(fresh.c_str());
    return err(Problem{link, fmt::format("cannot be made ({})", std::strerror(code)), "is the directory writable?"});
  }
  link_ = link;
  return {};
}

Result<ByteView, StreamFault> PtyPair::read() {
  const ssize_t count = ::read(device_end_.number(), buffer_.data(), buffer_.size());
  if (count >= 0) return ByteView{buffer_.data(), static_cast<std::size_t>(count)};
  if (errno == EAGAIN || errno == EINTR) return ByteView{};
  return err(errno == EIO ? StreamFault::HungUp : StreamFault::ReadFailed);
}

std::size_t PtyPair::unread() const {
  int waiting = 0;
  return ::ioctl(program_end_.number(), FIONREAD, &waiting) == 0 && waiting > 0 ? static_cast<std::size_t>(waiting) : 0;
}

std::size_t PtyPair::write_some(ByteView bytes) {
  if (unread() + bytes.size() > kFullBytes) return 0;
  const ssize_t count = ::write(device_end_.number(), bytes.data(), bytes.size());
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

void PtyPair::hang_up() {
  device_end_ = Descriptor{};
  program_end_ = Descriptor{};
}

}  // namespace nacelle::io
