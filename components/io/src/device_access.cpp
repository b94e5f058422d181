// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/device_access.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <grp.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>

#include "nacelle/base/files.hpp"

namespace nacelle::io {
namespace {

namespace fs = std::filesystem;

fs::path real(const fs::path& root, const fs::path& path) { return root / path.relative_path(); }

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (fs::directory_iterator at{folder, ignored}, end; !ignored && at != end; at.increment(ignored))
    names.push_back(at->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<int> pid_of(const std::string& name) {
  int pid = 0;
  const char* const end = name.data() + name.size();
  const auto read = std::from_chars(name.data(), end, pid);
  return read.ec == std::errc{} && read.ptr == end ? std::optional{pid} : std::nullopt;
}

std::string group_name(gid_t number) {
  std::array<char, 1024> text{};
  group entry{};
  group* found = nullptr;
  const bool known = ::getgrgid_r(number, &entry, text.data(), text.size(), &found) == 0 && found != nullptr;
  return known ? entry.gr_name : std::to_string(number);
}

// Serial lines of a PC's board (ttyS) are there with or without a chip, and mean nothing.
bool is_serial_device(const std::string& name) {
  constexpr std::array kBeginnings{"ttyUSB", "ttyACM", "ttyAMA"};
  return std::any_of(kBeginnings.begin(), kBeginnings.end(),
                     [&](const char* beginning) { return name.rfind(beginning, 0) == 0; });
}

Problem not_permitted(const std::string& path, const fs::path& root) {
  Problem problem{path, "no permission to open it", "see `ls -l " + path + "`"};
  struct stat status {};
  if (::stat(real(root, path).c_str(), &status) != 0) return problem;
  const std::string group = group_name(status.st_gid);
  if ((status.st_mode & 060U) == 060U) {
    problem.what += fmt::format(": members of group {} may", group);
    problem.way_out = fmt::format("`sudo usermod -aG {} $USER`, then log in again", group);
  } else {
    problem.way_out = fmt::format("`sudo chmod g+rw {}`, or a udev rule with MODE=\"0660\"", path);
  }
  return problem;
}

Problem in_use(const std::string& path, const fs::path& root) {
  std::error_code failed;
  const fs::path target = root == "/" ? fs::canonical(path, failed) : fs::path{path};
  const auto holders = holders_of(failed ? path : target.string(), root);
  if (holders.empty()) return {path, "in use by another program", fmt::format("`sudo fuser -v {}` names it", path)};
  std::string way_out = fmt::format("end it: kill {}", holders.front().pid);
  if (holders.front().name == "ModemManager")
    way_out = "it probes serial lines: sudo systemctl disable --now ModemManager";
  return {path, "in use by " + names_of(holders), way_out};
}

Problem not_there(const std::string& path, const fs::path& root) {
  Problem problem{path, "no such device", "is it plugged in and powered? `nacelle device list` shows what is"};
  const auto there = serial_devices(root);
  // A camera is not meant by a serial line's path.
  if (path.find("video") == std::string::npos && !there.empty())
    problem.way_out = fmt::format("is it plugged in and powered? There are {}", fmt::join(there, ", "));
  return problem;
}

}  // namespace

std::vector<Process> holders_of(const std::string& target, const fs::path& root) {
  std::vector<Process> found;
  const fs::path processes = root / "proc";
  for (const auto& entry : names_in(processes)) {
    const auto pid = pid_of(entry);
    if (!pid) continue;
    const fs::path folder = processes / entry, descriptors = folder / "fd";
    for (const auto& descriptor : names_in(descriptors)) {
      std::error_code failed;
      if (fs::read_symlink(descriptors / descriptor, failed) != target || failed) continue;
      auto comm = read_regular_file((folder / "comm").string());
      std::string name = comm ? std::move(comm).value() : "?";
      name.erase(name.find_last_not_of('\n') + 1);
      if (name != "nacelle_watcher") found.push_back({*pid, std::move(name)});
      break;
    }
  }
  std::sort(found.begin(), found.end(), [](const Process& a, const Process& b) { return a.pid < b.pid; });
  return found;
}

std::string names_of(const std::vector<Process>& processes) {
  std::vector<std::string> names;
  for (const auto& process : processes) names.push_back(fmt::format("{} (pid {})", process.name, process.pid));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<std::string> serial_devices(const fs::path& root) {
  std::vector<std::string> paths, named;
  for (const auto& name : names_in(root / "dev/serial/by-id")) {
    paths.push_back("/dev/serial/by-id/" + name);
    std::error_code failed;
    named.push_back(fs::read_symlink(root / "dev/serial/by-id" / name, failed).filename().string());
  }
  for (const auto& name : names_in(root / "dev")) {
    if (is_serial_device(name) && std::find(named.begin(), named.end(), name) == named.end())
      paths.push_back("/dev/" + name);
  }
  return paths;
}

Problem why_not_opened(const std::string& path, int os_code, const fs::path& root) {
  switch (os_code) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
    case ENOTDIR: return not_there(path, root);
    case EACCES:
    case EPERM: return not_permitted(path, root);
    case EBUSY: return in_use(path, root);
    default: return {path, fmt::format("cannot be opened ({})", std::strerror(os_code)), "see `ls -l " + path + "`"};
  }
}

}  // namespace nacelle::io
