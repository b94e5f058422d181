# SPDX-License-Identifier: Apache-2.0
"""The benchmarks, by name: each yields rows (id, what, value, unit, goal, baseline). A goal is a tuple ('<=', number) or None;
a value None is printed as not measured, with the reason."""
import tempfile

import graphs
from measure import median


def row(identity, what, value, unit, goal=None, baseline="", note=""):
    beside = "; ".join(text for text in (note, baseline) if text)
    return {"id": identity, "what": what, "value": value, "unit": unit, "goal": goal, "baseline": beside}


def at_most(limit):
    return ("<=", limit)


def at_least(limit):
    return (">=", limit)


def exactly(number):
    return ("==", number)


def inline(programs, say):
    say("peers in one thread: ZeroMQ inproc, GStreamer's pads, mutex and deque")
    zmq, deque = (programs.instructions("peers", peer=peer, path="inline") for peer in ("zmq", "deque"))
    gstreamer = programs.instructions("peers_gstreamer", path="inline")
    peers = f"ZeroMQ inproc {zmq:.0f}, GStreamer {gstreamer:.0f}, mutex+deque+unique_ptr {deque:.0f}"
    with programs.iceoryx() as why_not:
        if not why_not:
            peers += f", iceoryx {programs.instructions('between', what='count', peer='bare', path='inline'):.0f}"
    costs = {}
    for take, name, goal in (("const_ref", "const T&", 250), ("loan", "Loan<T>", 250), ("shared", "shared_ptr<const T>", 300)):
        say(f"instructions, {name}")
        costs[take] = programs.instructions("handover", path="inline", take=take)
        yield row("M1", f"44 B, one thread, {name}", costs[take], "Ir/message", at_most(goal), peers)
    say("instructions, four readers")
    four = programs.instructions("handover", path="inline", readers=4)
    yield row("M1", "each further reader", (four - costs["const_ref"]) / 3, "Ir/message", at_most(170))
    say("single-stepping the executor's thread")
    steps = programs.steps(path="inline")
    for key, what, goal in (("locked", "locked instructions", at_most(8)), ("clock_reads", "clock reads", at_most(2)),
                            ("instructions", "instructions with the vDSO's", None)):  # fmt: skip
        note = "" if steps else "not measured: ptrace is not allowed here"
        yield row("M1", f"{what}, const T&", steps and steps[key], "1/message", goal, "", note)
    say("mallocs, copies, system calls")
    run = programs.run("handover", path="inline", messages=20000)
    yield row("M1", "mallocs", run["mallocs"] / run["delivered"], "1/message", exactly(0), "ZeroMQ inproc 1, mutex+deque 1")
    yield row("M1", "copies", run["copies"] / run["delivered"], "1/message", exactly(0))
    calls = programs.syscalls("handover", path="inline", few=20000, many=60000)
    yield row("M1", "system calls", calls, "1/message", at_most(0.001))


def asleep(programs, say):
    say("instructions, with the peers'")
    zmq, deque = (programs.instructions("peers", peer=peer, path="asleep") for peer in ("zmq", "deque"))
    cost = programs.instructions("handover", path="asleep")
    yield row("M2", "44 B, thread to thread, reader asleep", cost, "Ir/message", at_most(500),
              f"ZeroMQ inproc {zmq:.0f}, mutex+condvar {deque:.0f}")  # fmt: skip
    say("system calls, with the peers'")
    calls = {peer: programs.syscalls("peers", peer=peer, path="asleep", few=2000, many=12000) for peer in ("zmq", "deque", "futex")}
    yield row("M2", "system calls", programs.syscalls("handover", path="asleep", few=2000, many=12000), "1/message", at_most(2.05),
              f"{programs.calls_are_counted_by}: ZeroMQ inproc {calls['zmq']:.1f}, mutex+condvar {calls['deque']:.1f}, bare futex {calls['futex']:.1f}")  # fmt: skip
    run = programs.run("handover", path="asleep", messages=20000)
    peer = programs.run("peers", peer="zmq", path="asleep", messages=20000)
    yield row("M2", "context switches", run["switches"] / run["delivered"], "1/message", at_most(2.0),
              f"ZeroMQ inproc {peer['switches'] / peer['delivered']:.1f}")  # fmt: skip
    yield row("M2", "mallocs", run["mallocs"] / run["delivered"], "1/message", exactly(0))
    for second, where in ((1, "across two CPUs"), (0, "on one CPU")):
        say(f"round trips {where}, in turn with a bare futex")
        pair = programs.run("ratios", what="wake", blocks=40, second_cpu=second)
        yield row("M2", f"p50 of a round trip {where}", pair["ratio"], "x bare", at_most(1.3), f"futex ping-pong {pair['b_ns'] / 1000:.1f} us")


