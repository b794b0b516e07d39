"""Runs a program and measures it: CPU seconds and peak memory of the process, as the kernel counts them."""

import os
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple


class Cost(NamedTuple):
    cpu_s: float  # user and system, all threads
    wall_s: float
    peak_mib: float  # resident

    def __add__(self, other):
        """Of two programs that run one after the other."""
        return Cost(self.cpu_s + other.cpu_s, self.wall_s + other.wall_s, max(self.peak_mib, other.peak_mib))


def measure(command):
    """Ends this program if the other one fails, with what it printed.

    GNU time starts it: the kernel counts the pages of whoever starts a program as its own, and Python has more than plumbline."""
    started = time.monotonic()
    with tempfile.NamedTemporaryFile("r") as peak:
        timed = ["time", "--output", peak.name, "--format", "%M", *map(str, command)]
        process = subprocess.Popen(timed, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        said = process.stdout.read().decode(errors="replace")
        _, status, used = os.wait4(process.pid, 0)
        peak_kib = peak.read().split()[-1:]
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nended with {process.returncode}:\n{said[-3000:]}")
    return Cost(used.ru_utime + used.ru_stime, time.monotonic() - started, int(peak_kib[0]) / 1024)


def stay_on_one_core():
    """This process and those it starts: nobody gains from a second thread, nobody pays for moving between cores."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
