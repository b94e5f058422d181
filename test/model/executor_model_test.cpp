// SPDX-License-Identifier: Apache-2.0
// The executor's real code under simulated threads: thousands of seeded interleavings of threads that post, fire,
// close, forget, overstays and watches. What must hold is in docs/wake_up.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <mutex>
#include <set>

#include "nacelle/runtime/executor.hpp"
#include "reader_queue.hpp"
#include "scheduler.hpp"

namespace nacelle::runtime {
namespace {

using model::Scheduler;

// What a node's callbacks do to each other.
struct NodeModel {
  NodeModel(Executor& executor, const std::string& name) : groups(executor, name, [](const auto&...) {}) {}
  NodeGroups groups;
  std::vector<std::unique_ptr<CallbackGroup>> parts;
  int inside = 0;
  bool alone = false, closed = false;
};

struct World {
  explicit World(unsigned seed) : scheduler(seed) {
    ThreadPolicy policy;
    policy.own = scheduler.choose(2) == 0;
    policy.threads = 1 + scheduler.choose(3);
    executor = std::make_unique<Executor>("model", scheduler, policy);
    serving = policy.own ? policy.threads : 1;
  }
  void fail(const std::string& what) { problems.insert(what); }

  Scheduler scheduler;
  std::unique_ptr<Executor> executor;
  unsigned serving = 1;
  std::set<std::string> problems;
};

// Watches what runs beside it.
class Presence {
 public:
  Presence(World& world, NodeModel& node, int& in_group, bool exclusive) : node_(node), in_group_(in_group) {
    if (node.alone) world.fail("a callback ran beside a transition of its node");
    if (node.closed) world.fail("a callback started after its node was closed");
    if (world.serving == 1 && node.inside != 0) world.fail("two callbacks of a node overlapped on one thread");
    if (exclusive && in_group != 0) world.fail("two callbacks of a mutually exclusive group overlapped");
    ++node_.inside;
    ++in_group_;
  }
  ~Presence() {
    --node_.inside;
    --in_group_;
  }

 private:
  NodeModel& node_;
  int& in_group_;
};

// A message with a number in it.
struct Note final : Block, private BlockHome {
  explicit Note(int number) : value(number) { home = this; }
  void reclaim(Block&) noexcept override { delete this; }
  const int value;
};

// A subscription, whose queue is the real one under the executor's lock; or, as services have it, a queue with a lock
// of its own that reports what is ready: rule 2 of docs/wake_up.md.
class Stream final : public Executable {
 public:
  Stream(World& world, NodeModel& node, CallbackGroup& group, int& in_group)
      : Executable(group),
        world_(world),
        node_(node),
        in_group_(in_group),
        tells_late_(world.scheduler.choose(2) == 0) {
    if (world.scheduler.choose(2) == 0) return;
    EndpointSpec spec;
    spec.qos = QoS(KeepAll());
    if (world.scheduler.choose(4) == 0) spec.qos.lifespan(1h);  // such messages are taken by a closer look
    lifespan_ = spec.qos.lifespan() != Duration::zero();
    feed_ = std::make_shared<ReaderQueue>(spec, Taking::Share, *this, world.scheduler, nullptr, 1);
  }
  ~Stream() override { gone = true; }

  void push(int value) {
    if (feed_) {
      auto* const note = new Note(value);
      if (lifespan_) note->expires = world_.scheduler.now() + 1h;
      give(*note);
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return;
      queue_.push_back(value);
      waiting_ = queue_.size();
      ++pushed;
      if (!tells_late_) on_ready();
    }
    if (tells_late_ && !closed_) on_ready();
  }
  void close() {
    if (feed_) {
      feed_->close();
      pushed -= feed_->counters().discarded;
      return;
    }
    const std::lock_guard lock(mutex_);
    closed_ = true;
    pushed -= queue_.size();
    queue_.clear();
    waiting_ = 0;
  }
  std::vector<int> delivered;
  std::size_t pushed = 0;
  bool forgotten = false, gone = false;
  std::vector<Stream*> next;  // where a callback publishes to

