#!/usr/bin/env python3
"""plumbline print is killed with SIGKILL at 50 random instants while its lamp is lit, and resumes each time.

The lamp's line is a file in which plumbline-keeper records the time of each change.
"""

import json
import random
import subprocess
import time

from case import PLUMBLINE, SOURCE_DIR, Program, main, write_sphere

ROUNDS = 50
DARK_WITHIN_MS = 50


class Killed(Program):
    def changes(self):
        try:
            text = self.line.read_text()
        except FileNotFoundError:
            return []
        return [(word, int(at)) for word, at in (line.split() for line in text[: text.rfind("\n") + 1].splitlines())]

    def kill_while_lit(self, arguments, delay):
        """@returns ms from the kill to darkness; None if the kill fell between two exposures"""
        command = [PLUMBLINE, *arguments, "--state", self.state, "--printer", self.board, "--quiet"]
        command += ["--speedup", 50, "--lamp-line", f"file:{self.line}"]
        before = len(self.changes())
        child = subprocess.Popen(list(map(str, command)), stderr=subprocess.PIPE, text=True)
        try:
            while len(self.changes()) == before:
                self.assertIsNone(child.poll(), child.stderr.read() if child.poll() is not None else "")
                time.sleep(0.001)
            time.sleep(delay)
            killed = time.monotonic_ns()
        finally:
            child.kill()
            child.wait()
            child.stderr.close()
        until = time.monotonic() + 1
        while self.changes()[-1][0] == "on" and time.monotonic() < until:
            time.sleep(0.001)
        last, at = self.changes()[-1]
        self.assertEqual(last, "off", "the lamp is lit without its firmware")
        return (at - killed) / 1e6 if at >= killed else None

    def test_the_lamp_goes_dark_each_time_and_the_part_is_whole(self):
        seed = random.randrange(10**9)
        chance = random.Random(seed)
        write_sphere(self.scan)
        self.board, self.state, self.line = SOURCE_DIR / "board" / "sim2k.toml", self.dir / "state", self.dir / "line"
        same = ("--scale", 0.05, "--supports", "none")
        self.run_it("slice", self.scan, "-o", self.out, "--printer", self.board, "--no-preview", *same)
        layers = self.manifest()["hashes"]["layers"]

        dark, between = [], 0
        arguments = ("print", self.scan, *same)
        while len(dark) < ROUNDS:
            # The shortest exposure is 2.5 s / 50.
            result = self.kill_while_lit(arguments, chance.uniform(0, 0.045))
            arguments = ("print", "--resume")
            if result is None:
                between += 1
                self.assertLess(between, ROUNDS)
            else:
                dark.append(result)
        print(f"seed {seed}: {ROUNDS} kills while lit, {between} between; dark after {max(dark):.1f} ms at most")
        self.assertLess(max(dark), DARK_WITHIN_MS)

        report = self.dir / "report.json"
        self.run_it("print", "--resume", "--state", self.state, "--printer", self.board, "--report", report)
        told = json.loads(report.read_text())
        self.assertEqual(told["state"], "finished")
        hashes = [line["mask_hash"] for line in told["exposures"]]
        self.assertEqual(hashes, layers[told["first_layer"] :])


if __name__ == "__main__":
    main()
