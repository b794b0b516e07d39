#!/usr/bin/env python3
"""Holds the release build for x86-64 to the instructions it executed before: guard_instructions.py PLUMBLINE [--update]

Slices two small scans under Valgrind's Callgrind, with one thread: a clean one, and a noisy one. A stage or a whole run that executes over 3 % more than guard.json says is an error. --update writes the counts there.
The counts depend on the compiler, so they are those of Debian 12's. They do not depend on the machine, since Valgrind's processor is the
same on all that have AVX2. QEMU counts the same, but emulates each floating-point operation and takes five times as long.
Exit status: 0 no slower than before, 1 slower or not repeatable, 2 wrong use.
"""

import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from counted_run import Counts, is_repeatable

KEPT = Path(__file__).with_name("guard.json")
MARGIN = 0.03
LEAST = 0.001  # of the whole run: a stage that grows by less is let through, since a few cells more or less are 3 % of a tiny one
COUNTER = "valgrind"
STAGE_ENDS = "plumbline::firmware::ProgressLines::end(*"  # --verbose: called once for each line about a stage
NOISY = ["--points", "34000", "--seed", "4"]
PITCH = {"clean": "0.3", "noisy": "0.2"}  # mm, of pixels and layers


def write_torus(path, around=150, through=60, ring=15.0, tube=7.0):
    """Writes a torus, clean and with normals: `around` * `through` points, binary PLY, mm."""
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {around * through}"]
    head += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")]
    with open(path, "wb") as file:
        file.write(("\n".join(head + ["end_header"]) + "\n").encode())
        for i in range(around):
            for j in range(through):
                # Each ring is turned against the last, so that no column of rays meets points only.
                u, v = 2 * math.pi * i / around, 2 * math.pi * (j + 0.618 * i % 1) / through
                normal = (math.cos(u) * math.cos(v), math.sin(u) * math.cos(v), math.sin(v))
                middle = (ring * math.cos(u), ring * math.sin(u), 0)
                file.write(struct.pack("<6f", *(m + tube * n for m, n in zip(middle, normal)), *normal))


def count(program, arguments, work, status=0):
    """The Counts of one run."""
    dumps = work / "counted"
    command = [COUNTER, "--quiet", "--tool=callgrind", f"--callgrind-out-file={dumps}", f"--dump-before={STAGE_ENDS}"]
    words = map(str, [*command, program, *arguments, "--verbose", "--threads", 1])
    done = subprocess.run(words, env={**os.environ, "OMP_NUM_THREADS": "1"}, capture_output=True, text=True, check=False)
    if done.returncode != status:
        sys.exit(f"{' '.join(map(str, arguments))}\nended with {done.returncode}:\n{done.stdout}{done.stderr}")

    def executed(dump):
        found = int(re.search(r"^totals: (\d+)$", dump.read_text(), re.MULTILINE)[1])
        dump.unlink()
        return found

    # Each dump has what was executed since the last one: counted.1, counted.2 and so on, at the end counted.
    parts = sorted(work.glob(f"{dumps.name}.*"), key=lambda dump: int(dump.suffix[1:]))
    return Counts([executed(dump) for dump in parts], executed(dumps), done.stderr)


def measure(program, work):
    """Counts of each scan's stages by name, and whether two equal runs agree."""
    scans = {"clean": work / "clean.ply", "noisy": work / "noisy.ply"}
    write_torus(scans["clean"])
    subprocess.run([program, "sample", scans["noisy"], *NOISY, "--quiet"], check=True)

    # Building the command line and loading the libraries is no part of reading a scan.
    start = count(program, ["slice", work / "missing.ply", "-o", work / "none"], work, status=1).total

    def run(name, out):
        sizes = ["--pixel-pitch", PITCH[name], "--layer-height", PITCH[name]]
        counts = count(program, ["slice", scans[name], "-o", out, *sizes, "--no-preview"], work)
        counts.stages = {"start": start, **counts.stages, "read": counts.stages["read"] - start}
        return counts

    runs = {name: run(name, work / name) for name in scans}
    repeatable = is_repeatable(runs["clean"], run("clean", work / "again"))
    return {name: {**counts.stages, "all": counts.total} for name, counts in runs.items()}, repeatable


def compare(name, counts, kept):
    """Prints the counts of a scan beside those of before. Returns whether all are within the margin."""
    good = True
    for stage, value in counts.items():
        was = kept.get(stage)
        if was is None:
            print(f"new     {name + ', ' + stage:24}{value:18,}")
            good = False
            continue
        slower = value - was > max(MARGIN * was, LEAST * kept["all"])
        change = f"{value / was - 1:+9.2%}" if was else ""
        print(f"{'FAILED' if slower else 'ok':8}{name + ', ' + stage:24}{value:18,}{change}")
        good &= not slower
    return good


def compiler():
    return subprocess.run(["c++", "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]


def main(arguments):
    if not arguments or arguments[1:] not in ([], ["--update"]):
        print(__doc__, file=sys.stderr)
        return 2
    if shutil.which(COUNTER) is None:
        print(f"FAILED  there is no {COUNTER} to count with: run .ci/setup test")
        return 1
    with tempfile.TemporaryDirectory(prefix="plumbline-guard-") as folder:
        counts, good = measure(Path(arguments[0]).resolve(), Path(folder))
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {"compiler": "", "scans": {}}
    for name, stages in counts.items():
        good &= compare(name, stages, kept["scans"].get(name, {}))
    if arguments[1:]:
        KEPT.write_text(json.dumps({"compiler": compiler(), "scans": counts}, indent=2) + "\n")
        return 0
    if not good:
        print(f"If the increase is intended, run this with --update and say why in the commit. To see which functions grew:\n"
              f"  valgrind --tool=callgrind {arguments[0]} slice SCAN -o OUT --threads 1")
        if kept["compiler"] != compiler():
            print(f"The counts kept are those of {kept['compiler'] or 'no compiler'}; this machine has {compiler()}.")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
