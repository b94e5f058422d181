// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::bench {

// What drivers cost apart from the devices: each prints its figures.

/// Feeds `packets` packets of an LD06, as reads of a serial line cut them, to its decoder, and with `assembles` to what makes scans of them, too.
void run_ld06(std::uint64_t packets, bool assembles);
/// Decodes a picture of 1280 x 720 in `blocks` blocks, in turn with libjpeg's own loop.
void run_jpeg(std::uint64_t blocks);
/// Runs the base's control loop for `cycles` cycles of 1 ms with wheels that turn as commanded; with `compares` in blocks of a second, in turn
/// with a thread that only sleeps until the next millisecond.
void run_drive_loop(std::uint64_t cycles, bool compares);

}  // namespace nacelle::bench