 private:
  void execute(MonotonicTime) override {
    if (feed_) {
      Block* const block = feed_->take();
      if (block == nullptr) return;
      if (group().type() == CallbackGroupType::Reentrant && feed_->has_waiting()) on_ready();
      return execute_with(*block, {});
    }
    int value = 0;
    {
      const std::lock_guard lock(mutex_);
      if (queue_.empty()) return;
      value = queue_.front();
      queue_.pop_front();
      waiting_ = queue_.size();
    }
    hear(value);
  }
  void execute_with(Block& block, MonotonicTime) override {
    const int value = static_cast<Note&>(block).value;
    drop_reference(block);
    hear(value);
  }
  void hear(int value) {
    if (forgotten || gone) world_.fail("a callback ran after it was forgotten");
    const Presence here(world_, node_, in_group_, group().type() == CallbackGroupType::MutuallyExclusive);
    delivered.push_back(value);
    world_.scheduler.step();
    if (world_.scheduler.choose(8) == 0) world_.scheduler.sleep(Duration{world_.scheduler.choose(100'000)});
    for (Stream* other : next) other->push(value);
  }
  bool wants_again() const override { return waiting_ != 0; }
  // As a writer does: quickly under the lock if that goes, else with all that belongs to it.
  void give(Note& note) {
    const std::atomic<std::uint32_t>* called = nullptr;
    feed_->mutex().lock();
    const bool quick = world_.scheduler.choose(4) != 0 && feed_->push_quickly(note, called);
    if (quick) ++pushed;
    feed_->mutex().unlock();
    if (called != nullptr) futex_wake(*called, 1);
    if (!quick && feed_->push(note) == ReaderQueue::Push::Queued) ++pushed;
  }

  World& world_;
  NodeModel& node_;
  int& in_group_;
  const bool tells_late_;  // after the lock, which is allowed too
  bool lifespan_ = false;
  std::shared_ptr<ReaderQueue> feed_;
  FutexMutex mutex_;
  std::deque<int> queue_;
  std::atomic<std::size_t> waiting_{0};
  bool closed_ = false;
};

class Beat final : public TimerBase {
 public:
  Beat(World& world, NodeModel& node, CallbackGroup& group, int& in_group, Duration period)
      : TimerBase(group, period),
        world_(world),
        node_(node),
        in_group_(in_group),
        period_(period),
        start_(world.scheduler.now()) {}
  int ticks = 0;

 private:
  void execute(MonotonicTime) override {
    const Presence here(world_, node_, in_group_, group().type() == CallbackGroupType::MutuallyExclusive);
    world_.scheduler.step();
    if (world_.scheduler.now() < start_ + period_ * ++ticks) world_.fail("a timer fired early");
  }
  World& world_;
  NodeModel& node_;
  int& in_group_;
  const Duration period_;
  const MonotonicTime start_;
};

class TransitionTask final : public Executable {
 public:
  TransitionTask(World& world, NodeModel& node)
      : Executable(*node.parts.front(), Kind::Transition), world_(world), node_(node) {}
  bool done = false;

 private:
  void execute(MonotonicTime) override {
    if (node_.inside != 0) world_.fail("a transition ran beside a callback of its node");
    node_.alone = true;
    world_.scheduler.step();
    if (world_.scheduler.choose(2) == 0) world_.scheduler.sleep(Duration{world_.scheduler.choose(50'000)});
    if (node_.inside != 0) world_.fail("a callback started beside a transition of its node");
    node_.alone = false;
    done = true;
  }
  void discard() noexcept override { done = true; }
  World& world_;
  NodeModel& node_;
};

// True when it has become so within a second of simulated time, in which everything else happens many times.
template <typename Condition>
bool comes(World& world, Condition condition) {
  for (int i = 0; i < 200; ++i) {
    if (condition()) return true;
    world.scheduler.sleep(5ms);
  }
  return condition();
}

struct Part {
  NodeModel* node;
  CallbackGroup* group;
  int inside = 0;
};

std::set<std::string> run(unsigned seed) {
  World world(seed);
  Scheduler& scheduler = world.scheduler;
  Executor& executor = *world.executor;
  std::vector<std::unique_ptr<NodeModel>> nodes;
  std::deque<Part> parts;
  for (unsigned n = 0; n <= scheduler.choose(3); ++n) {
    nodes.push_back(std::make_unique<NodeModel>(executor, "/node" + std::to_string(n)));
    for (unsigned g = 0; g <= scheduler.choose(2); ++g) {
      nodes.back()->parts.push_back(std::make_unique<CallbackGroup>(
          nodes.back()->groups,
          scheduler.choose(3) == 0 ? CallbackGroupType::Reentrant : CallbackGroupType::MutuallyExclusive));
      parts.push_back({nodes.back().get(), nodes.back()->parts.back().get()});
    }
  }
  std::vector<std::unique_ptr<Stream>> streams;
  for (unsigned s = 0; s <= scheduler.choose(4); ++s) {
    Part& part = parts[scheduler.choose(static_cast<unsigned>(parts.size()))];
    streams.push_back(std::make_unique<Stream>(world, *part.node, *part.group, part.inside));
    // Publishes onwards, never back, so that every chain of messages ends.
    if (s > 0 && scheduler.choose(2) == 0) streams[s]->next.push_back(streams[scheduler.choose(s)].get());
  }
  std::vector<std::unique_ptr<Beat>> beats;
  for (unsigned t = 0; t < scheduler.choose(3); ++t) {
    Part& part = parts[scheduler.choose(static_cast<unsigned>(parts.size()))];
    beats.push_back(std::make_unique<Beat>(world, *part.node, *part.group, part.inside,
                                           Duration{20'000 + scheduler.choose(100'000)}));
  }
  for (const auto& node : nodes) executor.open(node->groups);
  std::vector<model::Thread> threads;
  for (unsigned p = 0; p <= scheduler.choose(3); ++p) {
    threads.emplace_back([&, n = 1 + scheduler.choose(6)] {
      for (unsigned i = 0; i < n; ++i) {
        streams[scheduler.choose(static_cast<unsigned>(streams.size()))]->push(static_cast<int>(i));
        if (scheduler.choose(4) == 0) scheduler.sleep(Duration{scheduler.choose(60'000)});
      }
    });
  }
  bool watching = true;
  threads.emplace_back([&] {  // the supervisor
    while (watching) {
      static_cast<void>(executor.supervise({20us, 1h}));
      scheduler.sleep(Duration{1'000 + scheduler.choose(30'000)});
    }
  });
  std::vector<std::unique_ptr<TransitionTask>> transitions;
  transitions.reserve(nodes.size());
  for (const auto& node : nodes) transitions.push_back(std::make_unique<TransitionTask>(world, *node));
  threads.emplace_back([&] {
    for (const auto& transition : transitions) {
      if (scheduler.choose(2) == 0) scheduler.sleep(Duration{scheduler.choose(100'000)});
      executor.post(*transition);
    }
    for (const auto& beat : beats) executor.add_timer(*beat);
  });
  // One stream is taken out, and one node, while all of this goes on.
  Stream& leaving = *streams[scheduler.choose(static_cast<unsigned>(streams.size()))];
  NodeModel& closing = *nodes.back();
  const bool forgets = scheduler.choose(2) == 0, closes = nodes.size() > 1 && scheduler.choose(2) == 0;
  threads.emplace_back([&] {
    if (forgets) {
      leaving.close();
      executor.forget(leaving);
      leaving.forgotten = true;
    }
    if (closes) {
      const bool quiet = executor.close(closing.groups, scheduler.now() + 1s);
      closing.closed = true;
      if (!quiet || closing.inside != 0) world.fail("close() returned while a callback ran");
    }
  });

  const auto all_delivered = [&] {
    return std::ranges::all_of(streams, [&](const auto& stream) {
      return stream->forgotten || (closes && &stream->group().node() == &closing.groups) ||
             stream->delivered.size() == stream->pushed;
    });
  };
  for (std::size_t i = 0; i < threads.size(); ++i) {
    if (i + 3 != threads.size()) threads[i].join();  // the supervisor stays
  }
  if (!comes(world, all_delivered)) world.fail("a message waits and every thread sleeps");
  for (const auto& transition : transitions) {
    const bool closed = closes && &transition->group().node() == &closing.groups;
    if (!comes(world, [&] { return transition->done || closed; }))
      world.fail("a transition waits and every thread sleeps");
  }
  for (const auto& beat : beats) {
    if (closes && &beat->group().node() == &closing.groups) continue;
    const int before = beat->ticks;
    if (!comes(world, [&] { return beat->ticks >= before + 2; })) world.fail("a timer is due and every thread sleeps");
  }
  watching = false;
  threads[threads.size() - 3].join();
  for (const auto& beat : beats) {
    executor.cancel_timer(*beat);
    executor.forget(*beat);
  }
  for (const auto& stream : streams) executor.forget(*stream);
  for (const auto& transition : transitions) executor.forget(*transition);
  if (!comes(world, [&] { return executor.is_idle(); })) world.fail("it does not come to rest");
  std::vector<ThreadReport> states;
  std::size_t used = 0;
  executor.report_threads(states, used);
  const auto serving =
      std::ranges::count_if(states, [](const auto& row) { return std::string(row.state) == "serving"; });
  if (serving != world.serving)
    world.fail("as many threads serve as the policy says, but for " + std::to_string(serving));
  nodes.clear();
  world.executor.reset();
  return world.problems;
}

// Passes only when both of two callbacks are inside.
class Both final : public Executable {
 public:
  Both(World& world, CallbackGroup& group, int& inside) : Executable(group), world_(world), inside_(inside) {}

 private:
  void execute(MonotonicTime) override {
    ++inside_;
    if (!comes(world_, [&] { return inside_ == 2; })) world_.fail("something is ready, and a thread sleeps");
  }
  World& world_;
  int& inside_;
};

TEST(ExecutorModel, as_many_run_as_there_are_threads) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    World world(seed);
    world.executor = std::make_unique<Executor>("model", world.scheduler,
                                                ThreadPolicy{.own = true, .priority = 0, .cpus = {}, .threads = 2});
    NodeModel node(*world.executor, "/node");
    CallbackGroup first(node.groups), second(node.groups);
    world.executor->open(node.groups);
    int inside = 0;
    Both one(world, first, inside), two(world, second, inside);
    if (world.scheduler.choose(2) == 0) world.scheduler.sleep(1ms);  // both threads sleep by now
    model::Thread poster([&] { world.executor->post(one); });
    world.executor->post(two);
    poster.join();
    for (Both* both : {&one, &two}) {
      static_cast<void>(comes(world, [&] { return inside == 2; }));
      world.executor->forget(*both);
    }
    for (const auto& problem : world.problems) ADD_FAILURE() << "seed " << seed << ": " << problem;
    if (HasFailure()) break;
  }
}

TEST(ExecutorModel, holds_its_promises_in_thousands_of_interleavings) {
#ifdef NACELLE_SANITIZED
  constexpr unsigned kRuns = 200;  // looks for invalid memory accesses; the plain build looks for wrong orders
#else
  constexpr unsigned kRuns = 1500;
#endif
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    for (const auto& problem : run(seed)) ADD_FAILURE() << "seed " << seed << ": " << problem;
    if (HasFailure()) break;
  }
}

}  // namespace
}  // namespace nacelle::runtime
