// SPDX-License-Identifier: Apache-2.0
// The matrix of qos_matrix_test.cpp between two graphs that only the network joins: all pairs at once, each on a topic of its
// own. Delivery is asynchronous, so the test waits for each round of messages, and sends a fence now and then: when a fence has
// arrived, all earlier messages have been written.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "mirrored.hpp"

namespace nacelle {
namespace {

using test::hear;
using test::say;
using test::Texts;

struct Offer {
  Durability durability;
  std::size_t depth;  // 0: keep all
  Reliability reliability;

  [[nodiscard]] QoS qos() const {
    QoS qos(depth);
    if (depth == 0) qos.keep_all();
    return qos.durability(durability).reliability(reliability);
  }
  [[nodiscard]] bool is_reliable() const { return reliability == Reliability::Reliable; }
  [[nodiscard]] bool keeps() const { return durability == Durability::TransientLocal; }
  [[nodiscard]] std::string name() const {
    return std::string(keeps() ? "transient" : "volatile") + " last " + std::to_string(depth) +
           (is_reliable() ? " reliable" : " best effort");
  }
};

std::vector<Offer> every_offer() {
  std::vector<Offer> all;
  for (const auto durability : {Durability::Volatile, Durability::TransientLocal}) {
    for (const auto reliability : {Reliability::BestEffort, Reliability::Reliable}) {
      for (const std::size_t depth : {1U, 3U, 0U}) all.push_back({durability, depth, reliability});
    }
  }
  return all;
}

Texts newest(const Texts& all, std::size_t depth) {
  if (depth == 0 || depth >= all.size()) return all;
  return {all.end() - static_cast<std::ptrdiff_t>(depth), all.end()};
}

/// A writer here, a reader there, and what the reader may ask for.
struct Pair {
  Offer offered, requested;
  bool late = false;
  std::unique_ptr<Writer> writer{};
  std::unique_ptr<Reader> reader{};
  std::size_t due = 0;  // messages that must have come to the reader

  [[nodiscard]] bool gets_history() const {
    // As in process, but for one thing: Cyclone sends a history to reliable readers only.
    return late && clashes().empty() && requested.keeps() && requested.is_reliable();
  }
  /// The policy that keeps them apart, as DDS orders them; empty: none does.
  [[nodiscard]] std::set<std::string> clashes() const {
    std::set<std::string> out;
    if (!offered.is_reliable() && requested.is_reliable()) out.insert("reliability");
    if (!offered.keeps() && requested.keeps()) out.insert("durability");
    return out;
  }
  [[nodiscard]] Texts expected() const {
    if (!clashes().empty()) return {};
    const Texts before{"1", "2", "3", "4", "5"};
    Texts reached = late ? (gets_history() ? newest(before, offered.depth) : Texts{}) : before;
    reached.insert(reached.end(), {"6", "7"});
    return newest(reached, requested.depth);
  }
  [[nodiscard]] std::string name() const {
    return offered.name() + " to " + requested.name() + (late ? ", late" : ", early");
  }
};

class MirroredMatrix : public ::testing::Test {
 public:
  MirroredMatrix() {
    for (const Offer& offered : every_offer()) {
      for (const Offer& requested : every_offer()) {
        for (const bool late : {false, true}) pairs.push_back({offered, requested, late});
      }
    }
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].writer = here.writer(topic(i), pairs[i].offered.qos());
  }
  [[nodiscard]] static std::string topic(std::size_t i) { return "/pair_" + std::to_string(i); }

