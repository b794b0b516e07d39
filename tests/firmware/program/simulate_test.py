#!/usr/bin/env python3
"""`plumbline simulate`: one command opens a printer with page and stick folder, and leaves nothing behind."""

import json
import re
import shutil
import signal
import socket
import subprocess
import time
import unittest
import urllib.request
from pathlib import Path

from case import PLUMBLINE, PROGRAMS, Program, main, write_sphere


@unittest.skipUnless((PROGRAMS / "plumbline-page").exists(), "no plumbline-page")
class Simulate(Program):
    def simulate(self, *arguments):
        """@returns (the program, the address of its page, its stick folder)"""
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        program = subprocess.Popen([PLUMBLINE, "simulate", "--port", str(port), "--speed", "600", *map(str, arguments)],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.stderr.close)
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        said = [program.stdout.readline() for _ in range(4)]
        self.assertIn("Ctrl-C", said[3], program.stderr.read() if program.poll() is not None else said)
        address = re.search(r"http://\S+", said[0])[0]
        self.origin = address.rstrip("/")
        return program, address, Path(said[1].split(maxsplit=2)[2].strip())

    def ask(self, address, body=None, token=""):
        headers = {} if body is None else {"Content-Type": "application/json", "Origin": self.origin, "Plumbline-Token": token}
        request = urllib.request.Request(address, None if body is None else json.dumps(body).encode(), headers)
        with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=30) as reply:
            return json.load(reply)

    def until(self, address, holds):
        end, state = time.monotonic() + 60, None
        while time.monotonic() < end:
            state = self.ask(address + "state")
            if holds(state):
                return state
            time.sleep(0.05)
        return self.fail(f"{state['state']}: {state['message']}")

    def test_a_scan_that_is_dropped_is_offered_and_printed(self):
        program, address, stick = self.simulate()
        self.assertEqual(self.until(address, lambda s: s["state"] == "idle")["stick"]["present"], False)
        write_sphere(self.scan, points=5000, radius=2)
        shutil.copy(self.scan, stick / "first.ply")
        self.until(address, lambda s: s["state"] == "offered" and len(s["stick"]["scans"]) == 1)
        shutil.copy(self.scan, stick / "second.ply")
        self.until(address, lambda s: s["state"] == "offered" and len(s["stick"]["scans"]) == 2)
        token = self.ask(address + "pair", {})["token"]
        self.assertTrue(self.ask(address + "command", {"do": "start"}, token)["ok"])
        self.until(address, lambda s: s["state"] == "offered" and s["masks"])
        self.assertTrue(self.ask(address + "command", {"do": "start"}, token)["ok"])
        self.until(address, lambda s: s["state"] == "plate in use" and s["job"]["result"] == "finished")
        self.assertGreater((stick.parent / "screen/screen.png").stat().st_size, 500)
        for file in list(stick.iterdir()):
            file.unlink()
        self.until(address, lambda s: not s["stick"]["present"])
        program.send_signal(signal.SIGINT)
        self.assertEqual(program.wait(30), 0)
        self.assertFalse(stick.parent.exists(), "nothing is left")
        with self.assertRaises(OSError):
            urllib.request.urlopen(address, timeout=5)

    def test_a_named_folder_is_kept_with_its_changes(self):
        write_sphere(self.scan, points=5000, radius=2)
        folder = self.dir / "kept"
        program, address, stick = self.simulate(self.scan, "--folder", folder)
        self.until(address, lambda s: s["state"] == "offered")
        self.assertEqual(stick, folder / "stick")
        program.send_signal(signal.SIGTERM)
        self.assertEqual(program.wait(30), 0)
        self.assertTrue((folder / "stick/sphere.ply").exists())
        self.assertFalse((folder / "state/stick").is_symlink())

    def test_what_is_wrong_is_said(self):
        self.assertIn("no printer is called", self.run_it("simulate", "--printer", "sim3k", status=1).stderr)
        self.assertIn("none.ply", self.run_it("simulate", self.dir / "none.ply", status=1).stderr)
        with socket.create_server(("127.0.0.1", 0)) as taken:
            done = self.run_it("simulate", "--port", taken.getsockname()[1], status=1)
        self.assertIn("Address already in use", done.stderr)
        self.assertIn("plumbline-page has ended", done.stderr)


if __name__ == "__main__":
    main()
