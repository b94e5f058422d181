// SPDX-License-Identifier: Apache-2.0
// Everything but devices: ports, clock, memory, kernel, power, rights, versions.
#include <gmock/gmock.h>

#include "machine_of_files.hpp"

namespace nacelle::doctor {
namespace {

using testing::HasSubstr;
using AMachine = MachineOfFiles;

TEST_F(AMachine, that_is_well_is_reported_as_fine) {
  const Findings findings = examine(machine(), wanted);
  for (const auto& finding : findings) EXPECT_EQ(finding.severity, Severity::Fine) << finding.text();
  EXPECT_FALSE(is_something_wrong(findings));
  EXPECT_EQ(summary(findings), "0 wrong, 0 advice, " + std::to_string(findings.size()) + " fine");
}

TEST_F(AMachine, without_any_file_is_no_reason_to_fail) {
  std::filesystem::remove_all(root);
  EXPECT_FALSE(is_something_wrong(examine(machine(), wanted)));
}

TEST_F(AMachine, names_the_program_that_holds_the_ports_of_the_domain) {
  write("/proc/net/udp",
        std::string{kUdpHeading} +
            "  112: 00000000:1CE8 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 5001 2 0 0\n"
            "  113: 0100007F:1CF2 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 5002 2 0 0\n"
            "  114: 00000000:1D7E 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 5003 2 0 0\n"
            "  115: 00000000:1DE2 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 5004 2 0 0\n");
  run(500, "talker", "socket:[5001]");
  std::filesystem::create_symlink("socket:[5002]", at("/proc/500/fd/4"));

  Findings findings;
  check_ports(machine(), wanted, findings);

  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].value, "7400, 7410 of domain 0 held by talker (pid 500)");
  EXPECT_THAT(findings[1].value, HasSubstr("7550 of domain 0 held by another user's program")) << "7650 is domain 1's";
}

TEST_F(AMachine, has_the_domain_that_a_robot_reads) {
  const auto facts_with = [](const char* domain) {
    ::setenv("ROS_DOMAIN_ID", domain, 1);
    Facts read = real_facts("1.0");
    ::unsetenv("ROS_DOMAIN_ID");
    return read;
  };
  EXPECT_EQ(facts_with("0x2a").domain, 42);
  EXPECT_FALSE(facts_with("").wrong_domain);
  facts = facts_with("99999999999");
  const Finding found = find(check_ports, "ROS_DOMAIN_ID");
  EXPECT_EQ(found.severity, Severity::Wrong);
  EXPECT_EQ(found.text(),
            "ROS_DOMAIN_ID: '99999999999' is not a domain; give a number from 0 to 232; 0 to 101 work everywhere");
}

TEST_F(AMachine, with_an_unsynchronised_clock_gets_advice) {
  facts.clock_is_synchronised = false;
  Finding found = find(check_clock, "wall clock");
  EXPECT_EQ(found.severity, Severity::Advice);
  EXPECT_THAT(found.problem.way_out, HasSubstr("timesyncd"));
  run(33, "chronyd");
  EXPECT_THAT(find(check_clock, "wall clock").problem.way_out, HasSubstr("chronyd runs"));
}

TEST_F(AMachine, whose_clock_stands_before_the_program_was_made_will_jump) {
  facts.now = WallTime{std::chrono::hours{1}};
  const Finding found = find(check_clock, "wall clock");
  EXPECT_EQ(found.severity, Severity::Wrong);
  EXPECT_EQ(found.value, "1970-01-01 01:00:00 UTC");
}

TEST_F(AMachine, without_a_battery_clock_gets_advice) {
  std::filesystem::remove_all(at("/sys/class/rtc"));
  EXPECT_EQ(find(check_clock, "battery clock").severity, Severity::Advice);
}

TEST_F(AMachine, that_is_short_of_memory_is_wrong) {
  write("/proc/meminfo",
        "MemTotal:  1000000 kB\nMemAvailable:    50000 kB\nSwapTotal:  200000 kB\nSwapFree:  10000 kB\n");
  const Finding memory = find(check_memory, "memory");
  EXPECT_EQ(memory.severity, Severity::Wrong);
  EXPECT_EQ(memory.value, "51 of 1024 MB available");
  const Finding swap = find(check_memory, "swap");
  EXPECT_EQ(swap.severity, Severity::Advice);
  EXPECT_EQ(swap.value, "195 of 205 MB used");
}

TEST_F(AMachine, reports_the_limits_of_its_control_group) {
  write("/sys/fs/cgroup/user.slice/memory.max", "200000000\n");
  write("/sys/fs/cgroup/user.slice/memory.current", "180000000\n");
  write("/sys/fs/cgroup/user.slice/cpu.max", "50000 100000\n");
  EXPECT_EQ(find(check_memory, "limit of the control group").severity, Severity::Wrong);
  EXPECT_EQ(find(check_memory, "CPU limit").value, "0.50 cores");
  write("/sys/fs/cgroup/user.slice/memory.max", "max\n");
  write("/sys/fs/cgroup/user.slice/cpu.max", "max 100000\n");
  Findings findings;
  check_memory(machine(), wanted, findings);
  EXPECT_EQ(findings.size(), 2U) << "memory and swap";
}

