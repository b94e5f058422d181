# SPDX-License-Identifier: Apache-2.0
"""The page of `nacelle look` in Chromium without a window: every panel shows the simulated robot, and the joystick drives it and lets it stop."""
import json
import math
import os
import pathlib
import signal
import time
import unittest

from browser import CHROMIUM, Browser
from robot import SLOW, RunningRobotTest, wait_for

PICTURES = pathlib.Path(os.environ.get("NACELLE_PICTURES", "."))
WIDE, PHONE = (1280, 800), (390, 844)
TIMEOUT_S = 0.5  # of the base's input (launch/config/robot.yaml)
CYCLE_S = 0.02
RUNNING_S = 0.25  # the command of zero respects the limits of deceleration
ALL = "['world','camera','drive','components','plots','streams','logs','faults','graph','parameters','record','replay']"


def middle(page, selector):
    return page.run(f"(() => {{ const box = document.querySelector('{selector}').getBoundingClientRect();"
                    " return [box.left + box.width / 2, box.top + box.height / 2, box.width / 2]; })()")  # fmt: skip


@unittest.skipIf(CHROMIUM is None, "Debian's chromium is not installed: ./dev setup browser")
class Page(RunningRobotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        PICTURES.mkdir(exist_ok=True)
        try:
            done = cls.run_program("look", "--port", "0", "--json")
            assert done.returncode == 0, done.stderr
            cls.links = json.loads(done.stdout)
        except BaseException:
            cls.tearDownClass()
            raise

    def open_page(self, size=WIDE, is_phone=False, right="operate"):
        page = Browser(*size, is_phone)
        self.addCleanup(page.close)
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        page.open(self.links[right])
        wait_for("the connection", lambda: page.run("window.nacelle?.robot.right ?? ''") == right)
        wait_for("the services", lambda: page.run("window.nacelle.robot.container") != "")  # they come after the greeting
        return page

    def report(self, page, panel):
        return page.run(f"window.nacelle.panels.{panel}")

    def odometry(self):
        said = self.expect_exit(self.run_program("topic", "echo", "/odom", "--once", "--json"), 0).stdout
        return json.loads(said.splitlines()[0])

    def speed(self):
        twist = self.odometry()["twist"]["twist"]
        return abs(twist["linear"]["x"]) + abs(twist["angular"]["z"])

    def drive(self, page):
        """Holds the stick forward until the robot moves."""
        wait_for("a topic to drive", lambda: self.report(page, "drive")["live"])
        x, y, radius = middle(page, ".stick")
        page.pointer("press", x, y)
        page.pointer("move", x, y - 0.9 * radius)
        wait_for("the robot moves", lambda: self.report(page, "drive")["speed"] > 0.15)
        return x, y

    def expect_stand(self, since, limit_s):
        """The robot stands at the latest so many seconds after that time of the wall clock, by the stamps of its odometry."""
        while True:
            message = self.odometry()
            stamp = message["header"]["stamp"]["sec"] + message["header"]["stamp"]["nanosec"] * 1e-9
            twist = message["twist"]["twist"]
            if abs(twist["linear"]["x"]) + abs(twist["angular"]["z"]) < 0.005:
                return
            self.assertLess(stamp - since, limit_s * SLOW, f"it still moves: {twist}")

    def test_every_panel_shows_live_data(self):
        page = self.open_page()
        page.run(f"window.nacelle.tabs.choose({ALL})")
        for panel in json.loads(ALL.replace("'", '"')):
            with self.subTest(panel=panel):
                wait_for(f"live data in {panel}", lambda: self.report(page, panel)["live"])  # noqa: B023
        self.assertEqual(self.report(page, "components")["components"], len(self.components()))
        self.assertEqual(set(self.report(page, "world")["paths"]), {"/odom", "/odometry/filtered"})
        self.assertTrue(self.report(page, "world")["hasOutline"])
        self.assertGreater(self.report(page, "camera")["width"], 100)
        self.assertGreater(self.report(page, "parameters")["parameters"], 10)
        self.assertEqual(page.complaints, [])

    def components(self):
        return json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)["components"]

    def test_a_hidden_panel_has_no_subscription(self):
        page = self.open_page()
        page.run("window.nacelle.tabs.choose(['world'])")
        wait_for("live data", lambda: self.report(page, "world")["live"])
        topics = "[...window.nacelle.robot.connection.subscriptions].map(({channel}) => channel.topic)"
        self.assertIn("/scan", page.run(topics))
        page.run("window.nacelle.tabs.choose([])")
        self.assertEqual(page.run(topics), [])

    def test_the_joystick_drives_and_stops(self):
        page = self.open_page()
        wait_for("live data", lambda: self.report(page, "world")["live"])
        before = self.report(page, "world")["position"]
        x, y = self.drive(page)
        page.pointer("release", x, y)
        released = time.time()
        self.expect_stand(released, TIMEOUT_S + CYCLE_S + RUNNING_S)
        self.assertFalse(self.report(page, "drive")["held"])
        after = self.report(page, "world")["position"]
        self.assertGreater(math.dist(before, after), 0.01)

    def test_the_robot_stops_when_the_page_is_closed(self):
        page = self.open_page()
        self.drive(page)
        closed = time.time()
        page.close_page()
        self.expect_stand(closed, TIMEOUT_S + CYCLE_S + RUNNING_S)

    def test_the_robot_stops_when_the_phone_hangs(self):
        page = self.open_page()
        self.drive(page)
        os.killpg(page.process.pid, signal.SIGSTOP)
        self.expect_stand(time.time(), TIMEOUT_S + CYCLE_S + RUNNING_S)

    def test_the_emergency_stop_is_set_and_released(self):
        page = self.open_page()
        page.run("document.querySelector('#stop').click()")
        wait_for("the stop", lambda: page.run("window.nacelle.robot.stops") == ["/emergency_stop"])
        self.assertEqual(page.run("document.querySelector('#stop').textContent"), "STOPPED")
        page.run("document.querySelector('#release').click()")
        wait_for("the release", lambda: page.run("window.nacelle.robot.stops") == [])

    def test_a_link_to_look_changes_nothing_but_the_stop(self):
        page = self.open_page(right="view")
        wait_for("live data", lambda: self.report(page, "drive")["live"] and self.report(page, "components")["live"])
        x, y, radius = middle(page, ".stick")
        page.pointer("press", x, y)
        page.pointer("move", x, y - 0.9 * radius)
        self.assertFalse(self.report(page, "drive")["held"])
        page.pointer("release", x, y)
        self.assertIn("may only look", page.run("document.querySelector('#panel-drive .note').textContent"))
        self.assertEqual(page.run("[...document.querySelectorAll('.panel-components button')].filter((one) => !one.disabled).length"), 0)
        try:
            page.run("document.querySelector('#stop').click()")
            wait_for("the stop", lambda: page.run("window.nacelle.robot.stops") == ["/emergency_stop"])
            self.assertTrue(page.run("document.querySelector('#release').disabled"))
        finally:
            self.expect_exit(self.run_program("estop", "release"), 0)
        self.assertEqual(page.complaints, [])

    def test_a_lost_connection_is_said_and_opened_again(self):
        page = self.open_page()
        state = "document.querySelector('#state').textContent"
        page.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=-1, uploadThroughput=-1)
        page.run("window.nacelle.robot.connection.giveUp()")  # the browser keeps open sockets open
        wait_for("it is said", lambda: "NOT CONNECTED" in page.run(state))
        page.call("Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=-1, uploadThroughput=-1)
        wait_for("it is open again", lambda: page.run(state) == "connected")
        wait_for("live data", lambda: self.report(page, "world")["live"])

    def test_the_keyboard_drives(self):
        page = self.open_page()
        wait_for("a topic to drive", lambda: self.report(page, "drive")["live"])
        page.run("document.querySelector('.stick').focus()")
        up = {"key": "ArrowUp", "code": "ArrowUp", "windowsVirtualKeyCode": 38}
        page.call("Input.dispatchKeyEvent", type="keyDown", **up)
        wait_for("the robot moves", lambda: self.report(page, "drive")["speed"] > 0.1)
        page.call("Input.dispatchKeyEvent", type="keyUp", **up)
        self.expect_stand(time.time(), TIMEOUT_S + CYCLE_S + RUNNING_S)

    def test_a_field_is_plotted(self):
        page = self.open_page()
        wait_for("the first lines", lambda: len(self.report(page, "plots")["lines"]) == 2)
        page.run("[...document.querySelectorAll('.tree > details')].find((one) => one.innerText.startsWith('/imu/data_raw')).open = true")
        page.run("[...document.querySelectorAll('.tree details')].find((one) => one.innerText === 'angular_velocity').open = true")
        page.run("[...document.querySelectorAll('.field')].find((one) => one.title.endsWith('angular_velocity.z')).click()")
        wait_for("values", lambda: self.report(page, "plots")["lines"][2]["points"] > 20)
        self.assertEqual(self.report(page, "plots")["lines"][2]["path"], "angular_velocity.z")
        page.run("""(() => { const field = [...document.querySelectorAll('.field')].find((one) => one.title.endsWith('angular_velocity.x'));
                     const dataTransfer = new DataTransfer();
                     field.dispatchEvent(new DragEvent('dragstart', {dataTransfer, bubbles: true}));
                     document.querySelector('.plot-area').dispatchEvent(new DragEvent('drop', {dataTransfer, bubbles: true})); })()""")
        wait_for("values of what was dragged", lambda: self.report(page, "plots")["lines"][3]["points"] > 20)
        self.assertEqual(self.report(page, "plots")["lines"][3]["path"], "angular_velocity.x")

    def test_a_component_is_deactivated_activated_loaded_and_unloaded(self):
        page = self.open_page()
        row = "[...document.querySelectorAll('.panel-components tr')].find((one) => one.component?.node === '{}')"
        press = "[...{}.querySelectorAll('button')].find((one) => !one.hidden && one.textContent === '{}').click()"
        state = row.format("/monitor_2") + "?.querySelector('.badge').textContent"
        wait_for("the list", lambda: page.run(state) == "active")
        page.run(press.format(row.format("/monitor_2"), "deactivate"))
        wait_for("it is inactive", lambda: page.run(state) == "inactive")
        page.run(press.format(row.format("/monitor_2"), "activate"))
        wait_for("it is active", lambda: page.run(state) == "active")
        page.run("window.confirm = () => true")
        page.run("(() => { const form = document.querySelector('.panel-components form'); const [what, name] = form.querySelectorAll('input');"
                 " what.value = 'nacelle::monitor::MonitorComponent'; name.value = 'monitor_3'; form.requestSubmit(); })()")  # fmt: skip
        wait_for("it is loaded", lambda: page.run(row.format("/monitor_3") + " !== undefined"))
        page.run(press.format(row.format("/monitor_3"), "unload"))
        wait_for("it is gone", lambda: page.run(row.format("/monitor_3") + " === undefined"))

    def test_a_parameter_is_set(self):
        page = self.open_page()
        page.run("window.nacelle.tabs.choose(['parameters'])")
        wait_for("the parameters", lambda: self.report(page, "parameters")["live"])
        page.run("""(() => { const input = document.getElementById('parameter-linear.x.max_velocity'); input.value = '0.4';
                     input.dispatchEvent(new Event('change')); })()""")
        try:
            wait_for("the value", lambda: "0.4" in self.run_program("param", "get", "/diff_drive", "linear.x.max_velocity").stdout)
        finally:
            self.run_program("param", "set", "/diff_drive", "linear.x.max_velocity", "0.5")

    def test_a_recording_is_made_and_replayed(self):
        page = self.open_page()
        page.run("window.nacelle.tabs.choose(['record', 'replay'])")
        bag = self.folder / "from_the_page"
        fill = "(() => {{ const panel = document.querySelector('#panel-{}'); const inputs = panel.querySelectorAll('input'); {} " \
               "panel.querySelector('form').requestSubmit(); }})()"  # fmt: skip
        page.run(fill.format("record", f"inputs[0].value = '/odom'; inputs[1].value = '{bag}';"))
        wait_for("the recorder", lambda: self.report(page, "record")["recordings"] == 1)
        before = self.streams()["/odom"]["published"]
        wait_for("three seconds of odometry", lambda: self.streams()["/odom"]["published"] > before + 150)
        page.run("document.querySelector('#panel-record .card button').click()")
        wait_for("the end of the recording", lambda: self.report(page, "record")["recordings"] == 0)
        page.run(fill.format("replay", f"inputs[0].value = '{bag}';"))
        length = wait_for("the player", lambda: self.report(page, "replay")["length"])
        found = json.loads(self.expect_exit(self.run_program("bag", "info", bag, "--json"), 0).stdout)
        self.assertAlmostEqual(length, (found["end_ns"] - found["start_ns"]) * 1e-9, delta=0.3)
        self.assertTrue(self.report(page, "replay")["paused"])
        self.assertIn("/replay/odom", self.streams())
        page.run("window.nacelle.tabs.choose(['world', 'replay'])")
        wait_for("the robot", lambda: self.report(page, "world")["live"])
        self.assertNotIn("/replay/odom", self.report(page, "world")["paths"])
        page.run("(() => { const slider = document.querySelector('.player input[type=range]'); slider.value = 2;"
                 " slider.dispatchEvent(new Event('input')); })()")  # fmt: skip
        wait_for("what was there", lambda: "/replay/odom" in self.report(page, "world")["paths"])
        wait_for("it is paused there", lambda: self.report(page, "replay")["paused"] and abs(self.report(page, "replay")["position"] - 2) < 0.01)
        page.run("document.querySelector('.player button').click()")
        wait_for("it plays from there", lambda: 2.1 < self.report(page, "replay")["position"])
        page.run("document.querySelector('.player').lastElementChild.click()")
        wait_for("the player is gone", lambda: self.report(page, "replay")["node"] == "")

    def test_pictures(self):
        for name, size, is_phone in (("look", WIDE, False), ("look_phone", PHONE, True)):
            with self.subTest(name=name):
                page = self.open_page(size, is_phone)
                wait_for("live data", lambda: self.report(page, "world")["live"])  # noqa: B023
                if is_phone:
                    page.run("[...document.querySelectorAll('.panel-world button')].find((one) => one.textContent === '3D').click()")
                else:
                    wait_for("an image", lambda: self.report(page, "camera")["width"] > 0)  # noqa: B023
                begin = self.report(page, "world")["position"]
                x, y = self.drive(page)
                page.pointer("move", x + 0.4 * middle(page, ".stick")[2], y - 0.8 * middle(page, ".stick")[2])
                wait_for("a path", lambda: math.dist(begin, self.report(page, "world")["position"]) > 0.4)  # noqa: B023
                data = page.picture(PICTURES / f"{name}.png")
                page.pointer("release", x, y)
                self.assertGreater(len(data), 20000)
                self.assertLessEqual(page.run("document.documentElement.scrollWidth"), size[0])


if __name__ == "__main__":
    unittest.main()
