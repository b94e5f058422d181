#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The test of check_floors.py: plants each forbidden arrow in a small tree and expects exactly that complaint."""
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from check_floors import Floors  # noqa: E402

TABLE = (Path(__file__).parents[2] / "docs/floors.md").read_text(encoding="utf-8")

# A tree in which every arrow is allowed: path -> text.
SOUND = {
    "interfaces/base/include/nacelle/base/time.hpp": "#include <chrono>\n",
    "interfaces/host/include/nacelle/host/transport.hpp": '#include "nacelle/qos/qos.hpp"\n',
    "interfaces/node/include/nacelle/node/node.hpp": '#include "nacelle/host/transport.hpp"\n#include "nacelle/qos/qos.hpp"\n',
    "qos_profiles/include/nacelle/qos/qos.hpp": '#include "nacelle/base/time.hpp"\n',
    "components/io/include/nacelle/io/stream.hpp": '#include "nacelle/base/time.hpp"\n#include <unistd.h>\n',
    "components/lidar/protocol/decoder.hpp": '#include "nacelle/base/time.hpp"\n#include <vector>\n',
    "components/lidar/port/serial.hpp": '#include "nacelle/io/stream.hpp"\n#include <fcntl.h>\n',
    "components/lidar/component/lidar.cpp": '#include "lidar/protocol/decoder.hpp"\n#include "lidar/port/serial.hpp"\n'
    '#include "nacelle/node/node.hpp"\n#include <sensor_msgs/msg/laser_scan.hpp>\n',
    "components/ekf/model/filter.hpp": "#include <Eigen/Core>\n",
    "components/ekf/component/ekf.cpp": '#include "ekf/model/filter.hpp"\n#include "lidar/protocol/decoder.hpp"\n',
    "containers/runtime/include/nacelle/runtime/broker.hpp": '#include "nacelle/node/node.hpp"\n',
    "launch/include/nacelle/launch/plan.hpp": '#include "nacelle/qos/qos.hpp"\n',
    "containers/nacelle/control/client.hpp": "#include <string>\n",
    "containers/nacelle/ask/nodes.cpp": '#include "control/client.hpp"\n',
    "containers/nacelle/ask/nodes.hpp": "#include <string>\n",
    "containers/nacelle/report/top_tables.hpp": "#include <string>\n",
    "containers/nacelle/cellar/barrel.hpp": "#include <string>\n",
    "containers/nacelle/main.cpp": '#include "nacelle/launch/plan.hpp"\n#include "nacelle/runtime/broker.hpp"\n',
    "test/unit/components/lidar/decoder_test.cpp": '#include "lidar/protocol/decoder.hpp"\n',
    "test/support/manual_clock.hpp": '#include "nacelle/base/time.hpp"\n',
}

