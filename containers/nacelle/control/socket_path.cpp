// SPDX-License-Identifier: Apache-2.0
#include "control/socket_path.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "control/trust.hpp"
#include "nacelle/base/name_fault.hpp"

namespace nacelle::control {
namespace {

constexpr const char* kSuffix = ".sock";
constexpr int kBacklog = 64;

std::optional<sockaddr_un> address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) return std::nullopt;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  return address;
}

bool answers(const std::string& path) {
  const auto address = address_of(path);
  if (!address) return false;
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return false;
  // EAGAIN means a full backlog: a container is listening.
  const bool alive =
      ::connect(fd, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0 || errno == EAGAIN;
  ::close(fd);
  return alive;
}

// The watcher of a container that was killed holds its descriptors until it has written the last stop frames.
constexpr int kLockTries = 20, kLockPause_ms = 10;

bool lock_soon(int fd) {
  for (int i = 0; i < kLockTries; ++i) {
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return true;
    static_cast<void>(::poll(nullptr, 0, kLockPause_ms));
  }
  return false;
}

struct Candidate {
  std::string folder;
  FolderKind kind;
};

std::vector<Candidate> candidates(const SocketPlaces& places) {
  std::vector<Candidate> folders;
  if (!places.xdg_runtime_dir.empty()) folders.push_back({places.xdg_runtime_dir + "/nacelle", FolderKind::Private});
  if (!places.system_dir.empty()) folders.push_back({places.system_dir, FolderKind::System});
  if (!places.fallback_dir.empty()) folders.push_back({places.fallback_dir, FolderKind::Private});
  return folders;
}

/// Makes the folder if it is a user's own, or returns why no socket can be put there.
std::optional<std::string> refusal_of(const Candidate& candidate) {
  // The system's folder is the administrator's or systemd's to make: where it is absent, /run may be a disk.
  if (candidate.kind == FolderKind::Private && ::mkdir(candidate.folder.c_str(), 0700) != 0 && errno != EEXIST)
    return std::strerror(errno);
  if (auto distrust = distrust_of_folder(candidate.folder, candidate.kind)) return distrust;
  if (::access(candidate.folder.c_str(), W_OK | X_OK) != 0) return std::strerror(errno);
  return std::nullopt;
}

/// The folder of a new socket, with its kind.
Result<Candidate, Problem> place_for_socket(const SocketPlaces& places) {
  std::string tried;
  for (const auto& candidate : candidates(places)) {
    const auto refusal = refusal_of(candidate);
    if (!refusal) return candidate;
    tried += fmt::format("{}{}: {}", tried.empty() ? "" : ", ", candidate.folder, *refusal);
  }
  return err(
      Problem{"control socket", "no folder to put it in (" + tried + ")", "set XDG_RUNTIME_DIR to a folder of yours"});
}

}  // namespace

SocketPlaces socket_places_from_environment() {
  SocketPlaces places;
  if (const char* const runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && runtime[0] == '/') {
    places.xdg_runtime_dir = runtime;
  }
  places.fallback_dir = fmt::format("/dev/shm/nacelle-{}", ::geteuid());
  return places;
}

Result<void, Problem> validate_container_name(const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  };
  if (name.empty() || name.size() > 48 || name.front() == '.' || !std::all_of(name.begin(), name.end(), allowed)) {
    return err(Problem{"container name '" + name + "'", "not a name",
                       "use 1 to 48 letters, digits, '_', '-' and '.', not beginning with '.'"});
  }
  return {};
}

Result<std::string, Problem> folder_for_socket(const SocketPlaces& places) {
  auto place = place_for_socket(places);
  if (!place) return err(place.error());
  return place.value().folder;
}

Result<std::string, Problem> socket_path_of(const SocketPlaces& places, const std::string& name) {
  auto folder = folder_for_socket(places);
  if (!folder) return err(folder.error());
  return folder.value() + "/" + name + kSuffix;
}

