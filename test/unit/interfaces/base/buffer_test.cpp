// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <thread>
#include <utility>
#include <vector>

#include "nacelle/base/buffer.hpp"

namespace nacelle {
namespace {

struct Lender {
  std::array<int, 8> memory{1, 2, 3, 4, 5, 6, 7, 8};
  int returned = 0;
  ReleaseHook hook() {
    return {[](void* self) noexcept { ++static_cast<Lender*>(self)->returned; }, this};
  }
};

TEST(Buffer, gives_adopted_memory_back_exactly_once) {
  Lender lender;
  {
    Buffer<int> buffer;
    buffer.adopt(lender.memory.data(), 4, 8, lender.hook());
    Buffer<int> moved = std::move(buffer);
    EXPECT_EQ(moved.data(), lender.memory.data());
    EXPECT_EQ(lender.returned, 0);
  }
  EXPECT_EQ(lender.returned, 1);
}

TEST(Buffer, stays_in_adopted_memory_within_its_capacity_and_leaves_it_beyond) {
  Lender lender;
  Buffer<int> buffer;
  buffer.adopt(lender.memory.data(), 4, 8, lender.hook());
  buffer.resize_uninitialized(8);
  EXPECT_EQ(buffer.data(), lender.memory.data());
  buffer.resize(9);
  EXPECT_NE(buffer.data(), lender.memory.data());
  EXPECT_EQ(lender.returned, 1);
  EXPECT_EQ(buffer, (Buffer<int>{1, 2, 3, 4, 5, 6, 7, 8, 0}));
}

TEST(Buffer, copies_into_memory_of_its_own) {
  Lender lender;
  Buffer<int> foreign;
  foreign.adopt(lender.memory.data(), 3, 8, lender.hook());
  Buffer<int> copy = foreign;
  EXPECT_FALSE(copy.is_foreign());
  EXPECT_EQ(copy, foreign);
  foreign = copy;
  EXPECT_EQ(lender.returned, 1);
  EXPECT_EQ(foreign, (Buffer<int>{1, 2, 3}));
}

TEST(Buffer, keeps_its_capacity_when_cleared_and_given_back) {
  Buffer<int> buffer(100, 5);
  const int* const memory = buffer.data();
  buffer.clear();
  buffer.give_back();
  buffer.resize(100);
  EXPECT_EQ(buffer.data(), memory);
  EXPECT_EQ(buffer[99], 0);
}

#if !defined(NACELLE_SANITIZED)
std::size_t resident_pages_of(Buffer<std::uint8_t>& buffer) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t before = reinterpret_cast<std::uintptr_t>(buffer.data()) % page;
  std::vector<unsigned char> pages((before + buffer.size()) / page + 1);
  EXPECT_EQ(::mincore(buffer.data() - before, before + buffer.size(), pages.data()), 0);
  return static_cast<std::size_t>(std::ranges::count_if(pages, [](unsigned char flags) { return (flags & 1U) != 0; }));
}
#endif

TEST(Buffer, is_reserved_like_another_one_without_its_elements) {
  const Buffer<std::uint8_t> large(std::size_t{64} << 20U, 7), small(1000, 7);
  Buffer<std::uint8_t> reserved, short_one, elsewhere;
  {
    const ReservingCopies only_memory;
    reserved = large;
    short_one = small;
    std::thread([&] { elsewhere = large; }).join();
  }
  EXPECT_EQ(reserved.size(), large.size());
  EXPECT_EQ(reserved.capacity(), large.size());
#if !defined(NACELLE_SANITIZED)
  EXPECT_LT(resident_pages_of(reserved), 16U) << "of 16,384";
#endif
  EXPECT_EQ(short_one, small);
  EXPECT_EQ(elsewhere, large) << "another thread copies as ever";
  reserved = large;
  EXPECT_EQ(reserved, large) << "and so does this one afterwards";
}

TEST(Buffer, behaves_like_a_vector) {
  Buffer<double> buffer;
  for (int i = 0; i < 1000; ++i) buffer.push_back(i);
  EXPECT_EQ(buffer.size(), 1000U);
  EXPECT_EQ(buffer.back(), 999.0);
  EXPECT_THROW((void)buffer.at(1000), std::out_of_range);
  buffer.assign(3, 2.5);
  EXPECT_EQ(std::vector<double>(buffer.begin(), buffer.end()), (std::vector<double>{2.5, 2.5, 2.5}));
}

}  // namespace
}  // namespace nacelle
