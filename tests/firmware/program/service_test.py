#!/usr/bin/env python3
"""plumblined as its service manager sees it: the messages on NOTIFY_SOCKET, in every phase of a print."""

import os
import signal
import socket
import struct
import subprocess
import time
from pathlib import Path

from case import PLUMBLINE, PLUMBLINED, Program, confirm_plate, main, on_stick_printer, write_sphere

WATCHDOG_S = 0.04
# Longer phases must contain a sign of life. Shorter ones need not, since the daemon may have had no processor.
LONG_PHASE_S = 5 * WATCHDOG_S
SO_TIMESTAMP = 29  # Linux; Python has no name for it


class Service(Program):
    def setUp(self):
        super().setUp()
        self.stick, self.state = self.dir / "stick", self.dir / "state"
        self.printer = on_stick_printer(self.dir)
        confirm_plate(self.state)
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.socket.close)
        self.socket.bind(str(self.dir / "notify"))
        self.socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMP, 1)
        self.messages, self.sent_at = [], 0.0

    def start(self, *arguments, speedup=20, **environment):
        command = [PLUMBLINED, "--printer", self.printer, "--state", self.state, "--stick", self.stick]
        command += ["--speedup", speedup, *arguments]
        asked = {"NOTIFY_SOCKET": str(self.dir / "notify"), "WATCHDOG_USEC": str(int(WATCHDOG_S * 1e6)), **environment}
        daemon = subprocess.Popen(list(map(str, command)), env={**os.environ, **asked}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(daemon.stderr.close)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        return daemon

    def until(self, words):
        """Receives messages until one has the words. @returns the ones before it"""
        before, end = [], time.monotonic() + 60
        while time.monotonic() < end:
            self.socket.settimeout(max(0.01, end - time.monotonic()))
            try:
                data, (stamp, *_), *_ = self.socket.recvmsg(4096, 64)
            except TimeoutError:
                break
            message = data.decode()
            # Take the time of sending, since this test may read the message later.
            seconds, microseconds = struct.unpack("ll", stamp[2][:16])
            self.sent_at = seconds + 1e-6 * microseconds
            self.messages.append(message)
            if words in message:
                return before
            before.append(message)
        return self.fail(f"{words} was not sent; last: {[text for text in self.messages if text != 'WATCHDOG=1'][-10:]}")

    def put_stick(self, points):
        folder = self.dir / "new"
        folder.mkdir()
        write_sphere(folder / "ball.ply", points=points, radius=6)
        folder.rename(self.stick)

    def test_every_phase_of_a_print_shows_life_and_a_pause_says_why(self):
        daemon = self.start("--fault", "cover.opens@layer=2,for=20s")
        self.until("READY=1")
        self.until("STATUS=ready: waiting for a stick")
        phase, since, long_phases = "waiting", self.sent_at, 0
        time.sleep(3 * WATCHDOG_S)
        self.put_stick(100_000)
        for next_phase in ("reading ball.ply", "checks", "homing", "layer 1 of", "layer 2 of", "the cover is open", "press start"):
            lived = self.until(next_phase).count("WATCHDOG=1")
            if self.sent_at - since > LONG_PHASE_S:
                self.assertGreater(lived, 0, f"in {self.sent_at - since:.2f} s of {phase}")
                long_phases += 1
            phase, since = next_phase, self.sent_at
        self.assertGreaterEqual(long_phases, 2)
        # Also while paused.
        self.until("WATCHDOG=1")
        self.until("WATCHDOG=1")
        daemon.send_signal(signal.SIGTERM)
        self.until("STOPPING=1")
        self.until("STATUS=suspended")
        self.assertEqual(daemon.wait(60), 0)
        self.assertEqual([text for text in self.messages if "READY" in text or "STOPPING" in text], ["READY=1", "STOPPING=1"])

    def is_quiet(self, seconds):
        """Drops what has arrived. @returns whether nothing arrives for that long"""
        self.socket.setblocking(False)
        try:
            while self.socket.recv(4096):
                pass
        except BlockingIOError:
            pass
        time.sleep(seconds)
        try:
            return not self.socket.recv(4096)
        except BlockingIOError:
            return True

    def test_a_hanging_loop_shows_no_life(self):
        # Writing a report that nobody reads blocks the daemon's main thread, while others run on.
        report = self.state / "report.json.new"
        os.mkfifo(report)
        self.start(speedup=1e6)
        self.put_stick(5_000)
        self.until("STATUS=finished")
        self.assertTrue(self.is_quiet(10 * WATCHDOG_S))
        self.assertIn('"state": "finished"', report.read_text())
        self.until("STATUS=is the plate empty?")
        self.until("WATCHDOG=1")

    def child_of(self, daemon):
        """The process that reads the daemon's scan: a child of its template."""
        def children(pid):
            return map(int, Path(f"/proc/{pid}/task/{pid}/children").read_text().split())

        end = time.monotonic() + 60
        while time.monotonic() < end:
            for template in children(daemon.pid):
                for child in children(template):
                    return child
        return self.fail("no child")

    def test_a_reader_that_crashes_is_an_error_of_its_scan(self):
        daemon = self.start(speedup=1e6)
        self.until("READY=1")
        self.put_stick(200_000)
        self.until("STATUS=slicing: read")
        child = self.child_of(daemon)
        status = Path(f"/proc/{child}/status").read_text()
        for line in ("CapEff:\t0000000000000000", "NoNewPrivs:\t1"):
            self.assertIn(line, status)
        os.kill(child, signal.SIGSEGV)
        self.until("PL-102")
        (self.stick / "ball.ply").unlink()
        self.stick.rmdir()
        self.until("WATCHDOG=1")
        self.until("WATCHDOG=1")
        self.put_stick(5_000)
        self.until("STATUS=finished")

    def test_a_template_that_is_stopped_in_an_archives_print_keeps_nobody_waiting(self):
        scan, part = self.dir / "ball.ply", self.dir / "part.sl1"
        write_sphere(scan, points=5_000, radius=3)
        self.run_it("slice", scan, "-o", part, "--no-preview", "--printer", self.printer, "--layer-height", 0.1, "--supports", "none")
        daemon = self.start()
        self.until("READY=1")
        self.stick.mkdir()
        part.rename(self.stick / "part.sl1")
        self.until("layer 3 of")
        (template,) = (int(pid) for pid in Path(f"/proc/{daemon.pid}/task/{daemon.pid}/children").read_text().split()
                       if Path(f"/proc/{pid}/comm").read_text() == "plumbline-scans\n")
        os.kill(template, signal.SIGSTOP)
        while not self.is_quiet(10 * WATCHDOG_S):  # until it waits for a layer
            self.assertIsNone(daemon.poll())
        began = time.monotonic()
        daemon.send_signal(signal.SIGTERM)
        # Regression: it waited for ever for the end of the template's child.
        self.until("STOPPING=1")
        self.assertIn(daemon.wait(60), (0, 1))
        self.assertLess(time.monotonic() - began, 30)
        self.assertFalse(Path(f"/proc/{template}").exists())
        # No layer was lost: the next daemon offers to resume, once somebody has seen the fault.
        self.start()
        self.until("STATUS=PL-902")
        # There may be two: the print's, and that of the process which reads scans.
        end = time.monotonic() + 60
        while "interrupted" not in self.run_it("status", "--socket", self.state / "state").stdout:
            self.assertLess(time.monotonic(), end)
            subprocess.run([PLUMBLINE, "ctl", "seen", "--socket", self.state / "state"], capture_output=True, check=False)
            time.sleep(0.5)
        self.until("STATUS=an interrupted print can go on")

    def test_killed_in_an_exposure_it_offers_to_resume(self):
        self.put_stick(5_000)
        daemon = self.start()
        self.until("layer 3 of")
        daemon.send_signal(signal.SIGKILL)  # WatchdogSignal= of the unit
        daemon.wait(60)
        self.start()
        self.until("READY=1")
        self.until("STATUS=an interrupted print can go on")

    def test_a_wrong_address_is_reported_before_any_device_opens(self):
        daemon = self.start(NOTIFY_SOCKET="nowhere")
        self.assertEqual(daemon.wait(60), 1)
        self.assertIn(b"NOTIFY_SOCKET: found 'nowhere'", daemon.stderr.read())


if __name__ == "__main__":
    main()
