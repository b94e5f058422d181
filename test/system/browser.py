# SPDX-License-Identifier: Apache-2.0
"""Chromium without a window, driven by the DevTools protocol over two pipes, so that nothing but Debian's `chromium` is needed."""
import base64
import contextlib
import fcntl
import json
import os
import pathlib
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

from robot import SLOW

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
LIMIT_S = 30.0
MOVE = "import os, sys; os.dup2(int(sys.argv[1]), 3); os.dup2(int(sys.argv[2]), 4); os.execv(sys.argv[3], sys.argv[3:])"


class Browser:
    """One page. Its folder is removed at the end."""

    def __init__(self, width, height, is_phone=False):
        self.folder = tempfile.mkdtemp(prefix="nacelle-browser-")
        to_browser, self.writer = os.pipe()
        self.reader, from_browser = os.pipe()
        # The browser reads descriptor 3 and writes descriptor 4. MOVE puts them there, from numbers that are neither.
        moved = [fcntl.fcntl(descriptor, fcntl.F_DUPFD, 10) for descriptor in (to_browser, from_browser)]
        words = [CHROMIUM, "--headless=new", "--no-sandbox", "--remote-debugging-pipe", f"--user-data-dir={self.folder}", "--no-first-run",
                 "--disable-gpu", "--disable-dev-shm-usage", "--disable-extensions", "--disable-background-networking", "--mute-audio",
                 "about:blank"]  # fmt: skip
        self.process = subprocess.Popen(
            [sys.executable, "-c", MOVE, *map(str, moved), *words], pass_fds=moved,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        for descriptor in (to_browser, from_browser, *moved):
            os.close(descriptor)
        self.answers, self.waiting, self.next_id, self.session = queue.Queue(), {}, 1, None
        self.complaints = []  # what the page wrote to its console as errors
        threading.Thread(target=self._listen, daemon=True).start()
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.target = target
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.resize(width, height, is_phone)

    def _listen(self):
        rest = b""
        while True:
            try:
                chunk = os.read(self.reader, 1 << 20)
            except OSError:
                break
            if not chunk:
                break
            *frames, rest = (rest + chunk).split(b"\0")
            for frame in frames:
                self._take(json.loads(frame))
        self.answers.put(None)

    def _take(self, message):
        if "id" in message:
            self.answers.put(message)
        elif message["method"] == "Runtime.exceptionThrown":
            details = message["params"]["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description") or details["text"])
        elif message["method"] == "Log.entryAdded" and message["params"]["entry"]["level"] == "error":
            self.complaints.append(message["params"]["entry"]["text"])

    def call(self, method, **parameters):
        request = {"id": self.next_id, "method": method, "params": parameters}
        self.next_id += 1
        if self.session:
            request["sessionId"] = self.session
        os.write(self.writer, json.dumps(request).encode() + b"\0")
        while True:
            answer = self.answers.get(timeout=LIMIT_S * SLOW)
            if answer is None:
                raise AssertionError("the browser ended")
            if answer["id"] == request["id"]:
                if "error" in answer:
                    raise AssertionError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def run(self, script):
        """The value of an expression in the page; promises are waited for."""
        result = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            raise AssertionError(result["exceptionDetails"].get("exception", {}).get("description", "the script failed"))
        return result["result"].get("value")

    def open(self, address):
        self.call("Page.navigate", url=address)

    def resize(self, width, height, is_phone=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=is_phone)
        self.call("Emulation.setTouchEmulationEnabled", enabled=is_phone)
        self.is_phone = is_phone

    def pointer(self, kind, x, y):
        """`kind`: press, move or release, of a finger on a phone and of the mouse elsewhere."""
        if self.is_phone:
            points = [] if kind == "release" else [{"x": x, "y": y}]
            self.call("Input.dispatchTouchEvent", type={"press": "touchStart", "move": "touchMove", "release": "touchEnd"}[kind], touchPoints=points)
            return
        name = {"press": "mousePressed", "move": "mouseMoved", "release": "mouseReleased"}[kind]
        self.call("Input.dispatchMouseEvent", type=name, x=x, y=y, button="left", buttons=int(kind != "release"), clickCount=1)

    def picture(self, file):
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        pathlib.Path(file).write_bytes(data)
        return data

    def close_page(self):
        session, self.session = self.session, None
        self.call("Target.closeTarget", targetId=self.target)
        return session

    def close(self):
        with contextlib.suppress(OSError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        for descriptor in (self.reader, self.writer):
            with contextlib.suppress(OSError):
                os.close(descriptor)
        shutil.rmtree(self.folder, ignore_errors=True)
