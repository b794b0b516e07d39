#!/usr/bin/env python3
"""Makes .pictures/copier.png, the animated picture of the README: the points of the sample scan, the part as the printer's page shows it,
and the print as it grows.

    tests/bench/animate.py build/release/firmware . out/bust.ply .pictures/copier.png

It opens the page of a simulated printer in Debian's chromium, and takes some minutes without a graphics card."""

import math
import random
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib
from pathlib import Path

PROGRAMS, SOURCE, SCAN, OUT = map(Path, sys.argv[1:])
sys.path[:0] = [str(SOURCE / "tests/firmware/program")]

from rgb_picture import rows_of  # noqa: E402
from web_driver import Browser  # noqa: E402

WIDE, TALL, PORT, HEIGHT, POINTS = 480, 400, 8093, 40, 25_000
BACK = (20, 26, 33)
# Grey, orange and blue on the page's ground, from dark to bright.
RAMPS = ((222, 222, 212, 100), (237, 173, 92, 40), (128, 194, 255, 40))
PALETTE = [BACK] + [tuple(b + (c - b) * i // n for b, c in zip(BACK, ramp)) for *ramp, n in RAMPS for i in range(1, n + 1)]

DRAW_POINTS = """
const [points, yaw] = arguments, canvas = document.querySelector('#points'), to = canvas.getContext('2d');
view.look(yaw, 0.2);
to.fillStyle = 'rgb(20, 26, 33)';
to.fillRect(0, 0, canvas.width, canvas.height);
to.fillStyle = '#dcdcd2b0';
for (const point of points) {
  const [x, y] = view.placeOf(point);
  to.fillRect(x, y, 1.3, 1.3);
}
"""


class Page(unittest.TestCase):
    """Opens and closes things."""

    def runTest(self):
        """A TestCase has one."""


def scan_points():
    """Some of the points, as they lie on the plate before they are moved to its middle: x, y about 0, z from 0, mm."""
    data = SCAN.read_bytes()
    start = data.index(b"end_header\n") + 11
    head = data[:start].decode().split("\n")
    count = int(next(line.split()[2] for line in head if line.startswith("element vertex")))
    size = (len(data) - start) // count
    sample = random.Random(1).sample(range(count), min(POINTS, count))
    points = [struct.unpack_from("<3f", data, start + size * i) for i in sample]
    low, high = ([sorted(p[axis] for p in points)[at] for axis in range(3)] for at in (len(points) // 500, -len(points) // 500))
    scale = HEIGHT / (high[2] - low[2])
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    return [[scale * (p[0] - middle[0]), scale * (p[1] - middle[1]), scale * (p[2] - low[2])] for p in points]


def write_apng(path, frames, delays):
    """@param frames  rows of palette indices; @param delays  of each, ms"""
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    out = [b"\x89PNG\r\n\x1a\n", chunk(b"IHDR", struct.pack(">IIBBBBB", WIDE, TALL, 8, 3, 0, 0, 0)), chunk(b"acTL", struct.pack(">II", len(frames), 0)),
           chunk(b"PLTE", b"".join(map(bytes, PALETTE)))]
    number = 0
    for i, (rows, delay) in enumerate(zip(frames, delays)):
        out.append(chunk(b"fcTL", struct.pack(">IIIIIHHBB", number, WIDE, TALL, 0, 0, delay, 1000, 0, 0)))
        data = zlib.compress(b"".join(b"\0" + row for row in rows), 9)
        out.append(chunk(b"IDAT", data) if i == 0 else chunk(b"fdAT", struct.pack(">I", number + 1) + data))
        number += 1 if i == 0 else 2
    path.write_bytes(b"".join(out) + chunk(b"IEND", b""))


class Camera:
    """Takes frames of the view."""

    def __init__(self, browser):
        self.browser, self.frames, self.delays, self.nearest = browser, [], [], {}

    def take(self, delay=110):
        time.sleep(0.3)  # until it is drawn
        columns, rows = rows_of(self.browser.shot("#stage"))
        size = len(rows[0]) // columns
        frame = []
        for row in rows[:TALL]:
            colours = (tuple(v & 0xFC for v in row[size * x : size * x + 3]) for x in range(WIDE))
            frame.append(bytes(self.index(colour) for colour in colours))
        self.frames.append(frame)
        self.delays.append(delay)

    def index(self, colour):
        if colour not in self.nearest:
            self.nearest[colour] = min(range(len(PALETTE)), key=lambda i: sum((a - b) ** 2 for a, b in zip(PALETTE[i], colour)))
        return self.nearest[colour]


def press(browser, command):
    browser.until(f"return document.querySelector('[data-do={command}]:not([aria-disabled=true])')", command)
    browser.click(f"[data-do={command}]")


def main():
    page = Page()
    folder = tempfile.mkdtemp()
    simulated = subprocess.Popen([PROGRAMS / "plumbline", "simulate", SCAN, "--port", str(PORT), "--folder", f"{folder}/printer"],
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    page.addCleanup(simulated.wait)
    page.addCleanup(simulated.terminate)
    while "http" not in simulated.stdout.readline():
        pass
    browser = Browser(page, folder, 900, 900)
    browser.open(f"http://localhost:{PORT}/")
    browser.until("return ['plate in use', 'offered'].includes(document.body.dataset.state)", "a state")
    if browser.run("return document.body.dataset.state") != "offered":
        press(browser, "plate-empty")
    browser.until("return document.body.dataset.state === 'offered'", "the scan")
    browser.run("command({do: 'set', key: 'height', value: arguments[0]})", f"{HEIGHT}mm")
    browser.until("return state.job.size", "its height")
    press(browser, "start")
    browser.until("return state.masks && !document.querySelector('#part').hidden && document.querySelector('#loading').hidden && view.frames > 0", "the part")
    browser.run(f"""const canvas = document.createElement('canvas');
        Object.assign(canvas, {{id: 'points', width: {WIDE}, height: {TALL}}});
        for (const node of [document.querySelector('#stage'), document.querySelector('#view'), canvas]) Object.assign(node.style, {{width: '{WIDE}px', height: '{TALL}px', borderRadius: 0}});
        Object.assign(canvas.style, {{position: 'absolute', left: 0, top: 0}});
        document.querySelector('#marks').hidden = true;
        document.querySelector('#stage').append(canvas);""")
    time.sleep(1)
    box = browser.run("return view.box")
    points = [[p[0] + sum(box[0]) / 2, p[1] + sum(box[1]) / 2, p[2]] for p in scan_points()]
    camera, turn = Camera(browser), 2 * math.pi / 24
    for k in range(12):
        browser.run(DRAW_POINTS, points, -0.6 + turn * k)
        camera.take()
    browser.run("document.querySelector('#points').hidden = true")
    for k in range(12, 24):
        browser.run("view.look(arguments[0], 0.2)", -0.6 + turn * k)
        camera.take(900 if k == 23 else 110)
    for k in range(1, 17):
        browser.run("view.plane(arguments[0])", HEIGHT * k / 16 if k < 16 else None)
        camera.take(2000 if k == 16 else 150)
    write_apng(OUT, camera.frames, camera.delays)
    page.doCleanups()


main()