  void make_readers(bool late) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (pairs[i].late == late) pairs[i].reader = there.reader(topic(i), pairs[i].requested.qos());
    }
    for (const Pair& pair : pairs) {
      if (pair.late != late) continue;
      EXPECT_TRUE(there.bell.until([&] { return have_met(pair); })) << pair.name();
    }
    for (Pair& pair : pairs) {
      if (late && pair.gets_history()) pair.due += pair.offered.depth == 0 ? 5 : pair.offered.depth;
    }
    wait_for_all();
  }
  // The first message of a stream may come as a repetition, behind the fence: Cyclone's reliable reader wants a heartbeat first. A writer
  // that keeps one would have lost it to the next.
  void wait_for_all() {
    for (const Pair& pair : pairs) {
      if (pair.due == 0) continue;
      EXPECT_TRUE(there.bell.until([&] { return pair.reader->counters().received >= pair.due; })) << pair.name();
    }
  }
  [[nodiscard]] static bool have_met(const Pair& pair) {
    const bool clash = !pair.clashes().empty();
    const auto writer = pair.writer->status(), reader = pair.reader->status();
    return clash ? writer.incompatible_qos == 1 && reader.incompatible_qos == 1
                 : writer.matched == 1 && reader.matched == 1;
  }
  // In batches: a socket's buffer holds about two hundred packets, and best-effort readers do not get lost ones again.
  void say_everywhere(const std::string& text) {
    constexpr std::size_t kAtOnce = 24;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      say(*pairs[i].writer, text);
      if ((i + 1) % kAtOnce != 0 && i + 1 != pairs.size()) continue;
      const Fence& fence = fences[++rounds % 2];
      say(*fence.writer, text);
      ASSERT_EQ(hear(there.bell, *fence.reader, 1), Texts{text});
    }
    for (Pair& pair : pairs) {
      if (pair.reader && pair.clashes().empty()) ++pair.due;
    }
    wait_for_all();
  }

  test::MirroredBroker here{"talker"}, there{"listener"};
  std::vector<Pair> pairs;
  struct Fence {
    std::unique_ptr<Writer> writer;
    std::unique_ptr<Reader> reader;
  };
  // In turn: a writer's message that comes while the one before is being sent goes before those of others.
  std::array<Fence, 2> fences{Fence{here.writer("/one", QoS(KeepAll{})), there.reader("/one", QoS(KeepAll{}))},
                              Fence{here.writer("/two", QoS(KeepAll{})), there.reader("/two", QoS(KeepAll{}))}};
  std::size_t rounds = 0;
};

TEST_F(MirroredMatrix, delivers_as_specified_and_names_the_incompatible_policies) {
  for (const Fence& fence : fences) {
    ASSERT_TRUE(there.bell.until([&] { return fence.writer->reader_count() + fence.reader->writer_count() == 2; }));
  }
  make_readers(false);
  for (const char* text : {"1", "2", "3", "4", "5"}) say_everywhere(text);
  make_readers(true);
  for (const char* text : {"6", "7"}) say_everywhere(text);
  for (const Pair& pair : pairs) {
    EXPECT_EQ(hear(*pair.reader), pair.expected()) << pair.name();
    const auto clashes = pair.clashes();
    if (clashes.empty()) continue;
    EXPECT_TRUE(clashes.contains(pair.writer->status().last_policy)) << pair.name() << pair.writer->status().last_clash;
    EXPECT_TRUE(clashes.contains(pair.reader->status().last_policy)) << pair.name() << pair.reader->status().last_clash;
  }
  // A reader that gets nothing is reported once, by the side that publishes, when its node had time to bring another reader.
  const auto unserved = std::ranges::count_if(pairs, [](const Pair& pair) { return !pair.clashes().empty(); });
  EXPECT_TRUE(here.bell.until([&] { return here.stats().problems == static_cast<std::uint64_t>(unserved); }))
      << here.stats().problems;
  const std::vector<std::string> problems = *here.problems.lock();
  for (const auto& problem : problems) EXPECT_NE(problem.find("/listener asks for"), std::string::npos) << problem;
  EXPECT_EQ(there.stats().problems, 0U);
  EXPECT_EQ(here.stats().overtaken + here.stats().refused + there.stats().stray, 0U);
}

}  // namespace
}  // namespace nacelle