# name -> (the file that gets the line, the line, a word of the complaint)
PLANTED = {
    "base includes the contract": ("interfaces/base/src/time.cpp", '"nacelle/node/node.hpp"', "goes up"),
    "the contract includes the runtime": ("interfaces/node/src/node.cpp", '"nacelle/runtime/broker.hpp"', "goes up"),
    "messages, angle brackets": ("interfaces/base/src/log.cpp", "<std_msgs/msg/header.hpp>", "goes up"),
    "the runtime includes the parser": ("containers/runtime/src/a.cpp", '"nacelle/launch/plan.hpp"', "goes up"),
    "a component includes the program": ("components/ekf/component/b.cpp", '"nacelle/main.cpp"', "goes up"),
    "the product includes a test": ("containers/nacelle/ask/b.cpp", '"support/manual_clock.hpp"', "goes up"),
    "up by a relative path": ("interfaces/base/src/up.cpp", '"../../node/include/nacelle/node/node.hpp"', "goes up"),
    "floor 1 sideways": ("qos_profiles/src/a.cpp", "<std_msgs/msg/header.hpp>", "sideways"),
    "floor 2 sideways": ("interfaces/host/src/a.cpp", '"nacelle/io/stream.hpp"', "sideways"),
    "a component includes the host": ("components/ekf/component/g.cpp", '"nacelle/host/transport.hpp"', "sees interfaces/node"),
    "a component includes a container": ("components/ekf/component/c.cpp", '"nacelle/runtime/broker.hpp"', "sideways"),
    "a container includes a component": ("containers/runtime/src/b.cpp", '"ekf/model/filter.hpp"', "sideways"),
    "another component's port": ("components/ekf/component/d.cpp", '"lidar/port/serial.hpp"', "of another component"),
    "launch includes the contract": ("launch/src/a.cpp", '"nacelle/node/node.hpp"', "floors 0 and 1 only"),
    "protocol includes its port": ("components/lidar/protocol/a.cpp", '"lidar/port/serial.hpp"', "do not see"),
    "model includes its component": ("components/ekf/model/a.cpp", '"ekf/component/ekf.cpp"', "do not see"),
    "port includes its protocol": ("components/lidar/port/a.cpp", '"lidar/protocol/decoder.hpp"', "does not see"),
    "protocol knows topics": ("components/lidar/protocol/b.cpp", '"nacelle/node/node.hpp"', "pure"),
    "protocol knows byte streams": ("components/lidar/protocol/c.cpp", '"nacelle/io/stream.hpp"', "pure"),
    "model opens a file": ("components/ekf/model/b.cpp", "<fstream>", "pure"),
    "model starts a thread": ("components/ekf/model/c.cpp", "<thread>", "pure"),
    "protocol calls the kernel": ("components/lidar/protocol/d.cpp", "<sys/ioctl.h>", "pure"),
    "protocol reads a file": ("components/lidar/protocol/e.cpp", "<fcntl.h>", "pure"),
    "a room includes one above it": ("containers/nacelle/control/client.cpp", '"ask/nodes.hpp"', "lower storeys only"),
    "a room includes one beside it": ("containers/nacelle/ask/c.cpp", '"report/top_tables.hpp"', "lower storeys only"),
    "a room without a storey": ("containers/nacelle/ask/d.cpp", '"cellar/barrel.hpp"', "no storey"),
    "a header that is not there": ("components/lidar/component/e.cpp", '"nacelle/base/gone.hpp"', "no such header"),
    "a role header that is not there": ("components/ekf/component/f.cpp", '"lidar/model/gone.hpp"', "no such header"),
}


class FloorsTest(unittest.TestCase):
    def floors(self, files, ask):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            for path, text in {"docs/floors.md": TABLE, **SOUND, **files}.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(text, encoding="utf-8")
            return list(ask(Floors(root)))

    def complaints(self, files):
        return self.floors(files, Floors.complaints)

    def test_a_sound_tree_has_no_complaint(self):
        self.assertEqual(self.complaints({}), [])

    def test_each_planted_arrow_is_found_and_nothing_else(self):
        for name, (path, header, word) in PLANTED.items():
            with self.subTest(name):
                complaints = self.complaints({path: f"// first line\n#include {header}\n"})
                self.assertEqual(len(complaints), 1, complaints)
                self.assertIn(word, complaints[0])
                self.assertTrue(complaints[0].startswith(f"{path}:2: "), complaints[0])

    def test_a_target_compiles_the_files_of_one_room(self):
        lists = "nacelle_static_library(container_ask\n  SOURCES ask/nodes.cpp {}\n  USES nacelle::base)\n"
        for more, count in (("ask/frames.cpp", 0), ("control/client.cpp", 1)):
            complaints = self.floors({"containers/nacelle/CMakeLists.txt": lists.format(more)}, Floors.mixed_targets)
            self.assertEqual(len(complaints), count, complaints)

    def test_a_folder_without_a_floor_is_named(self):
        complaints = self.complaints({"interfaces/new_one/a.hpp": "#pragma once\n"})
        self.assertEqual(len(complaints), 1, complaints)
        self.assertIn("no floor", complaints[0])


if __name__ == "__main__":
    unittest.main()
