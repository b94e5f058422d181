# SPDX-License-Identifier: Apache-2.0
"""`nacelle bag`: recordings that another program wrote, whole and damaged."""
import json
import pathlib
import sqlite3
import struct
import subprocess
import sys
import unittest
import xml.etree.ElementTree
import zlib

from robot import RobotTest, of_words

SVG = "{http://www.w3.org/2000/svg}"
TALKER = str(pathlib.Path(__file__).resolve().parents[2] / "docs" / "examples" / "recordings" / "talker.mcap")

# Written from the tables of the MCAP specification, apart from Nacelle's writer.
MAGIC = b"\x89MCAP0\r\n"
SECOND = 1_000_000_000


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def text(words):
    return struct.pack("<I", len(words)) + words.encode()


def schema(number, name):
    return record(3, struct.pack("<H", number) + text(name) + text("ros2msg") + text("string data\n"))


def channel(number, of, topic):
    return record(4, struct.pack("<HH", number, of) + text(topic) + text("cdr") + struct.pack("<I", 0))


def message(of, at, data):
    return record(5, struct.pack("<HIQQ", of, 0, at, at) + data)


def cdr_string(words):
    return b"\0\1\0\0" + struct.pack("<I", len(words) + 1) + words.encode() + b"\0"


def chunk(records, begin, end):
    return record(6, struct.pack("<QQQI", begin, end, len(records), zlib.crc32(records)) + text("") + struct.pack("<Q", len(records)) + records)


def bag(*parts, whole=True):
    end = record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + MAGIC
    return MAGIC + record(1, text("ros2") + text("other")) + b"".join(parts) + (end if whole else b"")


# Source: rosbag2_storage_sqlite3, schema version 4; files of before ROS 2 Iron have no definitions.
TABLES = """
CREATE TABLE topics(
  id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO topics VALUES(1, '/chatter', 'std_msgs/msg/String', 'cdr', '- depth: 10');
INSERT INTO topics VALUES(2, '/secret', 'my_msgs/msg/Secret', 'cdr', '');
"""
DEFINITIONS = """
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT, encoded_message_definition TEXT, type_description_hash TEXT);
INSERT INTO message_definitions VALUES(1, 'my_msgs/msg/Secret', 'ros2msg', 'uint8 secret', '');
"""

DESCRIPTIONS = schema(1, "std_msgs/msg/String") + channel(7, 1, "/chatter") + schema(2, "my_msgs/msg/Secret") + channel(8, 2, "/secret")


def talk(first, last):
    records = DESCRIPTIONS + b"".join(message(7, at * SECOND, cdr_string("hello")) for at in range(first, last + 1))
    return chunk(records + message(8, last * SECOND, b"\0\1\0\0?"), first * SECOND, last * SECOND)


