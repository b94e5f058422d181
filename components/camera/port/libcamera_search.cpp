// SPDX-License-Identifier: Apache-2.0
#include "camera/port/libcamera_search.hpp"

#include <fmt/format.h>
#include <libcamera/logging.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "camera/port/camera_fault.hpp"
#include "nacelle/base/guarded.hpp"

namespace nacelle::camera {
namespace {

using Manager = ::libcamera::CameraManager;

/// The process's one manager and how many use it. It ends under the lock, so that no second one is made meanwhile.
struct SharedManager {
  std::unique_ptr<Manager> manager;
  int users = 0;
};
Guarded<SharedManager>& the_manager() {
  static Guarded<SharedManager> shared;
  return shared;
}

Result<std::shared_ptr<Manager>, Problem> shared_manager() {
  auto shared = the_manager().lock();
  if (shared->users == 0) {
    // It writes a few lines to stderr at every search; what matters comes back as a Problem. The user's own wish holds.
    if (std::getenv("LIBCAMERA_LOG_LEVELS") == nullptr && std::getenv("LIBCAMERA_LOG_FILE") == nullptr)
      ::libcamera::logSetTarget(::libcamera::LoggingTargetNone);
    shared->manager = std::make_unique<Manager>();
    if (const int answer = shared->manager->start(); answer != 0) {
      shared->manager.reset();
      return err(describe_libcamera_trouble("libcamera", "start", answer));
    }
  }
  ++shared->users;
  return std::shared_ptr<Manager>(shared->manager.get(), [](Manager* manager) {
    auto last = the_manager().lock();
    if (--last->users != 0) return;
    manager->stop();
    last->manager.reset();
  });
}

/// A device of a camera's pipeline that this user may not open; empty if there is none.
std::string forbidden_device() {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator{"/dev", ignored}) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("media", 0) == 0 && ::access(entry.path().c_str(), R_OK | W_OK) != 0) return entry.path().string();
  }
  return {};
}

Problem not_there(const std::string& name, const std::string& wanted, const std::vector<std::string>& ids) {
  if (!ids.empty()) {
    return {name, "libcamera has no such camera, only " + join(ids), suggestion(wanted, ids), CameraFault::NotThere};
  }
  if (const std::string forbidden = forbidden_device(); !forbidden.empty()) {
    return {name, "libcamera sees no camera, and " + forbidden + " may not be opened",
            "add the user to the group video: `sudo adduser $USER video`, then log in again",
            CameraFault::NotPermitted};
  }
  return {
      name, "libcamera sees no camera",
      "on a Raspberry Pi: camera_auto_detect=1 in /boot/firmware/config.txt (or dtoverlay=SENSOR), both ends of the "
      "ribbon cable, then a restart; `cam -l` lists cameras",
      CameraFault::NotThere};
}

}  // namespace

Problem describe_libcamera_trouble(const std::string& name, const char* step, int os_code) {
  const int code = os_code < 0 ? -os_code : os_code;
  CameraFault fault = CameraFault::Failed;
  std::string way_out = "see `dmesg`, and LIBCAMERA_LOG_LEVELS=*:DEBUG `cam -l`";
  switch (code) {
    case EBUSY:
      fault = CameraFault::Busy;
      way_out = "another program or another node uses this camera; `fuser -v /dev/media*` names programs";
      break;
    case ENODEV:
    case ENXIO:
      fault = CameraFault::Unplugged;
      way_out = "look at both ends of the ribbon cable";
      break;
    case EACCES:
    case EPERM:
      fault = CameraFault::NotPermitted;
      way_out = "add the user to the group video: `sudo adduser $USER video`, then log in again";
      break;
    case ENOMEM:
    case ENOSPC:
      fault = CameraFault::NoMemory;
      way_out = "no memory for its buffers; choose a smaller image_size";
      break;
    default: break;
  }
  return {name, fmt::format("{} failed: {} (errno {})", step, std::generic_category().message(code), code),
          std::move(way_out), fault};
}

Result<FoundCamera, Problem> find_camera(const std::string& name) {
  auto manager = shared_manager();
  if (!manager) return err(manager.error());
  const auto cameras = (*manager)->cameras();
  const auto colon = name.find(':');
  const std::string wanted = colon == std::string::npos ? "0" : name.substr(colon + 1);
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  const bool is_number = error == std::errc{} && end == wanted.data() + wanted.size();
  if (is_number && number < cameras.size()) return FoundCamera{*manager, cameras[number]};
  const auto found = std::find_if(cameras.begin(), cameras.end(), [&](const auto& one) { return one->id() == wanted; });
  if (found != cameras.end()) return FoundCamera{*manager, *found};
  std::vector<std::string> ids;
  for (const auto& one : cameras) ids.push_back(one->id());
  return err(not_there(name, wanted, ids));
}

}  // namespace nacelle::camera
