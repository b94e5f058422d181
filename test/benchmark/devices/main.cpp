// SPDX-License-Identifier: Apache-2.0
// devices what=ld06 [messages=6000] [assembles=0] | what=jpeg [blocks=40] | what=loop [messages=1000] [compares=0]
#include <cstdio>

#include "devices/device_runs.hpp"
#include "support/arguments.hpp"

int main(int count, char** words) {
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  const std::string what = arguments.text("what", "ld06");
  if (what == "ld06") {
    run_ld06(arguments.number("messages", 6000), arguments.number("assembles", 0) != 0);
  } else if (what == "jpeg") {
    run_jpeg(arguments.number("blocks", 40));
  } else if (what == "loop") {
    run_drive_loop(arguments.number("messages", 1000), arguments.number("compares", 0) != 0);
  } else {
    std::fprintf(stderr, "what=%s: use ld06, jpeg or loop\n", what.c_str());
    return 2;
  }
  return 0;
}