std::vector<FoundContainer> running_containers(const SocketPlaces& places, std::vector<Problem>* ignored) {
  std::vector<FoundContainer> found;
  for (const auto& [folder, kind] : candidates(places)) {
    const auto ignore = [&, &place = folder](std::string what) {
      if (ignored != nullptr)
        ignored->push_back({place, "ignored: " + std::move(what), "another user may have created it; remove it"});
    };
    // One that is not there, or that is not for this user, holds nothing of interest.
    if (::access(folder.c_str(), F_OK) != 0) continue;
    if (kind == FolderKind::System && ::access(folder.c_str(), R_OK | X_OK) != 0) continue;
    if (const auto distrust = distrust_of_folder(folder, kind)) {
      ignore(*distrust);
      continue;
    }
    std::size_t odd = 0;
    std::string first_odd;
    std::error_code unreadable;
    for (const auto& entry : std::filesystem::directory_iterator(folder, unreadable)) {
      if (entry.path().extension() != kSuffix) continue;
      FoundContainer container{entry.path().stem().string(), entry.path().string()};
      std::optional<std::string> distrust = distrust_of_socket(container.path, kind);
      if (!distrust && !validate_container_name(container.name)) distrust = "no name of a container";
      if (distrust) {
        if (odd++ == 0) first_odd = fmt::format("{} ({})", entry.path().filename().string(), *distrust);
        continue;
      }
      const auto same = [&](const FoundContainer& other) { return other.name == container.name; };
      if (std::none_of(found.begin(), found.end(), same) && answers(container.path))
        found.push_back(std::move(container));
    }
    if (odd != 0) ignore(first_odd + (odd > 1 ? fmt::format(" and {} more", odd - 1) : std::string{}));
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return found;
}

Result<FoundContainer, Problem> choose_container(const std::vector<FoundContainer>& running,
                                                 const std::optional<std::string>& wanted) {
  std::vector<std::string> names;
  names.reserve(running.size());
  for (const FoundContainer& container : running) names.push_back(container.name);
  if (wanted) {
    const auto at = std::find(names.begin(), names.end(), *wanted);
    if (at != names.end()) return running[static_cast<std::size_t>(at - names.begin())];
    return err(Problem{
        "container '" + *wanted + "'", "not running",
        names.empty() ? "start it with `nacelle launch FILE --name " + *wanted + "`" : "running: " + join(names),
        NameFault::Unknown, *wanted});
  }
  if (running.empty())
    return err(Problem{"", "no container is running", "start one with `nacelle launch FILE` or `nacelle drive --stay`",
                       NameFault::Unknown});
  if (running.size() > 1)
    return err(Problem{"", "several containers are running: " + join(names),
                       "pick one with --container NAME or NACELLE_CONTAINER", NameFault::Ambiguous});
  return running.front();
}

Result<SocketClaim, Problem> SocketClaim::take(const SocketPlaces& places, const std::string& name) {
  if (auto valid = validate_container_name(name); !valid) return err(valid.error());
  auto place = place_for_socket(places);
  if (!place) return err(place.error());
  const auto& [folder, kind] = place.value();

  SocketClaim claim;
  const std::string path = folder + "/" + name + kSuffix;
  const auto address = address_of(path);
  if (!address) {
    return err(Problem{"control socket " + path, "the path is longer than a socket's may be (107 bytes)",
                       "use a shorter container name or another XDG_RUNTIME_DIR"});
  }
  const std::string lock_path = folder + "/" + name + ".lock";
  // The lock, not the socket's file, shows whether the owner is alive: a file survives kill -9, a lock does not.
  while (claim.lock_ < 0) {
    const int fd = ::open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0) return err(Problem{lock_path, std::strerror(errno), "is the folder yours?"});
    if (!lock_soon(fd)) {
      ::close(fd);
      return err(Problem{"container '" + name + "'", "it is running already (" + path + ")",
                         "stop it first, or give this one another name with --name"});
    }
    struct stat held {
    }, named{};
    // The last owner may have removed the file between our open and our lock; then the lock is on nothing.
    if (::fstat(fd, &held) == 0 && ::stat(lock_path.c_str(), &named) == 0 && held.st_ino == named.st_ino) {
      claim.lock_ = fd;
      claim.lock_path_ = lock_path;
    } else {
      ::close(fd);
    }
  }
  ::unlink(path.c_str());
  claim.listen_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  // The mode of a socket that is not bound yet becomes that of its file: at no time may others connect.
  if (claim.listen_ < 0 || ::fchmod(claim.listen_, 0600) != 0 ||
      ::bind(claim.listen_, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0) {
    return err(Problem{"control socket " + path, std::strerror(errno), "set XDG_RUNTIME_DIR to a folder of yours"});
  }
  struct stat of_folder {};
  if (kind == FolderKind::System && ::stat(folder.c_str(), &of_folder) == 0 && (of_folder.st_mode & 0010U) != 0) {
    // A service has that group already, and its sandbox forbids chown().
    struct stat of_socket {};
    const bool has_group = ::stat(path.c_str(), &of_socket) == 0 && of_socket.st_gid == of_folder.st_gid;
    if ((!has_group && ::chown(path.c_str(), static_cast<uid_t>(-1), of_folder.st_gid) != 0) ||
        ::chmod(path.c_str(), 0660) != 0)
      return err(Problem{"control socket " + path, std::strerror(errno), "start it as root, or in the folder's group"});
    claim.group_ = of_folder.st_gid;
  }
  if (::listen(claim.listen_, kBacklog) != 0)
    return err(Problem{"control socket " + path, std::strerror(errno), "set XDG_RUNTIME_DIR to a folder of yours"});
  claim.path_ = path;
  return claim;
}

SocketClaim::SocketClaim(SocketClaim&& other) noexcept
    : lock_(std::exchange(other.lock_, -1)),
      listen_(std::exchange(other.listen_, -1)),
      path_(std::exchange(other.path_, {})),
      lock_path_(std::exchange(other.lock_path_, {})),
      group_(other.group_) {}

SocketClaim::~SocketClaim() {
  if (listen_ >= 0) ::close(listen_);
  if (!path_.empty()) ::unlink(path_.c_str());
  if (lock_ >= 0) {
    ::unlink(lock_path_.c_str());
    ::close(lock_);
  }
}

}  // namespace nacelle::control
