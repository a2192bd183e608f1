# SPDX-License-Identifier: LGPL-3.0-or-later
"""A headless Chromium that opens a page, asked over its debugging pipe (DevTools protocol).

No library: messages are JSON that ends with a zero byte, on the descriptors 3 and 4.
"""

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--remote-debugging-pipe",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
    "--no-first-run", "--disable-background-networking", "--disable-component-update",
)  # fmt: skip


def chromium() -> str | None:
    """Path of a Chromium, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """A page in a browser of a width [pixels]; a context manager.

    faults : messages of the console that are errors, exceptions, requests of the network
    """

    def __init__(self, path: Path, width: int, height: int = 900, patience: float = 120.0):
        self._profile = tempfile.mkdtemp()
        to_read, self._out = os.pipe()
        self._in, to_write = os.pipe()

        # the browser's own ends become its descriptors 3 and 4
        move = f'exec 3<&{to_read} 4>&{to_write}; exec "$0" "$@"'
        command = [chromium(), *FLAGS, f"--user-data-dir={self._profile}", "about:blank"]
        self._process = subprocess.Popen(
            ["bash", "-c", move, *command],
            pass_fds=(to_read, to_write),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self._rest, self._count, self._session, self._patience = b"", 0, None, patience
        self.faults: list[str] = []
        self._answers: dict[int, dict] = {}
        target = self._ask("Target.createTarget", url="about:blank")["targetId"]
        found = self._ask("Target.attachToTarget", targetId=target, flatten=True)
        self._session = found["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._ask(f"{domain}.enable")
        self._size(width, height)
        self._ask("Page.navigate", url=Path(path).resolve().as_uri())
        self.wait("document.body && document.body.dataset.ready === 'yes'")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        os.close(self._in)
        os.close(self._out)
        shutil.rmtree(self._profile, ignore_errors=True)

    def _size(self, width, height):
        self._ask(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=False,
        )  # fmt: skip

    def _ask(self, method, **parameters):
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + self._patience
        while self._count not in self._answers:
            self._listen(end)
        answer = self._answers.pop(self._count)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def _listen(self, end):
        ready, _, _ = select.select([self._in], [], [], max(0.0, end - time.monotonic()))
        if not ready:
            raise TimeoutError(f"the browser does not answer; faults so far: {self.faults}")
        read = os.read(self._in, 1 << 20)
        if not read:
            raise RuntimeError("the browser has ended")
        *whole, self._rest = (self._rest + read).split(b"\0")
        for text in whole:
            self._take(json.loads(text))

    def _take(self, message):
        if "id" in message:
            self._answers[message["id"]] = message
            return
        method, about = message["method"], message["params"]
        if method == "Runtime.consoleAPICalled" and about["type"] in ("error", "assert"):
            self.faults.append(f"console: {about['args']}")
        elif method == "Runtime.exceptionThrown":
            self.faults.append(f"exception: {about['exceptionDetails']}")
        elif method == "Log.entryAdded" and about["entry"]["level"] == "error":
            self.faults.append(f"log: {about['entry']['text']}")
        elif method == "Network.requestWillBeSent":
            url = about["request"]["url"]
            if not url.startswith(("file:", "data:", "blob:")):
                self.faults.append(f"request: {url}")

    def run(self, script: str):
        """Value of an expression of JavaScript; a promise is waited for."""
        found = self._ask(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in found:
            raise RuntimeError(found["exceptionDetails"])
        return found["result"].get("value")

    def wait(self, condition: str) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + self._patience
        while not self.run(f"Boolean({condition})"):
            if time.monotonic() > end:
                raise TimeoutError(f"never: {condition}; faults: {self.faults}")
            time.sleep(0.1)

    def picture(self) -> bytes:
        """The whole page as PNG."""
        found = self._ask("Page.captureScreenshot", format="png", captureBeyondViewport=True)
        return base64.b64decode(found["data"])

    def printed(self) -> bytes:
        """The page as PDF, with its own size of paper."""
        found = self._ask("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
        return base64.b64decode(found["data"])
