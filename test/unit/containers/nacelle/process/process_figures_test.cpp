// SPDX-License-Identifier: Apache-2.0
#include "process/process_figures.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <cstdlib>
#include <memory>
#include <semaphore>
#include <thread>

namespace nacelle::process {
namespace {

TEST(StatLine, is_read_whatever_the_program_is_called) {
  // The name holds blanks and parentheses; the numbers are those of proc_pid_stat(5), field 3 onwards.
  const auto line = parse_stat_line("42 (a ) (b) R 1 2 3 4 5 6 7 8 9 10 111 222 13 14 15 16 17 18 333 20 21\n");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->user_ticks, 111U);
  EXPECT_EQ(line->system_ticks, 222U);
  EXPECT_EQ(line->threads, 17U);
  EXPECT_EQ(line->start_ticks, 333U - 0U);
}

TEST(StatLine, of_another_form_is_nothing) {
  for (const char* const text :
       {"", "42", "42 (a", "42 (a)", "42 (a) R 1 2 3", "42 (a) R x x x x x x x x x x x x x x x x x x x x x"}) {
    EXPECT_FALSE(parse_stat_line(text)) << text;
  }
}

TEST(ProcessFigures, this_process_has_memory_a_past_and_a_thread) {
  EXPECT_GT(resident_bytes(), 100'000U);
  EXPECT_GE(time_since_process_start(), 0s);
  EXPECT_LT(time_since_process_start(), 1h);
  EXPECT_GE(living_threads().size(), 1U);
}

AllocationSnapshot snapshot(std::initializer_list<ThreadAllocations> threads) {
  AllocationSnapshot made{};
  for (const auto& thread : threads) made.threads[made.count++] = thread;
  return made;
}

TEST(AllocationRates, threads_of_one_name_add_up_and_a_quiet_one_is_there_with_zero) {
  const auto rates = allocation_rates(snapshot({{1, 100}, {2, 50}}), snapshot({{1, 120}, {2, 60}, {4, 7}}),
                                      {{1, "a"}, {2, "a"}, {3, "quiet"}, {4, "new"}}, 10.0);
  EXPECT_EQ(rates, (std::map<std::string, double>{{"a", 3.0}, {"quiet", 0.0}, {"new", 0.7}}));
}

TEST(AllocationRates, a_thread_that_ended_is_not_forgotten) {
  const auto rates = allocation_rates(snapshot({{9, 10}}), snapshot({{9, 30}, {9, 10}}), {}, 10.0);
  EXPECT_EQ(rates, (std::map<std::string, double>{{"(ended)", 3.0}}));
}

TEST(AllocationRates, no_time_is_no_rate) { EXPECT_TRUE(allocation_rates({}, {}, {{1, "a"}}, 0).empty()); }

TEST(AllocationCounter, counts_each_call_on_the_thread_that_made_it) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "a sanitizer owns the allocator";
#endif
  ASSERT_TRUE(allocations_are_counted());
  std::binary_semaphore begin{0}, done{0}, end{0};
  std::thread worker{[&] {
    ::pthread_setname_np(::pthread_self(), "counted");
    std::free(std::malloc(1));  // takes its slot
    done.release();
    begin.acquire();
    void* volatile memory = std::malloc(100);
    memory = std::realloc(memory, 200);
    std::free(memory);
    memory = std::calloc(3, 5);
    std::free(memory);
    memory = std::aligned_alloc(64, 128);
    std::free(memory);
    void* aligned = nullptr;
    EXPECT_EQ(::posix_memalign(&aligned, 64, 100), 0);
    std::free(aligned);
    int* volatile number = new int{7};
    delete number;
    done.release();
    end.acquire();
  }};
  done.acquire();
  AllocationSnapshot before, after;
  take_snapshot(before);
  begin.release();
  done.acquire();
  take_snapshot(after);
  const auto rates = allocation_rates(before, after, living_threads(), 1.0);
  end.release();
  worker.join();
  EXPECT_EQ(rates.at("counted"), 6.0);
}

TEST(SteadyState, is_measured_from_begin_to_end) {
  SteadyState steady;
  EXPECT_FALSE(steady.has_begun());
  steady.begin(MonotonicTime{10s});
  for (int i = 0; i < 50; ++i) std::make_unique<std::string>(1000, 'x');
  const ProcessFigures figures = steady.end(MonotonicTime{15s});
  ASSERT_TRUE(figures.cpu_percent);
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "a sanitizer owns the allocator";
#endif
  ASSERT_TRUE(allocations_are_counted());
  double most = 0;
  for (const auto& [name, rate] : figures.allocations_per_second) most = std::max(most, rate);
  EXPECT_GE(most, 10.0);
}

TEST(SteadyState, that_never_began_or_was_too_short_has_neither_cpu_nor_allocations) {
  SteadyState steady;
  for (const bool begins : {false, true}) {
    if (begins) steady.begin(MonotonicTime{10s});
    const ProcessFigures figures = steady.end(MonotonicTime{10s} + kShortestMeasure - 1ms);
    EXPECT_FALSE(figures.cpu_percent) << begins;
    EXPECT_TRUE(figures.allocations_per_second.empty()) << begins;
    EXPECT_GT(figures.rss_mb, 0) << begins;
  }
}

}  // namespace
}  // namespace nacelle::process
