// SPDX-License-Identifier: Apache-2.0
#include "doctor/machine.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/timex.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "transport_dds/wire/ros_environment.hpp"

namespace nacelle::doctor {

namespace fs = std::filesystem;

Facts real_facts(std::string version) {
  Facts facts;
  facts.now = SystemClock{}.wall_now();
  facts.version = std::move(version);
  timex state{};  // modes 0: only asks
  if (const int answer = ::adjtimex(&state); answer >= 0)
    facts.clock_is_synchronised = answer != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
  struct stat program {};
  if (::stat("/proc/self/exe", &program) == 0) facts.built = WallTime{std::chrono::seconds{program.st_mtim.tv_sec}};
  if (const char* const domain = std::getenv("ROS_DOMAIN_ID"); domain != nullptr) {
    if (const auto asked = transport_dds::read_environment({{"ROS_DOMAIN_ID", domain}})) {
      facts.domain = asked.value().domain.value_or(0);
    } else {
      facts.wrong_domain = asked.error();
    }
  }
  return facts;
}

fs::path Machine::real(const std::string& path) const { return root_ / fs::path{path}.relative_path(); }

bool Machine::exists(const std::string& path) const {
  std::error_code ignored;
  return fs::exists(real(resolved(path)), ignored);
}

std::optional<std::string> Machine::text(const std::string& path) const {
  constexpr std::streamsize kMost = 1 << 20;
  std::ifstream file{real(path)};
  if (!file) return std::nullopt;
  std::string text(static_cast<std::size_t>(kMost), '\0');
  file.read(text.data(), kMost);
  if (file.bad()) return std::nullopt;
  text.resize(static_cast<std::size_t>(file.gcount()));
  text.erase(text.find_last_not_of(" \t\r\n") + 1);
  return text;
}

std::optional<std::int64_t> Machine::number(const std::string& path) const {
  const auto all = text(path);
  return all ? leading_number(*all) : std::nullopt;
}

std::optional<std::string> Machine::field(const std::string& path, std::string_view key) const {
  std::istringstream lines{text(path).value_or("")};
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(key, 0) != 0 || line.size() <= key.size() || line[key.size()] != ':') continue;
    const std::size_t begin = line.find_first_not_of(" \t", key.size() + 1);
    return begin == std::string::npos ? std::string{} : line.substr(begin);
  }
  return std::nullopt;
}

std::vector<std::string> Machine::names_in(const std::string& folder) const {
  std::vector<std::string> names;
  std::error_code ignored;
  for (fs::directory_iterator at{real(folder), ignored}, end; !ignored && at != end; at.increment(ignored))
    names.push_back(at->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<std::string> Machine::link(const std::string& path) const {
  std::error_code failed;
  const fs::path target = fs::read_symlink(real(path), failed);
  if (failed) return std::nullopt;
  return target.string();
}

std::string Machine::resolved(std::string path) const {
  for (int i = 0; i < 16; ++i) {
    const auto target = link(path);
    if (!target) break;
    path = (fs::path{path}.parent_path() / *target).lexically_normal().string();
  }
  return path;
}

std::optional<Access> Machine::access(const std::string& path) const {
  struct stat status {};
  if (::stat(real(resolved(path)).c_str(), &status) != 0) return std::nullopt;
  return Access{status.st_uid, status.st_gid, status.st_mode};
}

bool Machine::is_root() const {
  const auto ids = words_of(field("/proc/self/status", "Uid").value_or(""));
  return ids.size() > 1 && ids[1] == "0";  // real, effective, saved, of the file system
}

bool Machine::may_use(const Access& access) const {
  if (is_root()) return true;
  const auto uids = words_of(field("/proc/self/status", "Uid").value_or(""));
  const auto gids = words_of(field("/proc/self/status", "Gid").value_or(""));
  auto groups = words_of(field("/proc/self/status", "Groups").value_or(""));
  if (gids.size() > 1) groups.push_back(gids[1]);
  const auto both = [&](unsigned shift) { return ((access.mode >> shift) & 6U) == 6U; };
  // The first class that fits decides, as in the kernel.
  if (uids.size() > 1 && uids[1] == std::to_string(access.owner)) return both(6);
  if (std::find(groups.begin(), groups.end(), std::to_string(access.group)) != groups.end()) return both(3);
  return both(0);
}

std::string Machine::group_name(gid_t group) const {
  std::istringstream lines{text("/etc/group").value_or("")};
  std::string number = std::to_string(group);
  for (std::string line; std::getline(lines, line);) {  // name:password:number:members
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    if (line.substr(second + 1, line.find(':', second + 1) - second - 1) == number) return line.substr(0, first);
  }
  return number;
}

std::vector<Process> Machine::holders(const std::string& target) const { return io::holders_of(target, root_); }

std::optional<std::int64_t> leading_number(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  std::int64_t value = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc{}) return std::nullopt;
  return value;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in{text};
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

}  // namespace nacelle::doctor
