# SPDX-License-Identifier: Apache-2.0
"""What tests of --remote share: a laptop, another machine with a robot, and a cable between them."""
import json
import pathlib
import subprocess

from machines import Lines, Machine, cable
from on_the_network import ApartTest
from robot import LAUNCH_FILE, PROGRAM, SLOW

ACTIONS = pathlib.Path(__file__).parent / "actions" / "actions.launch.yaml"


class RemoteTest(ApartTest):
    """Two machines and a cable between them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.far, cls.laptop = Machine(), Machine()
        cls.addClassCleanup(cls.far.close)
        cls.addClassCleanup(cls.laptop.close)
        cable(cls.far, cls.laptop)

    @classmethod
    def start_far(cls, is_up, *words):
        """A program on the other machine; returns when it says that it is up."""
        program = Lines(cls.far.within(*words), cls.environment)

        cls.addClassCleanup(program.interrupt)
        program.wait_for("the other side is up", is_up, 60)
        return program

    @classmethod
    def command(cls, *words):
        return cls.laptop.within(PROGRAM, *words, "--remote")

    # Its runtime folder is another one: no container's socket is seen here.
    @classmethod
    def laptop_environment(cls, **variables):
        return {**cls.environment, "XDG_RUNTIME_DIR": str(cls.folder / "laptop"), **variables}

    def ask(self, *words, code=0, limit_s=60, **variables):
        outcome = subprocess.run(self.command(*words), capture_output=True, text=True, timeout=limit_s * SLOW,
                                 env=self.laptop_environment(**variables))  # fmt: skip
        return self.expect_exit(outcome, code)

    def rows(self, *words):
        return json.loads(self.ask(*words, "--json").stdout)

    def listen(self, *words):
        program = Lines(self.command(*words), self.laptop_environment())
        self.addCleanup(program.close)
        return program


class RemoteRobotTest(RemoteTest):
    """A simulated robot that is shown to the LAN."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.start_far(lambda line: line.startswith("network: shown"), PROGRAM, "launch", LAUNCH_FILE, "sim:=true",
                      f"sim_dir:={cls.folder}/sim", "--name", "robot", "network:=export")  # fmt: skip

    def local(self, *words):
        """What the container itself says."""
        return json.loads(self.expect_exit(self.run_program(*words, "--json"), 0).stdout)
