// SPDX-License-Identifier: Apache-2.0
// handover path=inline|asleep|busy [take=const_ref|shared|loan] [readers=1] [owners=0] [bytes=0] [messages=1000] [step=0]
// Sends messages through a real container and prints what they have cost.
#include <cstdio>

#include "handover/plan.hpp"
#include "support/arguments.hpp"
#include "support/step_counter.hpp"

int main(int count, char** words) {
  using namespace nacelle;
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  Plan plan;
  plan.take = arguments.text("take", "const_ref");
  plan.readers = arguments.number("readers", 1);
  plan.owners = arguments.number("owners", 0);
  plan.bytes = arguments.number("bytes", 0);
  plan.messages = arguments.number("messages", 1000);
  plan.warm = arguments.number("warm", plan.warm);
  const std::string path = arguments.text("path", "inline");
  if (arguments.number("step", 0) != 0) {
    const Steps steps = count_steps([&] { static_cast<void>(run_inline(plan, std::chrono::seconds(20))); });
    if (!steps.ok) return std::fputs("handover: a thread cannot be single-stepped here (ptrace)\n", stderr), 1;
    print_figures({{"instructions", static_cast<double>(steps.instructions)},
                   {"locked", static_cast<double>(steps.locked)},
                   {"syscalls", static_cast<double>(steps.syscalls)},
                   {"clock_reads", static_cast<double>(steps.clock_reads)}});
    return 0;
  }
  // The pool's first filling with large messages takes as long as the page faults of all of them.
  const Outcome outcome = path == "asleep" ? run_asleep(plan)
                          : path == "busy" ? run_busy(plan)
                                           : run_inline(plan, plan.bytes > 1'000'000 ? Duration{20s} : Duration{});
  const auto figure = [](auto value) { return static_cast<double>(value); };
  print_figures({{"delivered", figure(outcome.delivered)},
                 {"mallocs", figure(outcome.used.mallocs)},
                 {"faults", figure(outcome.used.faults)},
                 {"switches", figure(outcome.used.switches)},
                 {"copies", figure(outcome.written.copies)},
                 {"bytes_copied", figure(outcome.written.bytes_copied)},
                 {"ns", figure(outcome.used.at.nanoseconds())}});
  return 0;
}