TEST_F(AMachine, with_small_buffers_is_advised_how_to_raise_them) {
  write("/proc/sys/net/core/rmem_max", "212992\n");
  const Finding found = find(check_kernel, "net.core.rmem_max");
  EXPECT_EQ(found.severity, Severity::Advice);
  EXPECT_EQ(found.value, "212992 B");
  EXPECT_EQ(found.problem.way_out, "sudo sysctl -w net.core.rmem_max=4194304");
}

TEST_F(AMachine, with_little_shared_memory_is_wrong_only_if_it_is_needed) {
  write("/proc/self/mounts", "shm /dev/shm tmpfs rw,relatime,size=65536k,inode64 0 0\n");
  EXPECT_EQ(find(check_kernel, "/dev/shm").severity, Severity::Advice);
  EXPECT_EQ(find(check_kernel, "/dev/shm").value, "67 MB");
  wanted.shares_memory = true;
  EXPECT_EQ(find(check_kernel, "/dev/shm").severity, Severity::Wrong);
  write("/proc/self/mounts", "tmpfs /dev/shm tmpfs rw,nosuid,nodev 0 0\n");
  EXPECT_EQ(find(check_kernel, "/dev/shm").value, "2048 MB") << "half of the memory, as the kernel has it";
}

TEST_F(AMachine, that_forbids_or_frees_real_time_threads_is_reported) {
  for (const char* const value : {"0\n", "-1\n"}) {
    write("/proc/sys/kernel/sched_rt_runtime_us", value);
    EXPECT_EQ(find(check_kernel, "kernel.sched_rt_runtime_us").severity, Severity::Advice) << value;
  }
}

TEST_F(AMachine, that_saves_power_is_advised) {
  write("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n");
  EXPECT_EQ(find(check_kernel, "CPU governor").severity, Severity::Advice);
  write("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  EXPECT_EQ(find(check_kernel, "CPU governor").severity, Severity::Fine);
}

TEST_F(AMachine, with_a_weak_supply_reports_whether_it_is_weak_now) {
  const auto supply = [&](const char* bits) {
    write("/sys/devices/platform/soc/soc:firmware/get_throttled", bits);
    return find(check_power, "Raspberry Pi's supply");
  };
  EXPECT_EQ(supply("0\n").severity, Severity::Fine);
  EXPECT_EQ(supply("50005\n").severity, Severity::Wrong);
  EXPECT_EQ(supply("50005\n").value, "under-voltage now (0x50005)");
  EXPECT_EQ(supply("50000\n").severity, Severity::Advice);
  EXPECT_EQ(supply("80008\n").problem.way_out, "cool it: a heat sink with a fan");
}

TEST_F(AMachine, that_is_hot_is_reported_by_its_hottest_zone) {
  write("/sys/class/thermal/thermal_zone0/temp", "45000\n");
  write("/sys/class/thermal/thermal_zone1/temp", "83500\n");
  const Finding found = find(check_power, "temperature");
  EXPECT_EQ(found.severity, Severity::Advice);
  EXPECT_EQ(found.value, "84 C");
}

TEST_F(AMachine, that_grants_no_real_time_is_wrong_for_a_thread_that_asks_for_it) {
  write("/proc/self/limits",
        "Max locked memory         8388608              8388608              bytes     \n"
        "Max realtime priority     0                    0                              \n");
  EXPECT_EQ(find(check_realtime, "real-time priority").severity, Severity::Advice);
  wanted.priorities = {{40, "/ekf"}};
  const Finding found = find(check_realtime, "real-time priority");
  EXPECT_EQ(found.severity, Severity::Wrong);
  EXPECT_EQ(found.problem.what, "/ekf asks for 40");
  EXPECT_THAT(found.problem.way_out, HasSubstr("limits.d"));
  EXPECT_EQ(find(check_realtime, "lockable memory").severity, Severity::Advice);
  EXPECT_EQ(find(check_realtime, "lockable memory").value, "8.4 MB");
  write("/proc/self/status", "Uid:\t4711\t4711\t4711\t4711\nCapEff:\t0000000000800000\n");
  EXPECT_EQ(find(check_realtime, "real-time priority").severity, Severity::Fine) << "CAP_SYS_NICE";
}

TEST_F(AMachine, tells_its_versions) {
  write("/usr/lib/libfmt.so.9.1.0", "");
  std::filesystem::create_symlink("libfmt.so.9.1.0", at("/usr/lib/libfmt.so.9"));
  write("/proc/self/maps",
        "7f00-7f01 r--p 00000000 08:01 1 /usr/lib/libfmt.so.9\n7f01-7f02 r-xp 00001000 08:01 1 /usr/lib/libfmt.so.9\n"
        "7f03-7f04 r--p 00000000 08:01 2 /opt/libnacelle_runtime.so\n7ffc-7ffd rw-p 00000000 00:00 0 [stack]\n");
  EXPECT_EQ(find(check_versions, "nacelle").value, "1.2.3");
  EXPECT_EQ(find(check_versions, "system").value, "Debian GNU/Linux 12 (bookworm), Linux 6.1.0");
  EXPECT_EQ(find(check_versions, "libraries").value, "libfmt.so.9.1.0");
}

TEST(Finding, is_one_line_with_what_was_found_and_the_way_out) {
  const Finding finding{Severity::Wrong, "clock", "12 s behind", {"wall clock", "jumps", "set it"}};
  EXPECT_EQ(finding.text(), "wall clock: 12 s behind, jumps; set it");
}

}  // namespace
}  // namespace nacelle::doctor
