// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/text.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle {
namespace {

TEST(DurationText, round_trips) {
  std::mt19937_64 random{20261121};
  std::vector<std::int64_t> cases{
      0, 1, 999, 1000, 1001, 100'000'000, 1'500'000'000, 86'400'000'000'000, 1'000'000'000'000'000'000};
  for (int i = 0; i < 1000; ++i) cases.push_back(static_cast<std::int64_t>(random() >> (1 + random() % 62)));
  for (const std::int64_t ns : cases) {
    const auto back = parse_duration(to_text(Duration{ns}));
    ASSERT_TRUE(back) << ns << " " << to_text(Duration{ns});
    EXPECT_EQ(back->count(), ns) << to_text(Duration{ns});
  }
}

TEST(DurationText, reads_what_people_write) {
  EXPECT_EQ(parse_duration("100ms").value(), Duration{100ms});
  EXPECT_EQ(parse_duration("1s").value(), Duration{1s});
  EXPECT_EQ(parse_duration("1.5s").value(), Duration{1500ms});
  EXPECT_EQ(parse_duration("0.1s").value().count(), 100'000'000);
  EXPECT_EQ(parse_duration("250 us").value(), Duration{250us});
  EXPECT_EQ(parse_duration("2min").value(), Duration{2min});
  EXPECT_EQ(parse_duration("infinite").value(), Duration::max());
}

TEST(DurationText, refuses_what_it_would_have_to_guess) {
  EXPECT_EQ(parse_duration("100").error().way_out, "write 100ms or 100s");
  for (const char* text : {"", "ms", "-1s", "1.5.2s", "1e3s", "1 sec", "99999999999999999999s", "s1", " 1s", "."}) {
    EXPECT_FALSE(parse_duration(text)) << text;
  }
}

TEST(DurationText, never_shows_a_control_character) {
  EXPECT_EQ(parse_duration("\x1b[31m").error().text().find('\x1b'), std::string::npos);
}

TEST(PolicyText, round_trips_every_value) {
  for (const auto v : {Reliability::SystemDefault, Reliability::Reliable, Reliability::BestEffort, Reliability::Unknown,
                       Reliability::BestAvailable}) {
    EXPECT_EQ(parse_reliability(to_text(v)).value(), v);
  }
  for (const auto v : {Durability::SystemDefault, Durability::TransientLocal, Durability::Volatile, Durability::Unknown,
                       Durability::BestAvailable}) {
    EXPECT_EQ(parse_durability(to_text(v)).value(), v);
  }
  for (const auto v : {History::SystemDefault, History::KeepLast, History::KeepAll, History::Unknown}) {
    EXPECT_EQ(parse_history(to_text(v)).value(), v);
  }
  for (const auto v : {Liveliness::SystemDefault, Liveliness::Automatic, Liveliness::ManualByTopic, Liveliness::Unknown,
                       Liveliness::BestAvailable}) {
    EXPECT_EQ(parse_liveliness(to_text(v)).value(), v);
  }
}

TEST(PolicyText, names_the_nearest_value) {
  EXPECT_EQ(parse_reliability("besteffort").error().text(),
            "'besteffort' is not a reliability; did you mean 'best_effort'?");
  EXPECT_EQ(parse_durability("transient-local").error().way_out, "did you mean 'transient_local'?");
}

}  // namespace
}  // namespace nacelle
