// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "doctor/checks.hpp"

namespace nacelle::doctor {

/// A machine of files in a folder of the test's own, as a person finds one: nothing wrong with it.
struct MachineOfFiles : ::testing::Test {
  MachineOfFiles() {
    std::string name = (std::filesystem::temp_directory_path() / "nacelle-doctor-XXXXXX").string();
    root = ::mkdtemp(name.data());
    write("/proc/self/status",
          "Name:\tnacelle\nUid:\t4711\t4711\t4711\t4711\nGid:\t4711\t4711\t4711\t4711\n"
          "Groups:\t27 4711\nCapEff:\t0000000000000000\n");
    write("/proc/self/limits",
          "Limit                     Soft Limit           Hard Limit           Units     \n"
          "Max locked memory         8388608              8388608              bytes     \n"
          "Max realtime priority     95                   95                             \n");
    write("/proc/self/cgroup", "0::/user.slice\n");
    write("/proc/self/mounts", "tmpfs /dev/shm tmpfs rw,nosuid,nodev,size=1048576k 0 0\n");
    write("/proc/meminfo",
          "MemTotal:        4000000 kB\nMemAvailable:    3000000 kB\nSwapTotal:             0 kB\nSwapFree:            "
          "  0 kB\n");
    write("/proc/sys/net/core/rmem_max", "8388608\n");
    write("/proc/sys/net/ipv4/ipfrag_high_thresh", "4194304\n");
    write("/proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("/proc/sys/kernel/osrelease", "6.1.0\n");
    write("/proc/net/udp", kUdpHeading);
    write("/etc/group", "dialout:x:" + std::to_string(::getgid()) + ":\nroot:x:0:\nsudo:x:27:pi\n");
    write("/etc/os-release", "NAME=\"Debian\"\nPRETTY_NAME=\"Debian GNU/Linux 12 (bookworm)\"\n");
    write("/sys/class/rtc/rtc0/name", "rtc");
    facts.now = WallTime{std::chrono::hours{24 * 365 * 56}};
    facts.built = WallTime{std::chrono::hours{24 * 365 * 55}};
    facts.clock_is_synchronised = true;
    facts.version = "1.2.3";
  }
  ~MachineOfFiles() override { std::filesystem::remove_all(root); }

  std::filesystem::path at(const std::string& path) const { return root / std::filesystem::path{path}.relative_path(); }
  void write(const std::string& path, const std::string& text, mode_t mode = 0644) const {
    std::filesystem::create_directories(at(path).parent_path());
    std::ofstream{at(path), std::ios::trunc} << text;
    ASSERT_EQ(::chmod(at(path).c_str(), mode), 0);
  }
  /// A device is a file here: whose it is is the test's own user, a stranger to the machine's.
  void plug_in(const std::string& path, mode_t mode = 0660) const { write(path, "", mode); }
  void run(int pid, const std::string& name, const std::string& holds = {}) const {
    const std::string folder = "/proc/" + std::to_string(pid);
    write(folder + "/comm", name + "\n");
    std::filesystem::create_directories(at(folder + "/fd"));
    if (!holds.empty()) std::filesystem::create_symlink(holds, at(folder + "/fd/3"));
  }
  void join_group(gid_t group) const {
    write("/proc/self/status", "Uid:\t4711\t4711\t4711\t4711\nGid:\t4711\t4711\t4711\t4711\nGroups:\t27 " +
                                   std::to_string(group) + "\nCapEff:\t0\n");
  }
  Machine machine() const { return Machine{facts, root}; }
  /// The finding about something, of one check.
  template <typename Check>
  Finding find(Check check, const std::string& where) const {
    Findings findings;
    check(machine(), wanted, findings);
    const auto found = std::find_if(findings.begin(), findings.end(),
                                    [&](const Finding& f) { return f.problem.where.text().rfind(where, 0) == 0; });
    if (found != findings.end()) return *found;
    ADD_FAILURE() << "there is no finding at " << where;
    return {};
  }

  static constexpr const char* kUdpHeading =
      "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer "
      "drops\n";
  std::filesystem::path root;
  Facts facts;
  Wanted wanted;
};

}  // namespace nacelle::doctor
