// SPDX-License-Identifier: Apache-2.0
// ratios what=sizes|wake [blocks=40] [small=64] [large=4000000] [first_cpu=0] [second_cpu=1]
// Times that mean something on a noisy machine: two sides in turn in one process, and the ratio of their medians.
#include "ratios/ratio.hpp"
#include "support/arguments.hpp"

int main(int count, char** words) {
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  const std::uint64_t blocks = arguments.number("blocks", 40);
  const Ratio ratio = arguments.text("what", "sizes") == "wake"
                          ? compare_wake(static_cast<int>(arguments.number("first_cpu", 0)),
                                         static_cast<int>(arguments.number("second_cpu", 1)), blocks)
                          : compare_sizes(arguments.number("small", 64), arguments.number("large", 4'000'000), blocks);
  print_figures({{"a_ns", ratio.a_ns}, {"b_ns", ratio.b_ns}, {"ratio", ratio.value()}});
  return 0;
}