def busy(programs, say):
    say("instructions, with the peers'")
    zmq, deque = (programs.instructions("peers", peer=peer, path="busy") for peer in ("zmq", "deque"))
    gstreamer = programs.instructions("peers_gstreamer", path="busy")
    cost = programs.instructions("handover", path="busy")
    yield row("M3", "44 B, thread to thread, reader busy", cost, "Ir/message", at_most(400),
              f"ZeroMQ inproc {zmq:.0f}, GStreamer queue {gstreamer:.0f}, mutex+deque {deque:.0f}")  # fmt: skip
    run = programs.run("handover", path="busy", messages=20000)
    yield row("M3", "mallocs", run["mallocs"] / run["delivered"], "1/message", exactly(0))
    say("system calls")
    yield row("M3", "system calls, the harness's own 0.01 included", programs.syscalls("handover", path="busy", few=5000, many=15000),
              "1/message", at_most(0.05))  # fmt: skip


def payload(programs, say):
    say("instructions, 64 B and 4 MB")
    small, large = (programs.instructions("handover", path="inline", bytes=n) for n in (64, 4_000_000))
    yield row("M4", "cost(4 MB) / cost(64 B), instructions", large / small, "x", at_most(1.05), f"64 B: {small:.0f} Ir")
    say("time, 64 B and 4 MB in turn")
    pair = programs.run("ratios", what="sizes", blocks=60)
    yield row("M4", "cost(4 MB) / cost(64 B), time", pair["ratio"], "x", at_most(1.10), f"64 B: {pair['b_ns']:.0f} ns")
    for size, name in ((64, "64 B"), (4_000_000, "4 MB"), (40_000_000, "40 MB")):
        say(f"readers and owners of {name}")
        messages = 2000 if size < 1_000_000 else 40
        warm = 300 if size < 1_000_000 else 40
        readers = programs.run("handover", path="inline", readers=3, bytes=size, messages=messages, warm=warm)
        yield row("M4", f"{name}, 3 readers: bytes copied", readers["bytes_copied"], "B", exactly(0))
        owners = programs.run("handover", path="inline", readers=0, owners=3, bytes=size, messages=messages, warm=warm)
        yield row("M4", f"{name}, 3 owners: copies", owners["copies"] / messages, "1/message", exactly(2))
        yield row("M4", f"{name}: page faults, 3 readers and 3 owners", (readers["faults"] + owners["faults"]) / messages, "1/message", at_most(0.01))
    say("the cloud of 33,177,600 bytes at 30 Hz, 5 s")
    # The first filling of the pool, half a gigabyte of page faults in one callback, is not what is measured here.
    run = run_graph(programs, graphs.cloud(3), 5, patience=20)
    yield row("M4", "cloud at 30 Hz, 3 readers: delivered", 100 * run["delivered"] / run["expected"], "%", (">=", 99))
    yield row("M4", "cloud: copies", run["copies"], "", exactly(0))
    yield row("M4", "cloud: late, lost", run["late"] + run["lost"], "", exactly(0))
    yield row("M4", "cloud: page faults", run["faults"] / run["seconds"], "1/s", at_most(1))


def run_graph(programs, lines, seconds, program="topology", **words):
    with tempfile.NamedTemporaryFile("w", suffix=".graph") as file:
        file.write("\n".join(lines) + "\n")
        file.flush()
        return programs.run(program, graph=file.name, seconds=seconds, **words)


def in_turn(programs, lines, seconds):
    """Composed and bare, A B B A; the runs of the container and the ratio of the medians of CPU time."""
    runs = {0: [], 1: []}
    for bare in (0, 1, 1, 0):
        runs[bare].append(run_graph(programs, lines, seconds, bare=bare))
    ratio = median([r["cpu_s"] for r in runs[0]]) / max(median([r["cpu_s"] for r in runs[1]]), 1e-6)
    return runs[0], runs[1], ratio


def total(runs, key):
    return sum(run[key] for run in runs)


