"""A client of plumblined's state socket, and a simulated printer to talk to."""

import json
import os
import queue
import socket
import subprocess
import threading
import time

from case import PLUMBLINED, SIM2K, SOURCE_DIR, Program, confirm_plate, write_sphere

try:
    from jsonschema import Draft202012Validator
except ImportError:
    Draft202012Validator = None


def closed(schema):
    """@returns the schema without room for members that it does not name: clients ignore such, but the printer must not send any"""
    if isinstance(schema, list):
        return [closed(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    parts = {key: closed(part) for key, part in schema.items()}
    return {"additionalProperties": False, **parts} if "properties" in schema else parts


SCHEMA = closed(json.loads((SOURCE_DIR / "firmware/state/state.schema.json").read_text()))
SECONDS = 180  # only what goes wrong takes as long


def same_age(folder):
    """Makes all files of a stick equally old, so that their list is sorted by name."""
    for path in folder.rglob("*"):
        os.utime(path, (1.7e9, 1.7e9), follow_symlinks=False)


class Client:
    """A connection. All states that it receives are checked against the schema and kept."""

    def __init__(self, test, path, eager=False):
        """
        @param eager  read whatever the test does meanwhile: a client that takes nothing for 10 s is dropped, and on a busy machine any step may take
                      that long
        """
        self.test, self.states, self.replies, self.rest, self.asked = test, [], [], b"", 0
        self.socket = socket.socket(socket.AF_UNIX)
        test.addCleanup(self.socket.close)
        self.socket.connect(str(path))
        self.come = queue.SimpleQueue() if eager else None
        if eager:
            threading.Thread(target=self.read_all, daemon=True).start()
        self.check = Draft202012Validator(SCHEMA) if Draft202012Validator else None

    def read_all(self):
        data = b"-"
        while data:
            try:
                data = self.socket.recv(1 << 20)
            except OSError:
                data = b""
            self.come.put(data)

    def next_bytes(self, seconds):
        if self.come is None:
            self.socket.settimeout(seconds)
            return self.socket.recv(1 << 20)
        try:
            data = self.come.get(timeout=seconds)
        except queue.Empty:
            raise TimeoutError from None
        if not data:
            self.come.put(data)  # the end stays the end
        return data

    def receive(self, end):
        """Takes what has come, waiting for it until `end`. @returns False at the end of the connection"""
        data = self.next_bytes(max(0.01, end - time.monotonic()))
        *lines, self.rest = (self.rest + data).split(b"\n")
        for line in lines:
            value = json.loads(line)
            if self.check:
                self.check.validate(value)
            (self.states if value["type"] == "state" else self.replies).append(value)
        return bool(data)

    def until(self, holds, what):
        """Waits for a state. States that came before the call count only if none came since."""
        end, seen = time.monotonic() + SECONDS, max(0, len(self.states) - 1)
        while time.monotonic() < end:
            for state in self.states[seen:]:
                seen += 1
                if holds(state):
                    return state
            try:
                if not self.receive(end):
                    break
            except TimeoutError:
                break
        return self.test.fail(f"{what}: {[(s['state'], s['message']) for s in self.states[-5:]]}")

    def state(self, name, command=None):
        return self.until(lambda s: s["state"] == name and (not command or command in s["commands"]), name)

    def ask(self, do, **members):
        """@returns the reply"""
        self.asked += 1
        self.socket.sendall(json.dumps({"do": do, "id": self.asked, **members}).encode() + b"\n")
        end = time.monotonic() + SECONDS
        while not self.replies or self.replies[-1]["id"] != self.asked:
            self.test.assertTrue(self.receive(end), "the daemon ended the connection")
        return self.replies[-1]

    def do(self, do, **members):
        reply = self.ask(do, **members)
        while not reply["ok"] and reply["told"]["code"] == "answer_soon":  # what it asks has just come
            time.sleep(0.2)
            reply = self.ask(do, **members)
        self.test.assertTrue(reply["ok"], reply)

    def refused(self, words, do, **members):
        reply = self.ask(do, **members)
        self.test.assertFalse(reply["ok"])
        self.test.assertIn(words, reply["error"])


class StatePrinter(Program):
    """A simulated printer with a stick and a state socket."""

    def setUp(self):
        super().setUp()
        self.stick, self.folder = self.dir / "stick", self.dir / "state"
        self.path = self.folder / "state"
        self.commands = self.folder / "state.command"

    def start(self, *arguments, speedup=200, plate=True, printer=SIM2K, eager=False):
        self.folder.mkdir(exist_ok=True)
        if plate:
            confirm_plate(self.folder)
        command = [PLUMBLINED, "--printer", printer, "--state", self.folder, "--stick", self.stick, "--speedup", speedup, *arguments]
        daemon = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            try:
                return daemon, Client(self, self.commands, eager)
            except OSError:
                time.sleep(0.02)
        return self.fail("no socket")

    def put_stick(self, scans, text=None, points=5000):
        """@param scans  name -> radius in mm, or bytes"""
        folder = self.dir / "new"
        folder.mkdir()
        for name, what in scans.items():
            if isinstance(what, bytes):
                (folder / name).write_bytes(what)
            else:
                write_sphere(folder / name, points=points, radius=what)
        if text:
            (folder / "job.toml").write_text(text)
        same_age(folder)
        folder.rename(self.stick)
