#!/usr/bin/env python3
"""plumbline print, its keeper, or both (PLUMBLINE_STRUCK says which) are stopped or killed 35 times at random instants while the lamp is lit
(both: 15 times, since each takes the watchdog's time). It resumes each time. CI runs this twice.

The lamp's line is a file in which its holder records the time of each change; as on a GPIO chip, a line that is released lit stays lit.
The watchdog is a FIFO that shows what the keeper writes.
"""

import json
import os
import random
import signal
import subprocess
import threading
import time
from pathlib import Path

from case import PLUMBLINE, SOURCE_DIR, Program, main, write_sphere

STRUCK = os.environ.get("PLUMBLINE_STRUCK", "firmware")
ROUNDS = int(os.environ.get("PLUMBLINE_STOP_ROUNDS", "15" if STRUCK == "both" else "35"))
DARK_WITHIN_MS = 50
WATCHDOG_S = 2
LATE_MS = 50  # at most between the keeper's write to the watchdog and the time that this test notes for it
SPEEDUP = 100
EXPOSURE_S = 0.4  # of the host's time


class Watchdog:
    """Notes when the keeper feeds the watchdog, and whether it stops it."""

    def __init__(self, path):
        os.mkfifo(path)
        self.file, self.fed_at, self.disarmed = os.open(path, os.O_RDWR), 0, False
        threading.Thread(target=self._follow, daemon=True).start()

    def _follow(self):
        while True:
            data = os.read(self.file, 64)
            self.disarmed = data.endswith(b"V")
            self.fed_at = time.monotonic()


def stat_of(process):
    """State and parent of a process; None if there is none."""
    try:
        state, parent = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[:2]
        return state, int(parent)
    except (FileNotFoundError, ProcessLookupError):
        return None


def keeper_of(firmware):
    """The process ID of the firmware's only child."""
    processes = [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]
    (keeper,) = [process for process in processes if (stat_of(process) or ("", 0))[1] == firmware]
    return keeper


def ended(process):
    stat = stat_of(process)
    return stat is None or stat[0] == "Z"


