// SPDX-License-Identifier: Apache-2.0
// The broker against a model: first what one thread does, step by step; then what several do at once.
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <random>
#include <std_msgs/msg/string.hpp>
#include <thread>
#include <vector>

#include "nacelle/runtime/broker.hpp"

namespace nacelle::runtime {
namespace {

using std_msgs::msg::String;

EndpointSpec spec(const QoS& qos) { return {"/model", &String::message_type(), qos, "/node"}; }

void publish(Writer& writer, const std::string& text) {
  Block* const block = writer.borrow();
  static_cast<String*>(block->message)->data = text;
  writer.publish(*block);
}

// KEEP_LAST, volatile: the last `depth` since it joined. As the specification says it, in a list.
struct ModelReader {
  std::unique_ptr<Reader> reader;
  std::size_t depth = 0;
  std::deque<std::string> queue;
  std::uint64_t received = 0, overwritten = 0;
};

TEST(BrokerModel, a_sequence_of_steps_has_the_specified_effect) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random{seed};
    const SystemClock clock;
    Broker broker{clock};
    std::vector<std::unique_ptr<Writer>> writers;
    std::vector<ModelReader> readers;
    std::vector<Block*> held;  // messages outlive what they came from
    for (int step = 0; step < 400; ++step) {
      const auto pick = [&](std::size_t n) { return random() % n; };
      switch (pick(8)) {
        case 0:
          if (writers.size() < 4) writers.push_back(broker.create_writer(spec(QoS(5))));
          break;
        case 1:
          if (!writers.empty() && pick(3) == 0) writers.erase(writers.begin() + static_cast<int>(pick(writers.size())));
          break;
        case 2:
          if (readers.size() < 5) {
            ModelReader made;
            made.depth = 1 + pick(4);
            made.reader =
                broker.create_reader(spec(QoS(made.depth)), pick(2) == 0 ? Taking::Own : Taking::Share, nullptr);
            readers.push_back(std::move(made));
          }
          break;
        case 3:
          if (!readers.empty() && pick(3) == 0) readers.erase(readers.begin() + static_cast<int>(pick(readers.size())));
          break;
        case 4:
        case 5: {
          if (writers.empty()) break;
          const std::string text = std::to_string(step);
          publish(*writers[pick(writers.size())], text);
          for (auto& model : readers) {
            model.queue.push_back(text);
            ++model.received;
            if (model.queue.size() <= model.depth) continue;
            model.queue.pop_front();
            ++model.overwritten;
          }
          break;
        }
        default: {
          if (readers.empty()) break;
          ModelReader& model = readers[pick(readers.size())];
          Block* const block = model.reader->take();
          ASSERT_EQ(block == nullptr, model.queue.empty()) << "step " << step;
          if (block == nullptr) break;
          ASSERT_EQ(static_cast<const String*>(block->message)->data, model.queue.front()) << "step " << step;
          model.queue.pop_front();
          held.push_back(block);
          break;
        }
      }
      for (const auto& model : readers) {
        const ReaderCounters counters = model.reader->counters();
        ASSERT_EQ(counters.received, model.received) << "step " << step;
        ASSERT_EQ(counters.overwritten, model.overwritten) << "step " << step;
        ASSERT_EQ(model.reader->has_waiting(), !model.queue.empty()) << "step " << step;
      }
      while (held.size() > 6) {
        const auto at = held.begin() + static_cast<int>(pick(held.size()));
        drop_reference(**at);
        held.erase(at);
      }
    }
    for (Block* block : held) drop_reference(*block);
  }
}

TEST(BrokerModel, readers_that_come_and_go_while_others_write_see_every_writer_in_order_and_no_message_twice) {
  constexpr int kWriters = 2, kReaders = 2, kLives = 15;
  const SystemClock clock;
  Broker broker{clock};
  std::vector<std::unique_ptr<Writer>> writers;
  writers.reserve(kWriters);
  for (int i = 0; i < kWriters; ++i) writers.push_back(broker.create_writer(spec(QoS(KeepAll{}).max_samples(100000))));
  std::atomic<int> reading{kReaders};
  std::vector<std::thread> threads;
  threads.reserve(kWriters + kReaders);
  for (const auto& writer : writers) {
    threads.emplace_back([&, w = writer.get()] {
      for (int i = 1; reading > 0; ++i) {
        publish(*w, std::to_string(i));
        if (i % 8 == 0) std::this_thread::yield();
      }
    });
  }
  std::atomic<std::uint64_t> wrong{0}, seen{0};
  for (unsigned seed = 1; seed <= kReaders; ++seed) {
    threads.emplace_back([&, seed] {
      std::mt19937 random{seed};
      for (int life = 0; life < kLives; ++life) {
        const auto reader = broker.create_reader(spec(QoS(KeepAll{}).max_samples(100000)),
                                                 random() % 2 == 0 ? Taking::Own : Taking::Share, nullptr);
        std::map<std::uint64_t, std::uint64_t> last;
        for (unsigned n = 1 + random() % 200; n > 0;) {
          Block* const block = reader->take();
          if (block == nullptr) continue;
          // The held message was not released by others: its text is that of its number.
          const auto& info = block->info;
          if (static_cast<const String*>(block->message)->data != std::to_string(info.sequence)) ++wrong;
          if (last.count(info.writer_id) != 0 && info.sequence != last[info.writer_id] + 1) ++wrong;
          last[info.writer_id] = info.sequence;
          drop_reference(*block);
          ++seen;
          --n;
        }
        if (reader->counters().full != 0) ++wrong;  // then the gaps would say nothing
      }
      --reading;
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(seen, static_cast<std::uint64_t>(kReaders * kLives));
  writers.clear();
  EXPECT_EQ(broker.sweep({"/node"}), "") << "every message has come home";
}

}  // namespace
}  // namespace nacelle::runtime