def topologies(programs, say):
    seconds = 10
    for name, megabytes, others, rclcpp_mb in (("sierra_nevada", 10, "3.85, events 1.57", 22.1), ("mont_blanc", 20, "7.29, events 2.27", 25.9)):
        say(f"{name}: container, bare, bare, container, {seconds} s each")
        runs, bare, ratio = in_turn(programs, graphs.topology(name), seconds)
        per_delivery = total(bare, "switches") / total(bare, "delivered")
        yield row("M5", f"{name}: context switches", total(runs, "switches") / total(runs, "delivered"), "1/delivery", at_most(0.2),
                  f"bare program {per_delivery:.3f}")  # fmt: skip
        yield row("M5", f"{name}: delivered of what was offered", 100 * total(runs, "delivered") / total(runs, "expected"), "%", (">=", 99.9))
        yield row("M5", f"{name}: late", total(runs, "late"), "messages", exactly(0), f"of {total(runs, 'delivered'):.0f}")
        yield row("M5", f"{name}: lost", total(runs, "lost") + total(runs, "dropped"), "messages", exactly(0))
        yield row("M5", f"{name}: CPU, of 60 s", 60 * total(runs, "cpu_s") / total(runs, "seconds"), "s", None, f"rclcpp jazzy: single {others}")
        yield row("M5", f"{name}: CPU beside the bare program's", ratio, "x", at_most(1.5),
                  f"bare {60 * total(bare, 'cpu_s') / total(bare, 'seconds'):.2f} s of 60")  # fmt: skip
        yield row("M5", f"{name}: mallocs", total(runs, "mallocs") / total(runs, "delivered"), "1/delivery", at_most(0.001), "events executor 6.9")
        yield row("M6", f"{name}: RSS", runs[-1]["rss"] / 1e6, "MB", at_most(megabytes),
                  f"bare program {bare[-1]['rss'] / 1e6:.1f}; rclcpp jazzy {rclcpp_mb}")  # fmt: skip


def saturation(programs, say):
    for size, name, cpu in ((64, "64 B", at_most(10)), (1 << 20, "1 MiB", None)):
        say(f"50 topics, 51,575 messages/s of {name}: container, bare, bare, container, 5 s each")
        runs, bare, ratio = in_turn(programs, graphs.saturation(size), 5)
        yield row("M8", f"{name}: delivered of what was published", 100 * total(runs, "delivered") / total(runs, "published"), "%", (">=", 99.99))
        # A tick that finds its period over is not made up for: a busy machine shows here.
        yield row("M8", f"{name}: delivered of what was offered", 100 * total(runs, "delivered") / total(runs, "expected"), "%", (">=", 99.9),
                  f"bare {100 * total(bare, 'delivered') / total(bare, 'expected'):.2f} %; rclcpp events 99.7 %, 1 MiB 2 %")  # fmt: skip
        yield row("M8", f"{name}: dropped", total(runs, "lost") + total(runs, "dropped"), "messages", exactly(0))
        yield row("M8", f"{name}: CPU", 100 * total(runs, "cpu_s") / total(runs, "seconds"), "% of one", cpu,
                  f"bare {100 * total(bare, 'cpu_s') / total(bare, 'seconds'):.1f} %; rclcpp events 38 %")  # fmt: skip
        yield row("M8", f"{name}: CPU beside the bare program's", ratio, "x", at_most(2))
        yield row("M8", f"{name}: RSS", runs[-1]["rss"] / 1e6, "MB", None, f"bare {bare[-1]['rss'] / 1e6:.1f}")


def robot(programs, say):
    say("nine components: container, bare, bare, container, 10 s each")
    runs, bare, _ = in_turn(programs, graphs.plain_robot(), 10)
    run = runs[-1]
    yield row("M19", "plain robot: CPU", 100 * total(runs, "cpu_s") / total(runs, "seconds"), "% of one", at_most(0.45),
              f"bare {100 * total(bare, 'cpu_s') / total(bare, 'seconds'):.2f} %; rclcpp 4.0 %, best 1.8 %")  # fmt: skip
    yield row("M19", "plain robot: RSS, no DDS", run["rss"] / (1 << 20), "MiB", at_most(10), f"bare {bare[-1]['rss'] / (1 << 20):.1f}; rclcpp 21.9, best 19.7")
    yield row("M19", "plain robot: not backed by a file", run["rss_anon"] / (1 << 20), "MiB", None, "rclcpp 6.8 private")
    yield row("M19", "plain robot: mallocs", run["mallocs"] / run["seconds"], "1/s", exactly(0))
    yield row("M19", "plain robot: context switches", run["switches"] / run["seconds"], "1/s", None, "rclcpp 289")
    yield row("M19", "plain robot: late, lost", total(runs, "late") + total(runs, "lost") + total(runs, "dropped"), "messages", exactly(0))
    yield from robot_on_network(programs, say)


