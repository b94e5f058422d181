# SPDX-License-Identifier: Apache-2.0
"""`nacelle look` and its server, as a Foxglove viewer, a browser and somebody hostile see them."""
import json
import os
import pathlib
import socket
import stat
import unittest

from robot import SLOW, RunningRobotTest, interrupt, wait_for
from web_socket import BINARY, TEXT, Refused, WebSocket, fetch

ROUNDS = int(os.environ.get("NACELLE_LOOK_ROUNDS", "30"))  # at night: 1,000


class Look(RunningRobotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        try:
            done = cls.run_program("look", "--port", "0", "--json")
            assert done.returncode == 0, done.stderr
            cls.links = json.loads(done.stdout)
        except BaseException:
            cls.tearDownClass()
            raise

    def connect(self, right="operate"):
        viewer = WebSocket(self.links["foxglove" if right == "operate" else "foxglove_view"])
        self.addCleanup(viewer.close)
        viewer.until("the greeting", lambda: viewer.info and viewer.said("advertiseServices"))
        return viewer

    def readers(self, topic):
        return self.streams()[topic]["readers"]

    def test_the_greeting_lists_topics_with_their_definitions(self):
        viewer = self.connect("view")
        self.assertIn("Sec-WebSocket-Protocol: foxglove.sdk.v1", viewer.head.replace("sec-websocket-protocol", "Sec-WebSocket-Protocol"))
        self.assertEqual(viewer.info["metadata"]["nacelle.right"], "view")
        self.assertIn("clientPublish", viewer.info["capabilities"])
        scan = viewer.channels["/scan"]
        self.assertEqual((scan["encoding"], scan["schemaEncoding"], scan["schemaName"]), ("cdr", "ros2msg", "sensor_msgs/msg/LaserScan"))
        self.assertIn("float32[] ranges", scan["schema"])
        self.assertIn("MSG: std_msgs/Header", scan["schema"])
        self.assertIn("/tf_static", viewer.channels)
        state = viewer.services["/lidar/get_state"]
        self.assertEqual(state["type"], "lifecycle_msgs/srv/GetState")
        self.assertIn("current_state", state["response"]["schema"])

    def test_messages_come_while_somebody_is_subscribed(self):
        before = self.readers("/odom")
        viewer = self.connect()
        viewer.subscribe(7, "/odom")
        viewer.subscribe(8, "/tf_static")
        viewer.until("odometry", lambda: viewer.count(7) > 20)
        self.assertEqual(viewer.count(8), 1, "what stays comes once")
        stamps = [stamp for subscription, stamp, _ in viewer.messages if subscription == 7]
        self.assertEqual(stamps, sorted(stamps))
        for _, _, data in viewer.messages:
            self.assertEqual(data[:4], b"\0\1\0\0", "CDR, little-endian, with its head")
        self.assertEqual(self.readers("/odom"), before + 1)
        second = self.connect("view")
        second.subscribe(1, "/tf_static")
        second.until("what stays, for one who comes later", lambda: second.count(1) == 1)
        viewer.say("unsubscribe", subscriptionIds=[7])
        wait_for("the reader is gone", lambda: self.readers("/odom") == before)

    def test_pictures_are_small_ones_and_made_once(self):
        viewer = self.connect("view")
        viewer.subscribe(1, "/camera/image_raw/look")
        viewer.until("pictures", lambda: viewer.count(1) >= 3)
        data = viewer.messages[0][2]
        self.assertIn(b"jpeg\0", data)
        self.assertIn(b"\xff\xd8\xff", data)
        self.assertLess(len(data), 100_000)

    def test_services_answer(self):
        viewer = self.connect("view")
        state = viewer.call(1, "/lidar/get_state")
        self.assertEqual(state["current_state"]["label"], "active")
        self.assertIn("asks for the right to operate", viewer.call(2, "/lidar/change_state", {"transition": {"id": 4}}))
        operator = self.connect()
        done = operator.call(3, "/lidar/change_state", {"transition": {"id": 4}})
        self.assertTrue(done["success"])
        self.assertTrue(operator.call(4, "/lidar/change_state", {"transition": {"id": 3}})["success"])
        self.assertIn("transition", str(operator.call(5, "/lidar/change_state", {"transition": 5})))
        self.assertEqual(viewer.call(6, "/lidar/get_state")["current_state"]["label"], "active", "a request that cannot be read changes nothing")
        self.assertIn("own machine only", operator.call(7, "/robot/_container/shutdown"))

    def test_parameters_are_read_set_and_followed(self):
        viewer = self.connect()
        viewer.say("getParameters", parameterNames=[], id="all")
        values = viewer.until("all parameters", lambda: viewer.said("parameterValues", id="all"))[0]["parameters"]
        by_name = {one["name"]: one for one in values}
        self.assertGreater(len(by_name), 100)
        name = "/diff_drive.max_linear_velocity" if "/diff_drive.max_linear_velocity" in by_name else next(
            name for name, one in by_name.items() if one.get("type") == "float64" and name.startswith("/monitor"))  # fmt: skip
        other = self.connect("view")
        other.say("subscribeParameterUpdates", parameterNames=[])
        wait_for("the events have a reader", lambda: self.readers("/parameter_events") > 0)
        viewer.say("setParameters", parameters=[by_name[name]], id="set")
        answer = viewer.until("the answer", lambda: viewer.said("parameterValues", id="set"))[0]["parameters"]
        self.assertEqual(answer, [by_name[name]])
        other.say("setParameters", parameters=[by_name[name]])
        other.until("a refusal", lambda: any("right to operate" in one["message"] for one in other.said("status")))

    def test_the_graph_is_told_and_followed(self):
        viewer = self.connect("view")
        viewer.say("subscribeConnectionGraph")
        graph = viewer.until("the graph", lambda: viewer.said("connectionGraphUpdate"))[0]
        published = {one["name"]: one["publisherIds"] for one in graph["publishedTopics"]}
        self.assertEqual(published["/scan"], ["/lidar"])
        self.assertTrue(any(one["name"] == "/lidar/get_state" and one["providerIds"] == ["/lidar"] for one in graph["advertisedServices"]))

    def test_a_viewer_with_view_sets_the_emergency_stop_and_does_not_release_it(self):
        viewer = self.connect("view")
        viewer.say("advertise", channels=[{"id": 1, "topic": "/emergency_stop", "encoding": "json", "schemaName": "std_msgs/msg/Bool"},
                                          {"id": 2, "topic": "/cmd_vel", "encoding": "json", "schemaName": "geometry_msgs/msg/TwistStamped"}])  # fmt: skip
        viewer.until("a refusal", lambda: any("/cmd_vel" in one["message"] for one in viewer.said("status")))
        viewer.publish(1, {"data": True})
        watcher = self.connect("view")
        watcher.subscribe(1, "/emergency_stop")
        watcher.until("the stop", lambda: any(data[4:5] == b"\1" for _, _, data in watcher.messages))
        viewer.publish(1, {"data": False})
        viewer.until("a refusal", lambda: any("releasing the emergency stop" in one["message"] for one in viewer.said("status")))
        self.expect_exit(self.run_program("estop", "release"), 0)

    def test_a_page_that_goes_away_stops_the_robot(self):
        watcher = self.connect("view")
        watcher.subscribe(1, "/odom")

        def speed():  # twist.twist.linear.x: behind the pose's covariance; read by the program
            return json.loads(self.expect_exit(self.run_program("topic", "echo", "/odom", "--once", "--json"), 0).stdout)["twist"]["twist"]["linear"]["x"]

        viewer = self.connect()
        viewer.say("advertise", channels=[{"id": 1, "topic": "/cmd_vel", "encoding": "json", "schemaName": "geometry_msgs/msg/TwistStamped"}])

        def drives():
            viewer.publish(1, {"twist": {"linear": {"x": 0.2}}})
            return speed() > 0.05

        wait_for("the robot drives", drives)
        viewer.close()
        wait_for("the robot stands", lambda: abs(speed()) < 0.01)

    def test_who_has_no_link_stays_outside(self):
        link = self.links["foxglove"]
        outside = link.split("?")[0]
        for wrong, headers, status in ((outside, {}, 401), (outside + "?token=", {}, 401), (outside + "?token=" + "0" * 32, {}, 401),
                                       (link, {"Origin": "http://evil.example"}, 403), (link, {"Origin": "null"}, 403),
                                       (link, {"Host": "evil.example:80"}, 403)):  # fmt: skip
            with self.subTest(link=wrong, headers=headers):
                with self.assertRaises(Refused) as refused:
                    WebSocket(wrong, **headers)
                self.assertEqual(refused.exception.status, status)
        with self.assertRaises(Refused):
            WebSocket(link, protocols="chat")
        with WebSocket(link, protocols="foxglove.websocket.v1", Origin=outside.replace("ws:", "http:").rstrip("/")) as old:
            self.assertIn("foxglove.websocket.v1", old.head)

    def test_the_page_is_given_with_a_policy_and_no_other_file_is(self):
        page = self.links["operate"].split("#")[0]
        status, head, body = fetch(page, "/")
        self.assertEqual(status, 200)
        self.assertIn("default-src 'self'", head)
        self.assertIn(b"<!doctype html>", body.lower())
        self.assertEqual(fetch(page, "/../../etc/passwd")[0], 404)
        self.assertEqual(fetch(page, "/none")[0], 404)
        self.assertEqual(fetch(page, "/", Host="evil.example")[0], 403)

    def test_the_links_are_the_owners_own(self):
        (file,) = pathlib.Path(self.folder, "nacelle").glob("look*.json")
        self.assertEqual(stat.S_IMODE(file.stat().st_mode), 0o600)
        token = self.links["operate"].split("token=")[1]
        refused = self.run_program("param", "set", "/look", "link_file", str(self.folder / "other"))
        self.assertIn("in a launch file only", refused.stderr)
        for words in (("param", "dump", "/look"), ("component", "info", "look")):
            self.assertNotIn(token, self.expect_exit(self.run_program(*words), 0).stdout)
        self.assertNotIn(token, (self.folder / "log").read_text())
        self.assertEqual(json.loads(self.expect_exit(self.run_program("look", "--json"), 0).stdout), self.links, "one server, one link")

    def test_hostile_frames_end_or_warn_and_harm_nobody(self):
        victim = self.connect("view")
        victim.subscribe(1, "/odom")
        viewer = self.connect()
        for text in (b"", b"{", b"[]", b'{"op":"fly"}', b'{"op":"subscribe","subscriptions":[{"id":1,"channelId":99999}]}', b"[" * 10000, b"\xff\xfe"):
            if viewer.socket.fileno() < 0:
                viewer = self.connect()
            try:
                viewer.send_frame(TEXT, text)
            except OSError:
                viewer = self.connect()
        for frame in (b"", b"\1", b"\2", b"\3" * 100, b"\1\0\0\0\0", b"\2" + b"\xff" * 12):
            viewer = self.connect()
            viewer.send_frame(BINARY, frame)
        viewer = self.connect()
        viewer.say("fetchAsset", uri="package://../../etc/passwd", requestId=1)
        viewer.say("advertise", channels=[{"id": i, "topic": f"/t{i}", "encoding": "json", "schemaName": "std_msgs/msg/Bool"} for i in range(200)])
        viewer.until("a limit", lambda: any("100 of them" in one["message"] for one in viewer.said("status")))
        viewer.say("advertise", channels=[{"id": 1, "topic": "no topic", "encoding": "json", "schemaName": "std_msgs/msg/Bool"}])
        viewer = self.connect()
        viewer.say("advertise", channels=[{"id": 1, "topic": "/x", "encoding": "json", "schemaName": "none_msgs/msg/None"}])
        viewer.until("a refusal", lambda: any("none_msgs" in one["message"] for one in viewer.said("status")))
        greedy = self.connect("view")
        for number in range(40):
            greedy.say("getParameters", parameterNames=[], id=str(number))
        greedy.until("a limit of requests", lambda: any("too much at a time" in one["message"] for one in greedy.said("status")))
        too_large = self.connect()
        with self.assertRaises((ConnectionError, OSError)):
            too_large.send_frame(BINARY, b"\1" + bytes(2 << 20))
            while True:
                too_large.step()
        before = victim.count(1)
        victim.until("odometry, all the same", lambda: victim.count(1) > before + 20)

    def test_one_who_does_not_read_keeps_nobody_waiting(self):
        lazy = self.connect()
        lazy.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        lazy.subscribe(1, "/camera/image_raw")
        for number in range(2, 12):
            lazy.say("getParameters", parameterNames=[], id=str(number))
        viewer = self.connect("view")
        viewer.subscribe(1, "/odom")
        before = self.streams()["/camera/image_raw"]
        viewer.until("odometry", lambda: viewer.count(1) > 100, 30)
        after = self.streams()["/camera/image_raw"]
        self.assertGreater(after["published"], before["published"])

    def test_viewers_come_and_go_and_leave_nothing(self):
        def figures():
            process = pathlib.Path("/proc") / str(self.links["process"])
            return len(list((process / "fd").iterdir())), len(list((process / "task").iterdir()))

        def visit():
            with WebSocket(self.links["foxglove"]) as viewer:
                viewer.subscribe(1, "/odom")
                viewer.subscribe(2, "/scan")
                viewer.until("a message", lambda: viewer.messages)

        visit()
        before_readers = self.readers("/scan")
        wait_for("the reader of /scan is gone", lambda: self.readers("/scan") <= before_readers)
        before = figures()
        for _ in range(ROUNDS):
            visit()
        wait_for(f"as many descriptors and threads as before: {before}", lambda: figures() == before)


class Command(RunningRobotTest):
    def test_it_ends_with_ctrl_c_and_takes_its_server_along(self):
        look = self.start_program("look", "--port", "0")
        try:
            words = look.stdout.readline()
            self.assertIn("/#token=", words)
            self.assertIn("look", self.run_program("component", "list").stdout)
        finally:
            interrupt(look)
            look.stdout.close()
        self.assertEqual(look.returncode, 0)
        self.assertNotIn("look", self.run_program("component", "list").stdout)
        self.assertFalse(list(pathlib.Path(self.folder).glob("nacelle/look*.json")))

    def test_a_port_that_is_taken_is_named(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            refused = self.run_program("look", "--port", taken.getsockname()[1])
        self.assertEqual(refused.returncode, 1)
        self.assertIn("cannot listen on 127.0.0.1", refused.stderr)


if __name__ == "__main__":
    unittest.main()
