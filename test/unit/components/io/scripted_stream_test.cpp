// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/scripted_stream.hpp"

#include <gtest/gtest.h>

namespace nacelle::io {
namespace {

constexpr MonotonicTime at(Duration since) { return {since}; }

TEST(ScriptedStream, gives_each_chunk_at_its_time_and_nothing_before) {
  MonotonicTime now{};
  ScriptedStream line{
      {{at(10ms), {1, 2}}, {at(30ms), {3}}}, ScriptedStream::AtEnd::Silence, [&](MonotonicTime t) { now = t; }};

  const auto early = line.read_until(at(5ms));
  ASSERT_TRUE(early);
  EXPECT_TRUE(early->empty());
  EXPECT_EQ(now, at(5ms));

  const auto first = line.read_until(at(20ms));
  ASSERT_TRUE(first);
  EXPECT_EQ(Bytes(first->begin(), first->end()), (Bytes{1, 2}));
  EXPECT_EQ(now, at(10ms));
}

TEST(ScriptedStream, stays_broken_until_it_is_opened_again) {
  ScriptedStream line{{{at(1ms), {}, StreamFault::HungUp}, {at(2ms), {7}}}};

  EXPECT_EQ(line.read_until(at(9ms)).error(), StreamFault::HungUp);
  EXPECT_EQ(line.read_until(at(9ms)).error(), StreamFault::HungUp);
  EXPECT_EQ(line.write(Bytes{1}).error(), StreamFault::HungUp);

  line.refuse_reopen(1);
  EXPECT_EQ(line.reopen().error(), StreamFault::NotFound);
  ASSERT_TRUE(line.reopen());
  const auto bytes = line.read_until(at(9ms));
  ASSERT_TRUE(bytes);
  EXPECT_EQ(bytes->front(), 7);
}

TEST(ScriptedStream, records_writes_and_answers_them) {
  ScriptedStream line{{}};
  line.answer_writes([](ByteView bytes) { return Bytes(bytes.rbegin(), bytes.rend()); });

  ASSERT_TRUE(line.write(Bytes{1, 2, 3}));

  EXPECT_EQ(line.written(), (Bytes{1, 2, 3}));
  const auto answer = line.read_until(at(1ms));
  ASSERT_TRUE(answer);
  EXPECT_EQ(Bytes(answer->begin(), answer->end()), (Bytes{3, 2, 1}));
}

}  // namespace
}  // namespace nacelle::io
