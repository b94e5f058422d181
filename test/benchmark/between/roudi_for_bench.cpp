// SPDX-License-Identifier: Apache-2.0
// roudi_for_bench: runs iceoryx's daemon until its standard input ends. Prints "ready", or why there is none (exit code 3).
#include <cstdio>

#include "support/roudi.hpp"

int main() {
  std::string why_not;
  const auto daemon =
      nacelle::test::RouDi::start({{256, 1024}, {66'560, 64}, {1'052'672, 32}, {4'198'400, 24}}, why_not);
  if (!daemon) return std::puts(why_not.c_str()), 3;
  std::puts("ready");
  std::fflush(stdout);
  while (std::getchar() != EOF) {}
  return 0;
}
