// SPDX-License-Identifier: Apache-2.0
#include "transport_iceoryx/src/daemon_process.hpp"

#include <gtest/gtest.h>

namespace nacelle::transport_iceoryx {
namespace {

constexpr const char* kLocks =
    "1: FLOCK  ADVISORY  WRITE 22384 fe:00:10952874 0 EOF\n"
    "1: -> FLOCK  ADVISORY  WRITE 999 fe:00:10952874 0 EOF\n"
    "2: POSIX  ADVISORY  WRITE 700 fe:00:10952875 0 EOF\n"
    "3: FLOCK  ADVISORY  WRITE 18510 08:01:10952874 0 EOF\n"
    "4: FLOCK  ADVISORY  WRITE 4242 00:2a:77 0 EOF\n"
    "garbage\n";

TEST(HolderOfALock, is_the_process_that_holds_it_on_that_device_and_not_a_waiting_one) {
  EXPECT_EQ(holder_of(kLocks, 10952874, 0xfe, 0), 22384);
  EXPECT_EQ(holder_of(kLocks, 10952874, 8, 1), 18510);
}

TEST(HolderOfALock, is_found_by_its_file_alone_where_the_device_has_two_names) {
  EXPECT_EQ(holder_of(kLocks, 77, 0, 5), 4242);
  EXPECT_EQ(holder_of(kLocks, 10952874, 1, 1), 0) << "two files have that number: neither is believed";
}

TEST(HolderOfALock, is_none_without_a_holder) {
  EXPECT_EQ(holder_of(kLocks, 10952875, 0xfe, 0), 0) << "another kind of lock";
  EXPECT_EQ(holder_of(kLocks, 5, 0xfe, 0), 0);
  EXPECT_EQ(holder_of("", 77, 0, 0x2a), 0);
}

}  // namespace
}  // namespace nacelle::transport_iceoryx
