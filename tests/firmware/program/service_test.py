#!/usr/bin/env python3
"""plumblined as its service manager meets it: what it says on NOTIFY_SOCKET, and that it says so in every phase of a print."""

import os
import signal
import socket
import struct
import subprocess
import time

from case import PLUMBLINED, SOURCE_DIR, Program, main, write_sphere

WATCHDOG_S = 0.04
# A phase that takes longer must have said that it lives; a shorter one need not, nor one of a daemon that got no processor.
LONG_PHASE_S = 5 * WATCHDOG_S
SO_TIMESTAMP = 29  # of Linux, which Python does not name; the same number asks for it and comes with it


class Service(Program):
    def setUp(self):
        super().setUp()
        self.stick = self.dir / "stick"
        self.ear = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.ear.close)
        self.ear.bind(str(self.dir / "notify"))
        self.ear.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMP, 1)
        self.heard, self.said_at = [], 0.0

    def start(self, *arguments, speedup=20, **environment):
        command = [PLUMBLINED, "--printer", SOURCE_DIR / "board/sim2k.toml", "--state", self.dir / "state", "--stick", self.stick]
        command += ["--speedup", speedup, *arguments]
        asked = {"NOTIFY_SOCKET": str(self.dir / "notify"), "WATCHDOG_USEC": str(int(WATCHDOG_S * 1e6)), **environment}
        daemon = subprocess.Popen(list(map(str, command)), env={**os.environ, **asked}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(daemon.stderr.close)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        return daemon

    def until(self, words):
        """Hears what it says until the words come, and gives what came before."""
        before, end = [], time.monotonic() + 60
        while time.monotonic() < end:
            self.ear.settimeout(max(0.01, end - time.monotonic()))
            try:
                data, (stamp, *_), *_ = self.ear.recvmsg(4096, 64)
            except TimeoutError:
                break
            message = data.decode()
            # When it was said, not when this test got round to hearing it.
            seconds, microseconds = struct.unpack("ll", stamp[2][:16])
            self.said_at = seconds + 1e-6 * microseconds
            self.heard.append(message)
            if words in message:
                return before
            before.append(message)
        return self.fail(f"{words} was not said; last: {[text for text in self.heard if text != 'WATCHDOG=1'][-10:]}")

    def put_stick(self, points):
        folder = self.dir / "new"
        folder.mkdir()
        write_sphere(folder / "ball.ply", points=points, radius=6)
        folder.rename(self.stick)

    def test_hears_of_life_in_every_phase_of_a_print_and_why_it_pauses(self):
        daemon = self.start("--fault", "cover.opens@layer=2,for=20s")
        self.until("READY=1")
        self.until("STATUS=ready: waiting for a stick")
        phase, since, long_phases = "waiting", self.said_at, 0
        time.sleep(3 * WATCHDOG_S)
        self.put_stick(100_000)
        for next_phase in ("reading ball.ply", "checks", "homing", "layer 1 of", "layer 2 of", "the cover is open", "start goes on"):
            lived = self.until(next_phase).count("WATCHDOG=1")
            if self.said_at - since > LONG_PHASE_S:
                self.assertGreater(lived, 0, f"in {self.said_at - since:.2f} s of {phase}")
                long_phases += 1
            phase, since = next_phase, self.said_at
        self.assertGreaterEqual(long_phases, 2)
        # Paused, it lives on.
        self.until("WATCHDOG=1")
        self.until("WATCHDOG=1")
        daemon.send_signal(signal.SIGTERM)
        self.until("STOPPING=1")
        self.until("STATUS=suspended")
        self.assertEqual(daemon.wait(60), 0)
        self.assertEqual([text for text in self.heard if "READY" in text or "STOPPING" in text], ["READY=1", "STOPPING=1"])

    def quiet(self, seconds):
        """@returns whether nothing comes for that long, after what is there."""
        self.ear.setblocking(False)
        try:
            while self.ear.recv(4096):
                pass
        except BlockingIOError:
            pass
        time.sleep(seconds)
        try:
            return not self.ear.recv(4096)
        except BlockingIOError:
            return True

    def test_hears_nothing_while_the_loop_hangs(self):
        # A report that nobody takes holds up the one thread whose life counts; the others live.
        report = self.dir / "state" / "report.json"
        report.parent.mkdir()
        os.mkfifo(report)
        self.start(speedup=1e6)
        self.put_stick(5_000)
        self.until("STATUS=finished")
        self.assertTrue(self.quiet(10 * WATCHDOG_S))
        self.assertIn('"state": "finished"', report.read_text())
        self.until("STATUS=ready")
        self.until("WATCHDOG=1")

    def test_is_killed_in_an_exposure_and_offers_to_go_on(self):
        self.put_stick(5_000)
        daemon = self.start()
        self.until("layer 3 of")
        daemon.send_signal(signal.SIGKILL)  # WatchdogSignal= of the unit
        daemon.wait(60)
        self.start()
        self.until("READY=1")
        self.until("STATUS=an interrupted print can go on")

    def test_whose_address_is_wrong_is_told_before_anything_opens(self):
        daemon = self.start(NOTIFY_SOCKET="nowhere")
        self.assertEqual(daemon.wait(60), 1)
        self.assertIn(b"NOTIFY_SOCKET: found 'nowhere'", daemon.stderr.read())


if __name__ == "__main__":
    main()
