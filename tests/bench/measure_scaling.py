#!/usr/bin/env python3
"""Measures how plumbline's time grows with points, pixels and threads, and draws it:

  measure_scaling.py PLUMBLINE [--series points|pixels|threads ...] [--repeat N] [--largest POINTS] [--keep FILE.json] [-o PICTURE.png]

Slices what `plumbline sample` writes, without pictures. One thread, unless threads are what is measured.
  points   100,000 to 10 million (--largest), 0.05 mm pixels and layers
  pixels   a million points; the pixels across the object as many as a 2K, a 4K and an 8K panel has across; 0.05 mm layers
  threads  a million points, 0.05 mm; seconds of the clock, for 1 to 4 threads or as many as there are cores
Prints tables in Markdown, the least of --repeat runs (3), and how far each step is from proportional: a step to M times the work that
takes T times as long says T / M. --keep adds what was measured to a file; the picture shows all that is in it. It needs .ci/setup bench.
Exit status: 0 done, 1 a program failed, 2 wrong use.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from measured_run import measure

PITCH_MM = 0.05
PANELS = {"2K": 1440, "4K": 2400, "8K": 4320}  # pixels of the short side: board/mono2k.toml, mono4k.toml, mono8k.toml
MILLION = 1_000_000


class Run(NamedTuple):
    """One job's size and cost."""

    label: str
    amount: float  # points, rays or threads: what the series varies
    cpu_s: float
    wall_s: float


class Lab:
    """Makes scans and slices them in a folder of its own."""

    def __init__(self, plumbline, work, repeat):
        self.plumbline, self.work, self.repeat = plumbline, work, repeat

    def scan(self, points):
        path = self.work / f"{points}.ply"
        if not path.exists():
            measure([self.plumbline, "sample", path, "--points", points, "--quiet"])
        return path

    def slice(self, points, pitch_mm=PITCH_MM, threads=1):
        """Least cost of some runs, and the manifest."""
        out = self.work / "out"
        costs = [
            measure([self.plumbline, "slice", self.scan(points), "-o", out, "--pixel-pitch", pitch_mm, "--layer-height", PITCH_MM,
                     "--no-preview", "--supports", "none", "--threads", threads])
            for _ in range(self.repeat)
        ]
        manifest = json.loads((out / "manifest.json").read_text())
        return min(c.cpu_s for c in costs), min(c.wall_s for c in costs), manifest


def by_points(lab, largest):
    runs = []
    for points in (100_000, 300_000, MILLION, 3 * MILLION, 10 * MILLION):
        if points <= largest:
            cpu, wall, _ = lab.slice(points)
            runs.append(Run(f"{points:,}", points, cpu, wall))
            lab.scan(points).unlink()
    return runs


def by_pixels(lab, _):
    _, _, manifest = lab.slice(MILLION)
    width_mm = PITCH_MM * max(manifest["grid"]["columns"], manifest["grid"]["rows"])
    runs = []
    for panel, pixels in PANELS.items():
        cpu, wall, manifest = lab.slice(MILLION, pitch_mm=round(width_mm / pixels, 4))
        runs.append(Run(panel, manifest["rays"]["interested"], cpu, wall))
    return runs


def by_threads(lab, _):
    return [Run(str(threads), threads, *lab.slice(MILLION, threads=threads)[:2]) for threads in range(1, min(4, os.cpu_count()) + 1)]


SERIES = {"points": by_points, "pixels": by_pixels, "threads": by_threads}


def print_table(name, runs):
    if name == "threads":
        print("\n| threads | seconds of the clock | CPU seconds | faster than one thread |\n|---|---|---|---|")
        for run in runs:
            print(f"| {run.label} | {run.wall_s:.1f} | {run.cpu_s:.1f} | {runs[0].wall_s / run.wall_s:.2f} |")
        return
    print(f"\n| {name} | {'rays' if name == 'pixels' else 'points'} | CPU seconds | time's growth by the work's |\n|---|---|---|---|")
    for before, run in zip([None, *runs], runs):
        growth = f"{run.cpu_s / before.cpu_s / (run.amount / before.amount):.2f}" if before else ""
        print(f"| {run.label} | {run.amount:,.0f} | {run.cpu_s:.1f} | {growth} |", flush=True)


def draw(measured, picture):
    """One plot a series, both axes logarithmic but for threads. The line is what proportional growth would be."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, len(measured), figsize=(4 * len(measured), 3.4), squeeze=False)
    for axis, (name, runs) in zip(axes[0], measured.items()):
        amounts = [run.amount for run in runs]
        seconds = [run.wall_s if name == "threads" else run.cpu_s for run in runs]
        ideal = [seconds[-1] * a / amounts[-1] for a in amounts]
        if name == "threads":
            ideal = [seconds[0] / a for a in amounts]
            axis.set_xticks(amounts)
        else:
            axis.set_xscale("log")
            axis.set_yscale("log")
        axis.plot(amounts, ideal, color="0.75", label="proportional")
        axis.plot(amounts, seconds, "o-", color="tab:blue", label="measured")
        axis.set_xlabel({"points": "points", "pixels": "rays (pixels over the object)", "threads": "threads"}[name])
        axis.set_ylabel("seconds of the clock" if name == "threads" else "CPU seconds, one thread")
        axis.legend(frameon=False)
    figure.tight_layout()
    figure.savefig(picture, dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline", type=Path)
    parser.add_argument("-o", "--output", type=Path, help="a PNG file")
    parser.add_argument("--keep", type=Path, help="a JSON file")
    parser.add_argument("--series", nargs="+", choices=SERIES, default=list(SERIES))
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--largest", type=int, default=10 * MILLION)
    chosen = parser.parse_args()
    if not chosen.plumbline.exists():
        parser.error(f"{chosen.plumbline} does not exist: build it first")
    measured = {}
    with tempfile.TemporaryDirectory() as work:
        lab = Lab(chosen.plumbline.resolve(), Path(work), chosen.repeat)
        for name in chosen.series:
            measured[name] = SERIES[name](lab, chosen.largest)
            print_table(name, measured[name])
    if chosen.keep:
        kept = json.loads(chosen.keep.read_text()) if chosen.keep.exists() else {}
        kept |= {name: [run._asdict() for run in runs] for name, runs in measured.items()}
        chosen.keep.write_text(json.dumps(kept, indent=1) + "\n")
        measured = {name: [Run(**run) for run in kept[name]] for name in SERIES if name in kept}
    if chosen.output:
        draw(measured, chosen.output)


if __name__ == "__main__":
    sys.exit(main())
