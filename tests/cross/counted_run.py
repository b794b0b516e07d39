"""Runs a build under QEMU's user emulation, where a plug-in (count_instructions.cpp) counts instructions.

The counts depend on the program and on QEMU's processor, not on the machine or its load.
"""

import os
import subprocess
import sys
from pathlib import Path

SOURCE_DIR = Path(__file__).resolve().parents[2]
SPREAD = 0.001  # relative difference between equal runs: addresses and the time of day change a few instructions


class Counts:
    """Instructions of each stage of one run, and of the whole run."""

    def __init__(self, parts, rest, said):
        """
        @param parts  instructions before each line that tells of a stage, and after the one before it
        @param rest   instructions after the last of them
        @param said   standard error. With --verbose each stage writes one line with its time when it ends
        """
        lines = [line.split() for line in said.splitlines() if " s   arena " in line]
        if len(lines) != len(parts):
            sys.exit(f"{len(parts)} counts for {len(lines)} lines about stages:\n{said}")
        self.total = sum(parts) + rest
        self.stages = {}
        for part, words in zip(parts, lines):
            # A stage that works in two steps ends twice.
            name = " ".join(words[: words.index("s") - 1])
            self.stages[name] = self.stages.get(name, 0) + part


def counts_of_writes(counted, said):
    """Counts from what count_instructions.cpp wrote, which tells of all writes to standard error, each of one line."""
    *marks, end = counted.splitlines()
    _, total, threads = end.split()
    if threads != "1":
        sys.exit(f"the program ran {threads} threads, but the plug-in counts only one")
    parts, before = [], 0
    for mark, line in zip(marks, said.splitlines()):
        at = int(mark.split()[1])
        if " s   arena " in line:
            parts.append(at - before)
        before = at
    return Counts(parts, int(total) - sum(parts), said)


class Counter:
    """Counts what a build executes."""

    def __init__(self, command, work):
        """command: the words that run the build, the emulator's first. work: an empty folder."""
        self.command, self.work, self.plugin = command, work, work / "count.so"
        source = Path(__file__).with_name("count_instructions.cpp")
        subprocess.run(["c++", "-std=c++20", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-o", self.plugin, source], check=True)

    def run(self, arguments, status=0):
        counted = self.work / "counted"
        counted.unlink(missing_ok=True)
        emulator, *program = self.command
        words = [emulator, "-plugin", f"{self.plugin},out={counted}", *program, *arguments, "--verbose", "--threads", 1]
        done = subprocess.run(
            list(map(str, words)), env={**os.environ, "OMP_NUM_THREADS": "1"}, capture_output=True, text=True, check=False
        )
        if done.returncode != status or not counted.exists():
            shown = " ".join(map(str, arguments))
            sys.exit(f"{shown}\nended with {done.returncode}; counted: {counted.exists()}\n{done.stdout}{done.stderr}")
        return counts_of_writes(counted.read_text(), done.stderr)


def is_repeatable(one, other):
    """Whether the totals of two equal runs agree; says by how much they differ."""
    spread = abs(one.total - other.total) / one.total
    print(f"two equal runs differ by {spread:.2g} of the count")
    if spread > SPREAD:
        print("FAILED  the counts vary too much to compare")
    return spread <= SPREAD
