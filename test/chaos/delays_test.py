#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The library of delays: it delays, it changes no result, and it refuses settings that it cannot read."""
import os
import subprocess
import sys
import time
import unittest

LIBRARY = sys.argv.pop()
READS = "import os\nf = os.open('/dev/zero', os.O_RDONLY)\nprint(sum(len(os.read(f, 3)) for _ in range(300)))"


def run(settings):
    begin = time.monotonic()
    done = subprocess.run(
        ["/usr/bin/python3", "-I", "-S", "-c", READS], capture_output=True, text=True, check=False,
        env=os.environ | {"LD_PRELOAD": LIBRARY, "NACELLE_CHAOS": settings},
    )  # fmt: skip
    return done, time.monotonic() - begin


class Delays(unittest.TestCase):
    def test_delays_calls_and_keeps_results(self):
        done, seconds = run("7,1,1000")
        self.assertEqual((done.returncode, done.stdout), (0, "900\n"), done.stderr)
        self.assertGreater(seconds, 0.05, "300 reads, each delayed by 0.5 ms on average")

    def test_refuses_settings_that_it_cannot_read(self):
        for settings in ("x", "1,0"):
            done, _ = run(settings)
            self.assertEqual(done.returncode, 2, settings)
            self.assertIn(settings, done.stderr)


if __name__ == "__main__":
    unittest.main()
