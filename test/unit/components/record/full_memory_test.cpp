// SPDX-License-Identifier: Apache-2.0
// Rings in a /dev/shm that other programs have filled, each in a process with a /dev/shm of its own.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <std_msgs/msg/string.hpp>
#include <string>

#include "nacelle/runtime/test_container.hpp"
#include "record/component/ring.hpp"
#include "support/child_process.hpp"

namespace nacelle::record {
namespace {

using std_msgs::msg::String;

constexpr int kNotAllowed = 77;

/// Without a user namespace only root may mount; in one, this user is mapped to itself.
bool enter_own_memory(const std::string& size) {
  const uid_t user = ::geteuid();
  const gid_t group = ::getegid();
  if (::unshare(CLONE_NEWNS) != 0) {
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
    std::ofstream{"/proc/self/setgroups"} << "deny";
    std::ofstream{"/proc/self/uid_map"} << user << " " << user << " 1";
    std::ofstream{"/proc/self/gid_map"} << group << " " << group << " 1";
  }
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 &&
      ::mount(nullptr, "/dev/shm", nullptr, MS_PRIVATE, nullptr) != 0)
    return false;
  return ::mount("tmpfs", "/dev/shm", "tmpfs", 0, ("mode=1777,size=" + size).c_str()) == 0;
}

/// Returns false if the kernel does not let this user have a /dev/shm of its own.
bool run_in(const std::string& size, const std::function<void()>& part) {
  static_cast<void>(runtime::TestContainer::program());
  const int code = test::run_in_child([&] {
    if (!enter_own_memory(size)) ::_exit(kNotAllowed);
    part();
  });
  if (code == kNotAllowed) return false;
  EXPECT_EQ(code, 0);
  return true;
}

void fill(const std::string& path, std::size_t bytes) { std::ofstream{path} << std::string(bytes, 'x'); }

/// Says one message, and closes its chunk.
void say(Ring& ring, std::size_t bytes, std::uint64_t second) {
  String message;
  message.data.assign(bytes, 'x');
  ring.look_at_time(MonotonicTime{1s * second});
  ring.write(ring.add_topic("/a", String::message_type(), {QoS(10)}), &message, {second, second});
  ring.look_at_time(MonotonicTime{1s * second + 1s});
}

TEST(FullMemory, makes_a_ring_shorter) {
  const bool is_allowed = run_in("20m", [] {
    auto ring = Ring::begin({.name = "a", .most_bytes = 64 * kMegabyte});
    ASSERT_TRUE(ring) << ring.error().text();
    EXPECT_NEAR(static_cast<double>((*ring)->most_bytes()), 10.5e6, 0.1e6) << "half of what is free";
    for (std::uint64_t second = 1; second <= 20; ++second) say(**ring, 900'000, second);
    EXPECT_EQ((*ring)->files(), 11U);
    fill("/dev/shm/other", 30'000'000);
    say(**ring, 900'000, 21);
    EXPECT_FALSE((*ring)->problem()) << (*ring)->problem()->text();
    EXPECT_LE((*ring)->files(), 11U);
    EXPECT_EQ((*ring)->reach(), std::optional<Duration>{1s * (*ring)->files()});
    (*ring)->finish();
  });
  if (!is_allowed) GTEST_SKIP() << "this user may have no /dev/shm of its own";
}

TEST(FullMemory, ends_a_ring_that_has_no_room_for_one_chunk) {
  const bool is_allowed = run_in("20m", [] {
    auto ring = Ring::begin({.name = "a"});
    ASSERT_TRUE(ring);
    fill("/dev/shm/other", 30'000'000);
    say(**ring, 900'000, 1);
    ASSERT_TRUE((*ring)->problem());
    EXPECT_EQ((*ring)->problem()->code.text(), "file.no_room");
    say(**ring, 10, 2);
    EXPECT_EQ((*ring)->messages(), 1U);
  });
  if (!is_allowed) GTEST_SKIP() << "this user may have no /dev/shm of its own";
}

TEST(FullMemory, is_an_open_fault_of_the_recorder_and_the_robot_goes_on) {
  const bool is_allowed = run_in("4m", [] {
    runtime::TestContainer container;
    const auto recorder = container.start("nacelle::record::RecordComponent",
                                          {{"record.all_topics", true}, {"storage.ring", std::int64_t{60}}});
    EXPECT_EQ(recorder.state, StateId::Active);
    ASSERT_EQ(recorder.open_faults.size(), 1U);
    EXPECT_EQ(recorder.open_faults.front().code, "RECORDING_ENDED");
    EXPECT_NE(recorder.open_faults.front().text.find("/dev/shm: is full"), std::string::npos);
    EXPECT_EQ(container.container().trigger(recorder.id, Transition::Deactivate).reason, "");
  });
  if (!is_allowed) GTEST_SKIP() << "this user may have no /dev/shm of its own";
}

}  // namespace
}  // namespace nacelle::record
