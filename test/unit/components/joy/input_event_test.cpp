// SPDX-License-Identifier: Apache-2.0
#include "joy/protocol/input_event.hpp"

#include <gtest/gtest.h>
#include <linux/input.h>

#include <random>
#include <vector>

#include "joy/port/scripted_pad.hpp"

namespace nacelle::joy {
namespace {

static_assert(sizeof(input_event) == input_layout::kEventBytes && offsetof(input_event, type) == input_layout::kType &&
              offsetof(input_event, code) == input_layout::kCode &&
              offsetof(input_event, value) == input_layout::kValue);

std::vector<InputEvent> events_of(InputEventDecoder& decoder, ByteView bytes) {
  std::vector<InputEvent> found;
  while (const auto event = decoder.next(bytes)) found.push_back(*event);
  return found;
}

TEST(InputEvent, reads_the_kernels_layout) {
  // BTN_SOUTH down at 1.000002 s, ABS_Y at -32768, SYN_REPORT.
  const Bytes bytes{1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0x30, 0x01, 1, 0,    0,    0,     //
                    1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0x01, 0x00, 0, 0x80, 0xFF, 0xFF,  //
                    1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x00, 0x00, 0, 0,    0,    0};
  InputEventDecoder decoder;
  const auto found = events_of(decoder, bytes);
  ASSERT_EQ(found.size(), 3U);
  const MonotonicTime at{1s + 2us};
  EXPECT_EQ(found[0], (InputEvent{at, input_layout::kKey, BTN_SOUTH, 1}));
  EXPECT_EQ(found[1], (InputEvent{at, input_layout::kAbs, ABS_Y, -32768}));
  EXPECT_TRUE(found[2].is_syn(input_layout::kSynReport));
}

TEST(InputEvent, is_what_the_kernels_struct_holds_however_it_is_chopped) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random{kSeed};
  Bytes bytes;
  std::vector<InputEvent> expected;
  for (int i = 0; i < 1000; ++i) {
    const InputEvent event{MonotonicTime{std::chrono::microseconds{random()}}, static_cast<std::uint16_t>(random()),
                           static_cast<std::uint16_t>(random()), static_cast<std::int32_t>(random())};
    const Bytes one = ScriptedPad::event(event.at, event.type, event.code, event.value);
    bytes.insert(bytes.end(), one.begin(), one.end());
    expected.push_back(event);
  }
  InputEventDecoder decoder;
  std::vector<InputEvent> found;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - at, 1 + random() % 60);
    for (const InputEvent& event : events_of(decoder, ByteView{bytes}.subspan(at, part))) found.push_back(event);
    at += part;
    const auto& s = decoder.stats();
    ASSERT_EQ(s.bytes, 24 * s.events + s.dropped_bytes + decoder.pending());
  }
  EXPECT_EQ(found, expected) << "seed " << kSeed;
}

TEST(InputEvent, restart_drops_half_an_event) {
  InputEventDecoder decoder;
  EXPECT_TRUE(events_of(decoder, Bytes(10, 1)).empty());
  decoder.restart();
  EXPECT_EQ(decoder.stats().dropped_bytes, 10U);
  EXPECT_EQ(events_of(decoder, Bytes(24, 0)).size(), 1U);
}

}  // namespace
}  // namespace nacelle::joy