def robot_on_network(programs, say):
    say("nine components with the services of ROS 2 nodes, on the network without a peer: with, without, without, with, 10 s each")
    on, off = [], []
    for runs in (on, off, off, on):
        runs.append(run_graph(programs, graphs.plain_robot(), 10, "topology_on_network", network=int(runs is on)))
    yield row("M19", "on the network: CPU", 100 * total(on, "cpu_s") / total(on, "seconds"), "% of one", at_most(0.45),
              f"the same program off it {100 * total(off, 'cpu_s') / total(off, 'seconds'):.2f} %")  # fmt: skip
    yield row("M19", "on the network: RSS", on[-1]["rss"] / (1 << 20), "MiB", at_most(14), f"off it {off[-1]['rss'] / (1 << 20):.1f}")
    # 120 services with two each, 26 writers and 5 readers of topics, and the two that announce nodes.
    endpoints = 273
    bare = programs.run("bare_endpoints", endpoints=endpoints)
    least = (off[-1]["rss"] + bare["participant"] + bare["endpoints"]) / (1 << 20)
    yield row("M19", f"off the network, and what plain Cyclone keeps for {endpoints} endpoints", least, "MiB", None,
              f"participant {bare['participant'] / (1 << 20):.1f}, endpoints {bare['endpoints'] / endpoints / 1024:.1f} KiB each")  # fmt: skip
    yield row("M19", "on the network: not backed by a file", on[-1]["rss_anon"] / (1 << 20), "MiB", None, f"off it {off[-1]['rss_anon'] / (1 << 20):.1f}")
    yield row("M19", "on the network: mallocs, all of them Cyclone's announcements", total(on, "mallocs") / total(on, "seconds"), "1/s", exactly(0))
    yield row("M19", "on the network: late, lost", total(on, "late") + total(on, "lost") + total(on, "dropped"), "messages", exactly(0))


def loading(programs, say, cycles=1000):
    say(f"{cycles} times load, configure, activate, deactivate, cleanup, unload")
    rows = programs.soak(cycles)
    if rows is None:
        yield row("M20", "load, unload", None, "us", at_most(1000), "", "not measured: there is no program soak-load")
        return
    yield from rows
    if not programs.has("bare_endpoints"):
        return
    say("the same on a network, alone there and with another participant")
    for peers in (0, 1):
        yield from (one for one in programs.soak(cycles, peers) if "lateness" not in one["what"] and "ticks" not in one["what"])
    kept = programs.run("bare_endpoints", endpoints=2)["kept_of_each"]
    yield row("M20", "plain Cyclone keeps of each endpoint that comes and goes", kept, "B", None, "its issue 1487; the container frees it")


def soak(programs, say):
    yield from loading(programs, say, 10_000)


def between(programs, say):
    say("the plain robot: one container, ten processes, ten processes, one container, 10 s each")
    runs = {0: [], 1: []}
    for apart in (0, 1, 1, 0):
        runs[apart].append(run_graph(programs, graphs.plain_robot(), 10, apart=apart))
    one, ten = runs[0], runs[1]
    yield row("M7", "one container beside ten processes: CPU", total(one, "cpu_s") / max(total(ten, "cpu_s"), 1e-6), "x", at_most(0.35),
              f"rclcpp 0.35; ten: {100 * total(ten, 'cpu_s') / total(ten, 'seconds'):.1f} % of one CPU")  # fmt: skip
    yield row("M7", "one container beside ten processes: PSS", total(one, "pss") / max(total(ten, "pss"), 1), "x", at_most(0.20),
              f"rclcpp 0.33; ten: {ten[-1]['pss'] / (1 << 20):.1f} MiB")  # fmt: skip
    yield row("M7", "ten processes: lost", total(ten, "lost") + total(ten, "dropped"), "messages", exactly(0), f"of {total(ten, 'delivered'):.0f}")
    with programs.iceoryx() as why_not:
        if why_not:
            yield row("M13", "between processes, beside bare iceoryx", None, "x", at_most(1.10), "", f"not measured: {why_not}")
        else:
            yield from shared_memory(programs, say)


