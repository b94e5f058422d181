// SPDX-License-Identifier: Apache-2.0
// Callback groups, waits, threads and their reports as a component and an operator meet them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <future>

#include "container_fixture.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/allocation_guard.hpp"
#include "support/places.hpp"

namespace nacelle::runtime {
namespace {

using ::testing::HasSubstr;

struct CallbacksTest : ::testing::Test {
  SystemClock clock;
  Container container{{.name = "test", .component_path = {test::component_folder()}}, clock};
  std::vector<std::unique_ptr<Writer>> mouths;

  std::uint64_t bring_up(const std::string& plugin, const ThreadPolicy& thread, std::int64_t limit_ms = 20000) {
    LoadRequest request;
    request.plugin = "nacelle::test::" + plugin;
    request.thread = thread;
    if (plugin == "Juggler") request.parameters["limit_ms"] = limit_ms;
    const auto loaded = container.load(request);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().text());
    const auto id = loaded.value().id;
    EXPECT_EQ(container.trigger(id, Transition::Configure).reason, "");
    EXPECT_EQ(container.trigger(id, Transition::Activate).reason, "");
    return id;
  }
  void say(const std::string& topic, const std::string& text) {
    mouths.push_back(
        container.transport().create_writer({topic, &String::message_type(), QoS(10).transient_local(), "/mouth"}));
    Block* const block = mouths.back()->borrow();
    static_cast<String*>(block->message)->data = text;
    mouths.back()->publish(*block);
  }
  const CallbackReport* find(const std::vector<CallbackReport>& all, const std::string& kind, const std::string& name) {
    const auto found = std::ranges::find_if(all, [&](const auto& row) { return row.kind == kind && row.name == name; });
    return found == all.end() ? nullptr : &*found;
  }
};

const ThreadPolicy kThreeThreads{.own = true, .priority = 0, .cpus = {}, .threads = 3};

TEST_F(CallbacksTest, a_reentrant_group_overlaps_on_several_threads) {
  Ear said(container, "/said");
  bring_up("Juggler", kThreeThreads);
  say("/left", "");
  say("/right", "");
  EXPECT_EQ(said.next(), "met");
  EXPECT_EQ(said.next(), "met");
}

TEST_F(CallbacksTest, a_reentrant_group_does_not_overlap_on_the_shared_executor_even_if_a_callback_is_late) {
  Ear said(container, "/said");
  bring_up("Juggler", {}, 60);  // longer than handover_after
  say("/left", "");
  say("/right", "");
  EXPECT_EQ(said.next(), "was alone");
}

TEST_F(CallbacksTest, a_callback_may_wait_for_another_group_if_there_are_threads_for_both) {
  Ear said(container, "/said");
  bring_up("Juggler", kThreeThreads);
  say("/ask", "other group");
  EXPECT_EQ(said.next(), "answered");
}

TEST_F(CallbacksTest, a_wait_on_the_own_executor_is_an_error_with_a_fix_and_no_deadlock) {
  Ear said(container, "/said");
  const auto id = bring_up("Juggler", kThreeThreads);
  say("/ask", "own group");
  EXPECT_EQ(
      said.next(),
      "service /answer: a callback of /juggler would wait for itself: callbacks of one mutually exclusive group run "
      "one at a time; do not wait in a callback, or wait in a thread of your own");
  ASSERT_TRUE(container.unload(id));
  Ear again(container, "/said", QoS(10));
  bring_up("Juggler", {});
  say("/ask", "other group");
  EXPECT_THAT(again.next(), HasSubstr("executor 'executor' has one thread"));
}

TEST_F(CallbacksTest, a_transition_asked_for_where_it_would_wait_for_itself_is_refused) {
  const auto listener = bring_up("Listener", {});
  std::promise<std::pair<TransitionOutcome, Result<UnloadOutcome, Problem>>> told;
  container.on_fault([&](const ComponentInfo& info) {  // on the executor, while the component is cleaned up
    told.set_value({container.trigger(info.id, Transition::Configure), container.unload(info.id)});
  });
  say("/words", "fault");
  const auto [outcome, unloaded] = told.get_future().get();
  EXPECT_FALSE(outcome.success);
  EXPECT_THAT(outcome.reason, HasSubstr("a callback of /listener would wait for itself"));
  ASSERT_FALSE(unloaded);
  EXPECT_THAT(unloaded.error().text(), HasSubstr("a callback of /listener would wait for itself"));
  EXPECT_TRUE(container.trigger(listener, Transition::Configure).success) << "from here it goes on";
}

TEST_F(CallbacksTest, every_callback_thread_and_component_is_accounted_for) {
  Ear said(container, "/said");
  bring_up("Juggler", kThreeThreads);
  bring_up("Talker", {});
  say("/ask", "other group");
  ASSERT_EQ(said.next(), "answered");

  std::vector<CallbackReport> callbacks;
  std::vector<ThreadReport> threads;
  std::vector<LoadReport> loads;
  const auto deadline = clock.now() + 20s;
  const CallbackReport* ticks = nullptr;
  do {
    container.report_callbacks(callbacks);
    ticks = find(callbacks, "timer", "1 ms");
    ASSERT_NE(ticks, nullptr);
  } while (ticks->count < 200 && clock.now() < deadline);
  const auto* ask = find(callbacks, "subscription", "/ask");
  const auto* answer = find(callbacks, "service", "/answer");
  const auto* client = find(callbacks, "client", "/answer");
  ASSERT_TRUE(ask != nullptr && answer != nullptr && client != nullptr);
  for (const CallbackReport* row : {ticks, ask, answer, client}) {
    EXPECT_EQ(row->node, "/juggler");
    EXPECT_GT(row->duration_total, 0ns) << row->kind;
    EXPECT_LE(row->duration_total, row->duration_max * static_cast<Duration::rep>(row->count)) << row->kind;
    EXPECT_GE(row->count, 1U) << row->kind;
    EXPECT_GT(row->duration_max, 0ns) << row->kind;
    EXPECT_GE(row->duration_max, row->duration_p99) << row->kind;
  }
  EXPECT_GT(ticks->latency_max, 0ns);
  EXPECT_GE(ticks->latency_max, ticks->latency_p99);
  // Not until the answer's callback returned: that may lose its core once it has answered.
  EXPECT_GE(ask->duration_max, answer->latency_max) << "it waited for it";

  container.report_threads(threads);
  EXPECT_EQ(std::ranges::count(threads, "own", &ThreadReport::executor), 3);
  EXPECT_EQ(std::ranges::count(threads, "executor", &ThreadReport::executor), 2) << "one serves, one is a spare";
  container.report_loads(loads);
  ASSERT_EQ(loads.size(), 2U);
  EXPECT_EQ(loads[0].node, "/juggler");
  EXPECT_GE(loads[0].callbacks, 100U);
  EXPECT_GE(loads[0].samples, 2U);
  EXPECT_GT(loads[0].cpu, 0ns);
  EXPECT_TRUE(loads[0].own_threads);
  EXPECT_GT(loads[0].thread_cpu, 0ns);
  EXPECT_EQ(loads[1].executor, "executor");
  EXPECT_FALSE(loads[1].own_threads);
  EXPECT_EQ(loads[1].thread_cpu, 0ns) << "what its neighbours use is not its own";

  std::vector<ReaderReport> readers;
  container.report_readers(readers);
  const auto asked = std::ranges::find(readers, "/ask", &ReaderReport::topic);
  ASSERT_NE(asked, readers.end());
  EXPECT_EQ(asked->node, "/juggler");
  EXPECT_EQ(asked->delivered, 1U);
  EXPECT_EQ(asked->waiting, 0U);
  EXPECT_GT(asked->depth, 0U);
  EXPECT_TRUE(asked->open);

  const test::AllocationGuard guard;
  container.report_callbacks(callbacks);
  container.report_threads(threads);
  container.report_loads(loads);
  container.report_readers(readers);
  EXPECT_EQ(guard.count(), 0U) << "asking again allocates nothing";
}

TEST_F(CallbacksTest, a_component_runs_on_the_thread_that_its_launch_entry_asks_for) {
  LoadRequest request;
  request.plugin = "nacelle::test::Talker";
  request.name = "tick_tock";
  request.thread = {.own = true, .priority = 0, .cpus = {0}, .threads = 1};
  ASSERT_TRUE(container.load(request));
  std::vector<ThreadReport> threads;
  const auto deadline = clock.now() + 20s;
  while (threads.empty() && clock.now() < deadline) container.report_threads(threads);
  ASSERT_EQ(threads.size(), 1U) << "no spare thread: the component is alone";
  const std::string folder = "/proc/self/task/" + std::to_string(threads[0].thread_id);
  std::string name, line, cpus;
  std::getline(std::ifstream(folder + "/comm") >> std::ws, name);
  std::ifstream status(folder + "/status");
  while (std::getline(status, line)) {
    if (line.rfind("Cpus_allowed_list:", 0) == 0) cpus = line.substr(line.find_last_of(" \t") + 1);
  }
  EXPECT_EQ(name, "tick_tock");
  EXPECT_EQ(cpus, "0");
}

}  // namespace
}  // namespace nacelle::runtime