@of_words
class Bag(RobotTest):
    def setUp(self):
        super().setUp()
        self.bags = pathlib.Path(self.folder)

    def nacelle(self, *words):
        done = self.run_program(*words)
        return done.returncode, done.stdout, done.stderr

    def write(self, name, content):
        path = self.bags / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
        return str(path)

    def test_info_prints_what_ros2_prints_with_rates_and_gaps(self):
        path = self.write("drive.mcap", bag(talk(10, 14), talk(18, 20)))
        code, out, err = self.nacelle("bag", "info", path)
        self.assertEqual((code, err), (0, ""))
        self.assertIn("Files:             drive.mcap\n", out)
        self.assertIn("Duration:          10.000000000s\n", out)
        self.assertIn("Messages:          10\n", out)
        self.assertIn("Topic: /chatter | Type: std_msgs/msg/String | Count: 8 | Serialization Format: cdr | Rate: 0.70 Hz | Longest gap: 4.000 s\n", out)
        self.assertIn("Topic: /secret | Type: my_msgs/msg/Secret | Count: 2 |", out)

    def test_a_folder_is_one_recording_in_the_order_of_its_numbers(self):
        for number, first in ((0, 10), (2, 20), (10, 30)):
            self.write(f"drive/drive_{number}.mcap", bag(talk(first, first + 4)))
        code, out, _ = self.nacelle("bag", "info", str(self.bags / "drive"), "--json")
        self.assertEqual(code, 0)
        found = json.loads(out)
        self.assertEqual([pathlib.Path(file).name for file in found["files"]], ["drive_0.mcap", "drive_2.mcap", "drive_10.mcap"])
        self.assertEqual((found["messages"], found["start_ns"], found["end_ns"]), (18, 10 * SECOND, 34 * SECOND))
        self.assertEqual(next(topic["longest_gap_s"] for topic in found["topics"] if topic["name"] == "/chatter"), 6.0)

    def test_check_decodes_what_it_knows_and_counts_what_it_does_not(self):
        path = self.write("good.mcap", bag(talk(1, 3)))
        code, out, _ = self.nacelle("bag", "check", path)
        self.assertEqual(code, 0, out)
        self.assertIn("ok: 4 messages in 1 chunk, 0 of them indexed, 1 checksum compared", out)
        self.assertIn("1 of my_msgs/msg/Secret were not decoded", out)
        path = self.write("bad.mcap", bag(DESCRIPTIONS, message(7, 1, b"\0\1\0\0\xff\xff\xff\xffhello")))
        code, out, _ = self.nacelle("bag", "check", path, "--json")
        self.assertEqual(code, 1)
        (found,) = json.loads(out)
        self.assertEqual([problem["code"] for problem in found["problems"]], ["mcap.bad_payload"])

    def test_recover_makes_a_whole_file_of_what_can_be_read(self):
        damaged = self.write("cut.mcap", bag(talk(1, 3), talk(4, 6), whole=False)[:-40])
        code, _, err = self.nacelle("bag", "info", damaged)
        self.assertEqual(code, 1)
        self.assertIn("it ends inside a record", err)
        self.assertIn("nacelle bag recover", err)
        code, out, _ = self.nacelle("bag", "recover", damaged, "--compression", "zstd")
        self.assertEqual(code, 0)
        self.assertIn("cut.recovered.mcap: 4 of 4 messages", out)
        self.assertEqual(self.nacelle("bag", "check", str(self.bags / "cut.recovered.mcap"))[0], 0)
        code, _, err = self.nacelle("bag", "recover", damaged)
        self.assertEqual(code, 1)
        self.assertIn("exists already", err)

    def test_parts_of_a_recording_are_copied(self):
        for number, first in ((0, 10), (1, 15)):
            self.write(f"parts/parts_{number}.mcap", bag(talk(first, first + 4)))
        source, copy = str(self.bags / "parts"), str(self.bags / "copy.mcap")

        def of_copy(*words):
            code, out, err = self.nacelle("bag", *words, "-o", copy)
            self.assertEqual((code, err), (0, ""), out)
            self.assertEqual(self.nacelle("bag", "check", copy)[0], 0)
            found = json.loads(self.nacelle("bag", "info", copy, "--json")[1])
            pathlib.Path(copy).unlink()
            return found

        whole = of_copy("convert", source, "--compression", "lz4")
        self.assertEqual((whole["messages"], whole["compression"], len(whole["topics"])), (12, "lz4", 2))
        middle = of_copy("cut", source, "--start-offset", "2", "--duration", "5")
        self.assertEqual((middle["start_ns"], middle["end_ns"], middle["messages"]), (12 * SECOND, 17 * SECOND, 7))
        for words, topics in ((("--topics", "/secret"), ["/secret"]), (("-e", "^/ch"), ["/chatter"]), (("-x", "chat"), ["/secret"]),
                              (("--topics", "/secret", "-e", "ter$"), ["/chatter", "/secret"])):  # fmt: skip
            self.assertEqual([topic["name"] for topic in of_copy("filter", source, *words)["topics"]], topics)
        code, _, err = self.nacelle("bag", "filter", source, "-e", "(", "-o", copy)
        self.assertEqual(code, 2)
        self.assertIn("is no regular expression", err)
        code, _, err = self.nacelle("bag", "convert", self.write("cut_off.mcap", bag(talk(1, 2), whole=False)), "-o", copy)
        self.assertEqual(code, 1)
        self.assertIn("has no footer", err)
        self.assertFalse(pathlib.Path(copy).exists())

    def test_diff_compares_messages_in_their_order(self):
        same, fewer = str(self.bags / "same.mcap"), str(self.bags / "fewer.mcap")
        self.assertEqual(self.nacelle("bag", "convert", TALKER, "-o", same, "--compression", "lz4")[0], 0)
        self.assertEqual(self.nacelle("bag", "cut", TALKER, "-o", fewer, "--duration", "1")[0], 0)
        code, out, err = self.nacelle("bag", "diff", same, same)
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(out, "/chatter [std_msgs/msg/String]: 26 messages in both, 26 equal\nequal\n")
        code, out, _ = self.nacelle("bag", "diff", same, fewer)
        self.assertEqual(code, 1)
        self.assertIn("/chatter [std_msgs/msg/String]: 26 messages in A, 11 in B, 11 equal\n", out)

    def test_diff_names_the_first_difference_and_applies_tolerances(self):
        words = ("hello", "other")
        for number in range(2):
            last = message(7, 4 * SECOND, cdr_string(words[number]))
            path = self.write(f"said_{number}.raw.mcap", bag(talk(1, 3), chunk(last, 4 * SECOND, 4 * SECOND)))
            self.assertEqual(self.nacelle("bag", "convert", path, "-o", str(self.bags / f"said_{number}.mcap"))[0], 0)
        both = (str(self.bags / "said_0.mcap"), str(self.bags / "said_1.mcap"))
        code, out, _ = self.nacelle("bag", "diff", *both)
        self.assertEqual(code, 1)
        self.assertIn("  first in message 3 at 3.000 s in A, 3.000 s in B: data: 'hello' in A, 'other' in B\n", out)
        self.assertIn("/secret [my_msgs/msg/Secret]: 1 message in both, 1 equal (compared by bytes: the type is not installed)\n", out)
        code, out, _ = self.nacelle("bag", "diff", *both, "--json")
        found = json.loads(out)
        chatter = found["topics"][0]
        self.assertEqual((code, found["equal"], chatter["equal"], chatter["different"]), (1, False, 3, 1))
        self.assertEqual((chatter["first"]["path"], chatter["first"]["value_b"], chatter["first"]["time_b_ns"]), ("data", "'other'", 4 * SECOND))
        self.assertEqual(self.nacelle("bag", "diff", *both, "--topics", "/secret")[0], 0)
        ignored = self.write("ignored.yaml", b"/chatter: {data: {ignore: true}}\n")
        self.assertEqual(self.nacelle("bag", "diff", *both, "--tolerance", ignored)[0], 0)

    def test_diff_says_with_another_code_why_it_cannot_compare(self):
        path = str(self.bags / "talk.mcap")
        self.nacelle("bag", "convert", TALKER, "-o", path)
        for words, expected in (
            ((path, "/no/such"), "No such file"),
            ((path, self.write("cut.mcap", bag(talk(1, 3), whole=False))), "it has no footer"),
            ((path, path, "--topics", "/chater"), "did you mean '/chatter'?"),
            ((path, path, "--tolerance", "/no/such"), "No such file"),
            ((path, path, "--tolerance", self.write("bad.yaml", b"/chatter:\n  data: -1\n")), "bad.yaml:2: the tolerance of data"),
            ((path, path, "--tolerance", self.write("path.yaml", b"/chatter:\n  dat: 1\n")), "did you mean 'data'?"),
        ):
            code, _, err = self.nacelle("bag", "diff", *words)
            self.assertEqual(code, 2, words)
            self.assertIn(expected, err)
        other = self.write("other.yaml", b"/never: {data: 1}\n")
        code, _, err = self.nacelle("bag", "diff", path, path, "--tolerance", other)
        self.assertEqual(code, 0)
        self.assertIn("neither recording has the topic /never", err)

    def test_plot_draws_fields_over_time_and_over_each_other(self):
        points = b"".join(message(1, (100 + at) * SECOND, b"\0\1\0\0" + struct.pack("<3d", 3 * at, 2.5, -at)) for at in range(5))
        path = self.write("path.mcap", bag(schema(1, "geometry_msgs/msg/Point"), channel(1, 1, "/place"), points))
        picture = self.bags / "picture.svg"
        code, out, err = self.nacelle("bag", "plot", path, "/place.x", "place.z", "-o", str(picture))
        self.assertEqual((code, out, err), (0, f"{picture}: 2 lines, 10 points\n", ""))
        root = xml.etree.ElementTree.parse(picture).getroot()
        texts = [element.text for element in root.iter(SVG + "text")]
        self.assertLessEqual({"/place.x", "/place.z", "time since the first message [s]", "0", "4.0"}, set(texts))
        self.assertEqual(len(list(root.iter(SVG + "polyline"))), 2)
        code, out, _ = self.nacelle("bag", "plot", path, "/place.z", "--x", "/place.x", "-o", str(picture))
        self.assertEqual((code, out), (0, f"{picture}: 1 line, 5 points\n"))
        (line,) = xml.etree.ElementTree.parse(picture).getroot().iter(SVG + "polyline")
        first, *_, last = (tuple(map(float, place.split(","))) for place in line.get("points").split())
        self.assertAlmostEqual((last[0] - first[0]) / (last[1] - first[1]), 3.0, delta=0.05, msg="a metre is as long on both axes")

    def test_plot_names_the_nearest_topic_and_field(self):
        path = self.write("path.mcap", bag(schema(1, "geometry_msgs/msg/Vector3"), channel(1, 1, "/place"),
                                           message(1, SECOND, b"\0\1\0\0" + struct.pack("<3d", 1, 2, 3))))  # fmt: skip
        for words, code, expected in (
            (("/plaec.x",), 1, "did you mean '/place'?"),
            (("/place.xx",), 1, "did you mean 'x'?"),
            (("/place.x", "--x", "/place.q"), 1, "its fields are x, y, z"),
            (("/place",), 2, "it is no field of a topic"),
            (("/place.x[",), 2, "a '[' has no ']'"),
        ):
            got, _, err = self.nacelle("bag", "plot", path, *words, "-o", str(self.bags / "none.svg"))
            self.assertEqual(got, code, words)
            self.assertIn(expected, err)
        code, _, err = self.nacelle("bag", "plot", TALKER, "/chatter.data", "-o", str(self.bags / "none.svg"))
        self.assertEqual(code, 1)
        self.assertIn("field data: it is a text", err)
        self.assertFalse((self.bags / "none.svg").exists())

    def test_recordings_are_merged_in_the_order_of_time(self):
        self.write("halves/halves_0.mcap", bag(talk(10, 14)))
        self.write("halves/halves_1.mcap", bag(talk(15, 19)))
        other = self.write("other.mcap", bag(talk(12, 17)))
        merged = str(self.bags / "merged.mcap")
        code, out, err = self.nacelle("bag", "merge", "-o", merged, str(self.bags / "halves"), other, "--compression", "lz4")
        self.assertEqual((code, err), (0, ""), out)
        self.assertIn("merged.mcap: 19 messages of 3 files", out)
        self.assertEqual(self.nacelle("bag", "check", merged)[0], 0)
        found = json.loads(self.nacelle("bag", "info", merged, "--json")[1])
        self.assertEqual((found["messages"], found["start_ns"], found["end_ns"]), (19, 10 * SECOND, 19 * SECOND))
        self.assertEqual([(topic["name"], topic["messages"]) for topic in found["topics"]], [("/chatter", 16), ("/secret", 3)])
        code, _, err = self.nacelle("bag", "merge", "-o", merged, other)
        self.assertEqual(code, 1)
        self.assertIn("exists already", err)

    def test_a_topic_of_two_types_is_not_merged(self):
        one = self.write("one.mcap", bag(talk(1, 3)))
        two = self.write("two.mcap", bag(schema(1, "std_msgs/msg/Int32") + channel(1, 1, "/chatter")))
        merged = self.bags / "two_types.mcap"
        code, _, err = self.nacelle("bag", "merge", one, two, "-o", str(merged))
        self.assertEqual(code, 1)
        for word in (one, two, "/chatter", "std_msgs/msg/String", "std_msgs/msg/Int32"):
            self.assertIn(word, err)
        self.assertFalse(merged.exists())

    def write_database(self, name, first, last, extra=""):
        path = self.bags / name
        path.parent.mkdir(exist_ok=True)
        database = sqlite3.connect(path)
        database.executescript(TABLES + extra)
        rows = [(1, at * SECOND, cdr_string("hello")) for at in range(first, last + 1)] + [(2, last * SECOND, b"\0\1\0\0?")]
        database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", rows)
        database.commit()
        database.close()
        return str(path)

    def test_a_database_of_rosbag2_is_read_and_converted(self):
        self.write_database("database/database_0.db3", 10, 14, DEFINITIONS)
        self.write_database("database/database_1.db3", 15, 19, DEFINITIONS)
        self.write("database/metadata.yaml", b"rosbag2_bagfile_information:\n  compression_mode: ''\n")
        code, out, err = self.nacelle("bag", "info", str(self.bags / "database"))
        self.assertEqual((code, err), (0, ""))
        for words in ("Files:             database_0.db3", "Storage id:        sqlite3\n", "Messages:          12\n",
                      "Topic: /chatter | Type: std_msgs/msg/String | Count: 10 | Serialization Format: cdr | Rate: 1.00 Hz"):  # fmt: skip
            self.assertIn(words, out)
        converted = self.bags / "database.mcap"
        code, out, err = self.nacelle("bag", "convert", str(self.bags / "database"), "-o", str(converted))
        self.assertEqual((code, err), (0, ""), out)
        self.assertIn("database.mcap: 12 of 12 messages", out)
        code, out, _ = self.nacelle("bag", "check", str(converted))
        self.assertEqual(code, 0, out)
        content = converted.read_bytes()
        self.assertIn(text("my_msgs/msg/Secret") + text("ros2msg") + text("uint8 secret"), content)
        self.assertIn(text("std_msgs/msg/String") + text("ros2msg"), content)
        self.assertIn(b"string data", content, "the definition of the type that is installed")
        self.assertIn(text("offered_qos_profiles") + text("- depth: 10"), content)
        self.assertEqual(sorted(file.name for file in (self.bags / "database").iterdir()), ["database_0.db3", "database_1.db3", "metadata.yaml"])
        merged = str(self.bags / "mixed.mcap")
        code, out, err = self.nacelle("bag", "merge", str(self.bags / "database"), self.write("third.mcap", bag(talk(12, 13))), "-o", merged)
        self.assertEqual((code, err), (0, ""), out)
        self.assertEqual(self.nacelle("bag", "check", merged)[0], 0)

    def test_a_definition_that_is_nowhere_is_named(self):
        path = self.write_database("old.db3", 1, 2)
        self.assertEqual(self.nacelle("bag", "info", path)[::2], (0, ""))
        code, out, err = self.nacelle("bag", "convert", path, "-o", str(self.bags / "old.mcap"))
        self.assertEqual(code, 0, err)
        self.assertIn("has no definition of my_msgs/msg/Secret", err)
        self.assertNotIn("std_msgs", err)
        self.assertIn("has no definition of my_msgs/msg/Secret", self.nacelle("bag", "merge", path, "-o", str(self.bags / "new.mcap"))[2])
        self.assertIn("3 of 3 messages", out)

    def test_a_database_that_cannot_be_read_says_why(self):
        def error_of(path, command="info"):
            code, _, err = self.nacelle("bag", command, path)
            self.assertEqual(code, 1)
            return err

        self.assertIn("is no SQLite 3 database", error_of(self.write("words.db3", b"no recording at all")))
        path = self.write_database("drive.db3", 1, 3)
        self.assertIn("nacelle bag convert", error_of(path, "check"))
        writer = subprocess.Popen([sys.executable, "-c", "import sqlite3, sys; db = sqlite3.connect(sys.argv[1], isolation_level=None);"
                                   "db.execute('BEGIN EXCLUSIVE'); print('locked', flush=True); sys.stdin.read()", path],
                                  stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # fmt: skip
        self.assertEqual(writer.stdout.readline(), b"locked\n")
        self.assertIn("is written by another program", error_of(path))
        writer.communicate()
        self.assertEqual(self.nacelle("bag", "info", path)[0], 0)
        database = sqlite3.connect(path)
        database.executescript("CREATE TABLE holes(id INTEGER PRIMARY KEY, topic_id, timestamp, data); INSERT INTO holes SELECT * FROM messages;"
                               "INSERT INTO holes VALUES(9, 1, NULL, NULL); DROP TABLE messages; ALTER TABLE holes RENAME TO messages")  # fmt: skip
        database.close()
        err = error_of(path)
        self.assertIn("a message has no topic, no time or no bytes (row 9)", err)
        code, out, _ = self.nacelle("bag", "recover", path)
        self.assertEqual(code, 0)
        self.assertIn("drive.recovered.mcap: 4 of 4 messages", out)
        self.write("packed/packed_0.db3", b"")
        self.write("packed/metadata.yaml", b"  compression_format: zstd\n  compression_mode: MESSAGE\n")
        self.assertIn("are compressed by rosbag2 (mode MESSAGE)", error_of(str(self.bags / "packed")))
        self.write_database("both/both_0.db3", 1, 2)
        self.write("both/both_0.mcap", bag(talk(1, 2)))
        self.assertIn("has files that end in .mcap and in .db3", error_of(str(self.bags / "both")))

    def test_what_is_no_recording_is_named(self):
        path = self.write("words.mcap", b"no recording at all")
        for command in ("info", "check", "recover"):
            code, out, err = self.nacelle("bag", command, path)
            self.assertEqual(code, 1, command)
            self.assertIn("does not begin as an MCAP file", out + err)
        self.assertFalse((self.bags / "words.recovered.mcap").exists())
        (self.bags / "empty").mkdir()
        for path, words in (("/no/such", "No such file"), (str(self.bags / "empty"), "no file that ends in .mcap or .db3"), ("/dev/null", "is no file")):
            code, _, err = self.nacelle("bag", "info", path)
            self.assertEqual(code, 1)
            self.assertIn(words, err)
        self.assertEqual(self.nacelle("bag", "recover", str(self.bags / "empty"))[0], 1)
        self.assertEqual(self.nacelle("bag", "info")[0], 2)


if __name__ == "__main__":
    unittest.main()
