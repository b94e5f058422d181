// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace nacelle::test {

enum class Kind : std::uint8_t { Request = 'j', Publish = 'p', Stats = 's', Lookup = 't' };
bool is_known(Kind kind) {
  return kind == Kind::Request || kind == Kind::Publish || kind == Kind::Stats || kind == Kind::Lookup;
}

namespace {

enum class Fault : std::uint8_t { TooLong, UnknownKind, NotNow };
using Reader = FrameReader<Kind, Fault>;
using Seen = std::vector<std::pair<Kind, std::string>>;

/// Feeds the bytes in pieces of the given sizes; true unless the reader gave up.
template <typename NextSize>
bool feed(Reader& reader, std::string_view bytes, NextSize&& next_size, Seen& seen) {
  while (!bytes.empty()) {
    const ByteSpan room = reader.room();
    const std::size_t n = std::min({bytes.size(), room.size(), std::max<std::size_t>(1, next_size())});
    std::copy_n(bytes.begin(), n, room.begin());
    reader.filled(n);
    bytes.remove_prefix(n);
    while (true) {
      auto frame = reader.next();
      if (!frame) return false;
      if (!frame.value()) break;
      seen.emplace_back(frame.value()->kind, std::string{as_text(frame.value()->payload)});
    }
  }
  return true;
}

constexpr Kind kKinds[] = {Kind::Request, Kind::Publish, Kind::Stats, Kind::Lookup};

TEST(FrameReader, gives_the_same_frames_for_any_chopping_of_the_bytes) {
  const unsigned seed = 20261121;
  std::mt19937 random{seed};
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", round " << round);
    std::string bytes;
    Seen sent;
    for (int i = 0; i < 20; ++i) {
      std::string payload(random() % (i % 5 == 0 ? 20000 : 50), '\0');
      for (char& c : payload) c = static_cast<char>(random());
      const Kind kind = kKinds[random() % 4];
      append_frame(bytes, kind, payload);
      sent.emplace_back(kind, payload);
    }
    Reader reader{1U << 16U};
    Seen seen;
    ASSERT_TRUE(feed(
        reader, bytes, [&] { return random() % 4000; }, seen));
    EXPECT_EQ(seen, sent);
    EXPECT_EQ(reader.pending(), 0U);
  }
}

TEST(FrameReader, survives_noise_within_its_bound) {
  const unsigned seed = 4;
  std::mt19937 random{seed};
  for (int round = 0; round < 2000; ++round) {
    Reader reader{1000};
    std::string noise(random() % 300, '\0');
    for (char& c : noise) c = static_cast<char>(random() % (round % 2 == 0 ? 256 : 4));
    Seen seen;
    static_cast<void>(feed(
        reader, noise, [&] { return random() % 7; }, seen));
    for (const auto& [kind, payload] : seen) {
      EXPECT_TRUE(is_known(kind));
      EXPECT_LE(payload.size(), 1000U) << "seed " << seed << ", round " << round;
    }
    EXPECT_LE(reader.pending(), 1000U + kFrameHeaderBytes);
  }
}

TEST(FrameReader, refuses_a_length_above_its_bound_before_the_payload_comes) {
  Reader reader{100};
  std::string bytes;
  append_frame(bytes, Kind::Request, std::string(101, 'x'));
  Seen seen;
  EXPECT_FALSE(feed(
      reader, std::string_view{bytes}.substr(0, kFrameHeaderBytes), [] { return 100U; }, seen));
  EXPECT_EQ(reader.next().error(), Fault::TooLong);
}

TEST(FrameReader, asks_its_user_before_the_payload_comes) {
  Reader reader{100};
  const auto refusal = [](Kind kind) { return kind == Kind::Stats ? std::optional{Fault::NotNow} : std::nullopt; };
  std::string bytes;
  append_frame(bytes, Kind::Request, "x");
  append_frame(bytes, Kind::Stats, "yy");
  std::copy_n(bytes.begin(), bytes.size() - 2, reader.room().begin());
  reader.filled(bytes.size() - 2);
  ASSERT_TRUE(reader.next(refusal));
  EXPECT_EQ(reader.next(refusal).error(), Fault::NotNow);
}

TEST(Frames, are_the_same_bytes_in_a_string_and_in_bytes) {
  std::string text = "before";
  append_frame(text, Kind::Lookup, std::string(258, 'x'));
  Bytes bytes{'b', 'e', 'f', 'o', 'r', 'e'};
  append_frame(bytes, Kind::Lookup, std::string(258, 'x'));
  EXPECT_EQ(text, as_text(bytes));
  EXPECT_EQ(text.substr(6, kFrameHeaderBytes), (std::string{"\2\1\0\0t", 5}));
}

TEST(FrameReader, takes_a_payload_of_exactly_its_bound) {
  Reader reader{100};
  std::string bytes;
  append_frame(bytes, Kind::Request, std::string(100, 'x'));
  Seen seen;
  ASSERT_TRUE(feed(
      reader, bytes, [] { return 9U; }, seen));
  EXPECT_EQ(seen, (Seen{{Kind::Request, std::string(100, 'x')}}));
}

TEST(FrameReader, refuses_a_kind_that_it_does_not_know) {
  Reader reader{100};
  const std::string bytes{"\0\0\0\0!", 5};
  Seen seen;
  EXPECT_FALSE(feed(
      reader, bytes, [] { return 5U; }, seen));
  EXPECT_EQ(reader.next().error(), Fault::UnknownKind);
}

}  // namespace
}  // namespace nacelle::test
