// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/sample_ring.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <random>

namespace nacelle::transport_dds {
namespace {

using Entry = std::unique_ptr<int>;
using Ring = SampleRing<Entry>;

Ring::Pushed push(Ring& ring, int value, bool overwrite) {
  Entry entry = std::make_unique<int>(value);
  return ring.push(entry, overwrite);
}

TEST(SampleRing, gives_out_in_the_order_of_arrival) {
  Ring ring{100};
  for (int i = 0; i < 20; ++i) EXPECT_EQ(push(ring, i, true), Ring::Pushed::Fine);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(*ring.pop(), i);
  EXPECT_TRUE(ring.empty());
}

TEST(SampleRing, hands_back_the_oldest_when_it_overwrites) {
  Ring ring{2};
  EXPECT_EQ(push(ring, 1, true), Ring::Pushed::Fine);
  EXPECT_EQ(push(ring, 2, true), Ring::Pushed::Fine);
  Entry entry = std::make_unique<int>(3);
  EXPECT_EQ(ring.push(entry, true), Ring::Pushed::Overwrote);
  EXPECT_EQ(entry ? *entry : 0, 1);
  EXPECT_EQ(*ring.pop(), 2);
  EXPECT_EQ(*ring.pop(), 3);
}

TEST(SampleRing, leaves_the_entry_with_the_caller_when_it_is_full) {
  Ring ring{1};
  EXPECT_EQ(push(ring, 1, false), Ring::Pushed::Fine);
  Entry entry = std::make_unique<int>(2);
  EXPECT_EQ(ring.push(entry, false), Ring::Pushed::Full);
  EXPECT_EQ(entry ? *entry : 0, 2);
  EXPECT_EQ(*ring.pop(), 1);
}

TEST(SampleRing, behaves_as_a_bounded_deque) {
  const unsigned seed = 20261122;
  std::mt19937 random{seed};
  for (const std::size_t limit : {1U, 2U, 7U, 8U, 9U, 31U}) {
    Ring ring{limit};
    std::deque<int> model;
    for (int step = 0; step < 2000; ++step) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", limit " << limit << ", step " << step);
      if (random() % 3 != 0) {
        const bool overwrite = random() % 2 == 0;
        const bool has_room = model.size() < limit;
        const auto did = push(ring, step, overwrite);
        EXPECT_EQ(did, has_room ? Ring::Pushed::Fine : overwrite ? Ring::Pushed::Overwrote : Ring::Pushed::Full);
        if (!has_room && overwrite) model.pop_front();
        if (has_room || overwrite) model.push_back(step);
      } else if (!model.empty()) {
        ASSERT_EQ(*ring.pop(), model.front());
        model.pop_front();
      }
      ASSERT_EQ(ring.size(), model.size());
    }
  }
}

}  // namespace
}  // namespace nacelle::transport_dds