def shared_memory(programs, say):
    """The carrier of transport_iceoryx beside the same messages by iceoryx's own publisher and listener."""
    say("instructions of a message by iceoryx's carrier, and by iceoryx alone")
    carried, bare = (programs.instructions("between", what="count", peer=peer) for peer in ("carried", "bare"))
    yield row("M13", "44 B, writer to sleeping reader, instructions", carried / bare, "x bare", at_most(1.10),
              f"{carried:.0f} Ir; iceoryx with a Listener {bare:.0f}")  # fmt: skip
    for size, name in ((44, "44 B"), (65_536, "64 KiB"), (1_048_576, "1 MiB"), (4_194_304, "4 MiB")):
        say(f"{name} between two processes, in turn with bare iceoryx")
        run = programs.run("between", bytes=size, blocks=60)
        yield row("M13", f"{name} between two processes, written, sent, read, answered", run["ratio"], "x bare", at_most(1.10),
                  f"bare {run['b_ns'] / 1000:.1f} us")  # fmt: skip
        if size > 44:
            copied = run["copied_per_message"] + run["copied_by_reader_per_message"]
            yield row("M13", f"{name}: bytes copied beside the one write", copied, "B/message", exactly(0))
    say("4 MiB in messages that were not prepared")
    run = programs.run("between", bytes=4_194_304, blocks=20, prepared=0)
    yield row("M13", "4 MiB, not prepared: copied once by the writer", run["ratio"], "x bare", None,
              f"{run['copied_per_message']:.0f} B/message by the writer, {run['copied_by_reader_per_message']:.0f} by the reader")  # fmt: skip


def teleop(programs, say):
    say("a gamepad's stick moves 600 times, beside the camera")
    run = programs.run("teleop", moves=600)
    how = "" if run["real_time"] else "without real-time priority, "
    yield row("teleop", "from a gamepad's stick to the motor board's line, p99", run["p99_ms"], "ms", at_most(40),
              "the base writes every 20 ms", f"{how}p50 {run['p50_ms']:.1f} ms, largest {run['max_ms']:.1f} ms")  # fmt: skip
    yield row("teleop", "moves that did not reach it", run["lost"], "moves", exactly(0), f"of {run['moves']:.0f}")


def control_loop(programs, say):
    say("the base's control loop at 1 kHz, without a line: system calls")
    calls = programs.syscalls("devices", what="loop", few=1000, many=3000)
    yield row("M9", "1 kHz control loop: system calls beside the line's", calls, "1/cycle", at_most(1.02), "cyclictest 1")
    say("20 s, in turn with a thread that only sleeps")
    run = programs.run("devices", what="loop", messages=10_000, compares=1)
    yield row("M9", "mallocs", run["mallocs"], "", exactly(0), f"{run['cycles']:.0f} cycles")
    yield row("M9", "page faults", run["faults"] / run["cycles"], "1/cycle", at_most(0.001))
    yield row("M9", "lateness of a cycle, p99.9, without real-time priority", run["p999_us"] / run["bare_p999_us"], "x bare", at_most(1.2),
              f"a thread that only sleeps: {run['bare_p999_us']:.0f} us; {run['skipped']:.0f} cycles skipped")  # fmt: skip


def camera(programs, say):
    say("a JPEG of 1280 x 720, in turn with libjpeg-turbo's own loop")
    run = programs.run("devices", what="jpeg", blocks=40)
    yield row("M15", "JPEG of 1280 x 720, decoded and checked", run["ratio"], "x bare", at_most(1.05), f"libjpeg-turbo, a row a call: {run['b_ns'] / 1e6:.2f} ms")
    yield row("M15", "mallocs of a decoded JPEG", run["mallocs"], "", exactly(0))
    yield row("M15", "JPEGs refused", run["refused"], "", exactly(0))


def lidar(programs, say):
    say("instructions of an LD06's bytes")
    for assembles, what, goal in ((0, "found and checked", at_most(12)), (1, "made into scans", None)):
        cost = programs.instructions("devices", what="ld06", assembles=assembles) / 47
        yield row("M16", f"LD06: {what}", cost, "Ir/byte", goal)
    run = programs.run("devices", what="ld06", messages=37_500, assembles=1)
    yield row("M16", "mallocs of 100 s", run["mallocs"], "", exactly(0), f"{run['scans']:.0f} scans")
    yield row("M16", "packets lost on an undisturbed line", run["lost"], "", exactly(0))


