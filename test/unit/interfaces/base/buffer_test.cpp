// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <utility>

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