class Killed(Program):
    def changes(self):
        try:
            text = self.line.read_text()
        except FileNotFoundError:
            return []
        return [(word, int(at)) for word, at in (line.split() for line in text[: text.rfind("\n") + 1].splitlines())]

    def until(self, what, condition, seconds):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.001)

    def strike(self, arguments, who, number, delay):
        """
        Sends a signal to the firmware, its keeper or both while the lamp is lit.
        @returns ms from then until the line is off; for both, until the watchdog that nobody feeds has reset the board; None if the
                 lamp was dark just then
        """
        command = [PLUMBLINE, *arguments, "--state", self.state, "--printer", self.board, "--quiet"]
        command += ["--speedup", SPEEDUP, "--lamp-line", f"file:{self.line}"]
        lights = sum(word == "on" for word, _ in self.changes())
        child = subprocess.Popen(list(map(str, command)), stderr=subprocess.PIPE, text=True)
        keeper = None
        try:
            while sum(word == "on" for word, _ in self.changes()) == lights:
                self.assertIsNone(child.poll(), child.stderr.read() if child.poll() is not None else "")
                time.sleep(0.001)
            keeper = keeper_of(child.pid)
            time.sleep(delay)
            targets = {"firmware": [child.pid], "keeper": [keeper], "both": [child.pid, keeper]}[who]
            random.shuffle(targets)
            struck = time.monotonic_ns()
            for target in targets:
                os.kill(target, number)
            if self.changes()[-1][0] == "off":
                return None
            if who == "both":
                # A watchdog that is still fed never comes to its end.
                self.until("the board is not reset", lambda: time.monotonic() > self.watchdog.fed_at + WATCHDOG_S, WATCHDOG_S + 0.2)
                if self.changes()[-1][0] == "off":  # the first of them struck the second before the signal did
                    return (self.changes()[-1][1] - struck) / 1e6
                self.assertFalse(self.watchdog.disarmed, "nobody resets the board")
                return (self.watchdog.fed_at + WATCHDOG_S) * 1e3 - struck / 1e6
            self.until(f"the lamp is lit without its {who}", lambda: self.changes()[-1][0] == "off", 1)
            # If the exposure ended first, the silence of a process is noticed at the pace of the dark, after about a second.
            self.until(f"the {who} was not ended", lambda: ended(targets[0]), 5)
            return (self.changes()[-1][1] - struck) / 1e6
        finally:
            # A board that is reset ends both and its lines are off.
            for process in (child.pid, keeper):
                if process and not ended(process) and (who == "both" or process == child.pid):
                    os.kill(process, signal.SIGKILL)
            child.wait()
            if keeper:
                self.until("the keeper stays", lambda: ended(keeper), 2)
            child.stderr.close()

    def test_the_lamp_goes_dark_each_time_and_the_part_is_whole(self):
        seed = random.randrange(10**9)
        chance = random.Random(seed)
        random.seed(seed)
        write_sphere(self.scan)
        self.state, self.line = self.dir / "state", self.dir / "line"
        self.watchdog = Watchdog(self.dir / "watchdog")
        self.write_printer()
        same = ("--scale", 0.05, "--supports", "none")
        self.run_it("slice", self.scan, "-o", self.out, "--printer", self.board, "--no-preview", *same)
        layers = self.manifest()["hashes"]["layers"]

        struck = {(STRUCK, number): [] for number in (signal.SIGSTOP, signal.SIGKILL)}
        between = 0
        arguments = ("print", self.scan, *same)
        while (done := sum(map(len, struck.values()))) < ROUNDS:
            kind = list(struck)[done % len(struck)]
            result = self.strike(arguments, *kind, chance.uniform(0, 0.9 * EXPOSURE_S))
            if result is None:
                between += 1
                self.assertLess(between, ROUNDS)
            else:
                struck[kind].append(result)
            # The layers run out. Then the print begins anew.
            arguments = ("print", "--resume")
            if not (self.state / "journal").exists():
                arguments = ("print", self.scan, *same)
        print(f"\nseed {seed}: {ROUNDS} times while lit, {between} between; dark after at most, ms:")
        for (who, number), times in struck.items():
            if times:
                print(f"  {who}, {signal.Signals(number).name}: {len(times)} times, {max(times):.1f}")
                self.assertLess(max(times), 1e3 * WATCHDOG_S + LATE_MS if who == "both" else DARK_WITHIN_MS, (who, number))

        report = self.dir / "report.json"
        self.run_it("print", "--resume", "--state", self.state, "--printer", self.board, "--report", report)
        told = json.loads(report.read_text())
        self.assertEqual(told["state"], "finished")
        hashes = [line["mask_hash"] for line in told["exposures"]]
        self.assertEqual(hashes, layers[told["first_layer"] :])

    def write_printer(self):
        """The simulated printer with a watchdog, and a profile whose exposures last long enough to be struck in the middle."""
        board = (SOURCE_DIR / "board" / "sim2k.toml").read_text()
        board += f'\n[watchdog]\ndevice = "file:{self.dir}/watchdog"\ntimeout_s = {WATCHDOG_S}\n'
        profile = (SOURCE_DIR / "board" / "profiles" / "standard.toml").read_text()
        for key, value in {"exposure_time": EXPOSURE_S * SPEEDUP, "initial_exposure_time": EXPOSURE_S * SPEEDUP}.items():
            old = next(line for line in profile.splitlines() if line.startswith(f"{key} ="))
            profile = profile.replace(old, f"{key} = {value}")
        self.board = self.dir / "sim2k.toml"
        self.board.write_text(board)
        (self.dir / "profiles").mkdir()
        (self.dir / "profiles" / "standard.toml").write_text(profile)


if __name__ == "__main__":
    main()