def late(programs, say):
    say("instructions of the EKF's going back")
    back = programs.run("filter", messages=3000, late_ms=350, runs=1)
    steps = programs.instructions("filter", few=1000, many=3000, late_ms=350, runs=1) - programs.instructions("filter", few=1000, many=3000, runs=1)
    yield row("M10", "a measurement taken again", steps * 3000 / back["replayed"], "Ir", None, f"{back['replayed'] / back['passes']:.0f} for a pose that is 0.35 s late")
    yield row("M10", "mallocs of a minute with late poses", back["mallocs"], "", exactly(0))
    for words, what in (({"late_ms": 350}, "poses 0.35 s late"), ({"burst": 1}, "poses of 2 s at once"),
                        ({"burst": 1, "gyro_hz": 1000}, "poses of 2 s at once, a gyro of 1 kHz")):  # fmt: skip
        say(f"the EKF's steps with {what}")
        plain, run = (programs.run("filter", messages=2000, smooths=smooths, **words) for smooths in (0, 1))
        yield row("M10", f"longest step more than without a history, {what}", run["longest_us"] - plain["longest_us"], "us", at_most(1000), f"a mean of {run['mean_us']:.0f} us; {run['continued']:.0f} passes over several steps")


def recording(programs, say):
    for place, folder, megabytes in (("the disk", ".", 64), ("memory", "/dev/shm", 64)):
        for size, what in ((1 << 20, "1 MiB"), (1000, "1 kB")):
            say(f"a recording of messages of {what} in {place}, in turn with a loop of write()")
            run = programs.run("recording", folder=folder, megabytes=megabytes, bytes=size)
            goal = at_least(0.9) if place == "the disk" else None
            yield row("M17", f"recording in {place}, messages of {what}: speed", run["speed"], "x write()", goal, f"{run['mb_per_s']:.0f} MB/s")
            yield row("M17", f"mallocs of a message of {what}, in {place}", run["mallocs"], "", at_most(0.01))
    say("messages of 1 MiB at 0.8 times the disk's rate")
    run = programs.run("recording", folder=".", megabytes=256, paced=1)
    yield row("M17", "messages lost at 0.8 times the disk's rate", run["lost"], "", exactly(0), f"of {run['messages']:.0f}, {run['mb_per_s']:.0f} MB/s")
    say("instructions of a publisher for a recorder")
    alone, recorded = (programs.instructions("recording", publish=1, reader=reader) for reader in (0, 1))
    yield row("M17", "a publisher's instructions for a recorder that is late", recorded - alone, "Ir/message", at_most(170), f"alone {alone:.0f}")


def wire(programs, say):
    say("a stream of this process with the network beside it, without a remote reader")
    for size, name in ((0, "44 B"), (900_000, "0.9 MB")):
        alone, beside = (programs.instructions("wire", few=20_000, many=220_000, mirror=mirror, bytes=size) for mirror in (0, 1))
        yield row("M14", f"{name}, no remote reader: instructions more", beside - alone, "Ir/message", at_most(5), f"alone {alone:.1f}")
    calls = programs.syscalls("wire", few=100_000, many=1_100_000, mirror=1)
    yield row("M14", "no remote reader: system calls", calls, "1/message", at_most(0.001))
    run = programs.run("wire", mirror=1, messages=100_000)
    yield row("M14", "no remote reader: mallocs", run["mallocs"] / run["delivered"], "1/message", at_most(0.001))
    yield row("M14", "no remote reader: messages fetched or encoded", run["encoded"] + run["taps"], "", exactly(0))
    for size, name in ((44, "44 B"), (900_000, "0.9 MB")):
        say(f"{name} from one participant to another over lo, in turn with dds_write and dds_take of plain Cyclone")
        run = programs.run("crossing", bytes=size, blocks=40)
        yield row("M14", f"{name}, published here, taken there", run["ratio"], "x bare", at_most(1.10), f"bare Cyclone {run['b_ns'] / 1000:.1f} us")
        yield row("M14", f"{name}: serialisations", run["encoded_per_message"], "1/message", exactly(1))


BENCHMARKS = {
    "m1-inline": inline,
    "m2-asleep": asleep,
    "m3-busy": busy,
    "m4-payload": payload,
    "m5-m6-topologies": topologies,
    "m7-m13-between-processes": between,
    "m8-saturation": saturation,
    "m9-control-loop": control_loop,
    "m10-late": late,
    "m14-wire": wire,
    "m15-camera": camera,
    "m16-lidar": lidar,
    "m17-recording": recording,
    "m19-robot": robot,
    "m20-loading": loading,
    "teleop": teleop,
}
# Run only when they are named.
ON_REQUEST = {"soak-load": soak}
