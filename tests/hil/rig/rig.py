"""Shared by all tests of the emulated board: one guest for a module, a daemon and a stage for each test."""

import argparse
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import guest
from machine import Gate, Machine
from printer import COVER, LAMP, START, STEP_MM, Stage, intervals, mask_pixels, objections, trace_times

LAYER_STEPS = round(0.1 / STEP_MM)
LIFT_STEPS = round(1.0 / STEP_MM)
OPTIONS = None

# Stops the watchdog that a killed firmware leaves running.
DISARM = "echo V > /dev/watchdog0"

# Host seconds. Generous: emulation on a busy host is slow, which says nothing about the firmware. PLUMBLINE_RIG_PATIENCE gives more.
VERBOSE = "PLUMBLINE_RIG_VERBOSE" in os.environ  # tells what the guest says while a test waits
PATIENCE = int(os.environ.get("PLUMBLINE_RIG_PATIENCE", "180"))


def write_lentil(path, points=12000):
    """A leaning lentil, 2 mm wide and 0.8 mm high. No layer equals another or a mirror image of one. PLY, binary.

    An ellipsoid on a Fibonacci lattice, sheared along both axes; its normals are those of the sphere by the inverse transpose.
    """
    wide, high, lean_x, lean_y = 1.0, 0.4, 0.8, 0.3
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {points}"]
    head += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")] + ["end_header", ""]
    with open(path, "wb") as file:
        file.write("\n".join(head).encode())
        for i in range(points):
            w = 1 - 2 * (i + 0.5) / points
            r, angle = math.sqrt(1 - w * w), 2.39996322972865332 * i
            u, v = r * math.cos(angle), r * math.sin(angle)
            place = (wide * u + lean_x * high * w, wide * v + lean_y * high * w, high * w)
            normal = (u / wide, v / wide, w / high - lean_x * u / wide - lean_y * v / wide)
            length = math.hypot(*normal)
            file.write(struct.pack("<6f", *place, *(part / length for part in normal)))


def masks_of(scan, folder, board, layers=None):
    """
    The masks that this machine's `plumbline slice` writes for the rig's printer.
    @param board    text of its board file
    @returns the masks of the first `layers` layers, or of all, a byte a pixel
    """
    (folder / "board" / "profiles").mkdir(parents=True, exist_ok=True)
    (folder / "board" / "rig.toml").write_text(board)
    shutil.copy(guest.HERE / "quick.toml", folder / "board" / "profiles")
    sliced = folder / "sliced"
    command = [OPTIONS.host / "firmware" / "plumbline", "slice", scan, "-o", sliced, "--printer", folder / "board" / "rig.toml"]
    subprocess.run([*command, "--layer-height", "0.1", "--quiet", "--no-preview"], check=True)
    masks = [mask_pixels(path) for path in sorted((sliced / "layers").iterdir())[:layers]]
    shutil.rmtree(sliced)
    return masks


class Rig(unittest.TestCase):
    EXACT = False  # whether the Machine is exact
    DISK = True  # keep the state on a disk, not in memory
    BOARD = {"columns": 640, "rows": 480, "end_stop_height_mm": 32}  # changes to board/rig.toml
    PROGRAMS = ()  # more programs of the cross build
    SCREEN = None  # columns and rows of a screen for people

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="plumbline-rig-")
        cls.addClassCleanup(folder.cleanup)
        cls.dir = Path(folder.name)
        root = guest.make_root(OPTIONS.arch)
        cls.board = guest.board_text(cls.BOARD)
        if cls.SCREEN:
            cls.board += '\n[screen]\ncolumns = {}\nrows = {}\nconnector = "Virtual-2"\n'.format(*cls.SCREEN)
        programs = [OPTIONS.cross / program for program in cls.PROGRAMS]
        guest.make_initramfs(OPTIONS.arch, root, OPTIONS.cross, cls.dir / "initramfs", cls.board, programs)
        cls.scans()
        disk = None
        if cls.DISK:
            disk = cls.dir / "disk.img"
            with open(disk, "wb") as image:
                image.truncate(32 << 20)
            subprocess.run([shutil.which("mkfs.ext4") or "/usr/sbin/mkfs.ext4", "-q", "-F", disk], check=True)
        gate = Gate(cls.dir) if cls.EXACT else None
        kernel = guest.kernel_of(root)
        cls.plugs = 0
        panel = cls.BOARD["columns"], cls.BOARD["rows"]
        cls.machine = Machine(cls.dir, kernel, cls.dir / "initramfs", OPTIONS.arch, disk=disk, panel=panel, gate=gate, screen=cls.SCREEN)
        cls.addClassCleanup(cls.machine.end)
        cls.boot()

    @classmethod
    def scans(cls):
        """Makes scans, their masks and sticks."""
        cls.scan = cls.dir / "lentil.ply"
        write_lentil(cls.scan)
        cls.masks = masks_of(cls.scan, cls.dir, cls.board)
        cls.stick = cls.dir / "lentil.img"
        guest.make_stick(cls.stick, [cls.scan])

    @classmethod
    def boot(cls):
        started = time.monotonic()
        cls.machine.until_booted()
        cls.tell(f"booted in {time.monotonic() - started:.1f} s: {cls.run_in_guest('uname -rm')}")
        base = cls.run_in_guest("for c in /sys/class/gpio/gpiochip*; do grep -q pl061 $c/label && cat $c/base; done")
        cls.lamp_gpio = int(base.split()[0]) + LAMP
        cls.run_in_guest("cd /sys/kernel/tracing; echo mono > trace_clock;"
                         f" echo gpio=={cls.lamp_gpio} > events/gpio/gpio_value/filter; echo 1 > events/gpio/gpio_value/enable")

    @staticmethod
    def tell(text):
        print(text, file=sys.stderr, flush=True)

    @classmethod
    def run_in_guest(cls, command, seconds=PATIENCE):
        status, said = cls.machine.run(command, seconds)
        assert status == 0, f"{command}: status {status}: {said}"
        return said

    def setUp(self):
        self.plugged, self.stage = None, None
        self.machine.set_line(COVER, 0)
        self.machine.set_line(START, 0)
        self.run_in_guest("rm -rf /state/*; touch /state/plate-is-empty /state/tank-is-full; echo > /sys/kernel/tracing/trace")

    def tearDown(self):
        if any(error for _, error in getattr(self._outcome, "errors", [])) or not self._outcome.success:
            self.tell(self.log()[-3000:])
        self.machine.run("killall -9 plumblined plumblined-broken; while pidof plumblined plumblined-broken plumbline-keeper;"
                         " do usleep 50000; done; " + DISARM)
        if self.stage:
            self.stage.end()
        if self.plugged:
            self.pull()

    def follow(self):
        """Starts to follow the lines with a new stage, at the height of the last one."""
        if self.stage:
            self.stage.end()
        end_stop = round(self.BOARD["end_stop_height_mm"] / STEP_MM)
        below = round(1.5 / STEP_MM)  # where it is switched on
        self.stage = Stage(self.machine, self.stage.steps if self.stage else end_stop - below, end_stop)

    def start_daemon(self, program="plumblined", environment=""):
        self.run_in_guest(f"(cd /board; {environment} {program} --printer rig.toml --state /state > /tmp/log 2>&1;"
                          " echo ended with $? >> /tmp/log) &")
        self.until("ready", "interrupted")

    def log(self):
        return self.machine.run("cat /tmp/log")[1]

    def until(self, *patterns, seconds=PATIENCE):
        """Waits until the log matches one of the patterns, and tells what is new in it meanwhile. @returns the log"""
        end = time.monotonic() + seconds
        told = 0
        while time.monotonic() < end:
            log = self.log()
            if any(re.search(pattern, log, re.DOTALL) for pattern in patterns):
                return log
            if VERBOSE and len(log) > told:
                self.tell(f"{time.monotonic() - end + seconds:6.1f} s  " + log[told:].rstrip())
            told = len(log)
            time.sleep(0.2)
        self.fail(f"not in the log after {seconds} s: {patterns}\n{self.log()[-2000:]}")

    def until_over(self):
        """Waits until a print has finished and its report is written."""
        self.until("finished.*is the plate empty")

    def until_lit(self, lights, seconds=PATIENCE):
        end = time.monotonic() + seconds
        while len(self.stage.lights) < lights:
            self.assertLess(time.monotonic(), end, f"{len(self.stage.lights)} lights\n{self.log()[-2000:]}")
            time.sleep(0.001)

    def prints(self, first=0, cut=None, but=()):
        """
        Waits for the end of the print, then checks every pixel and step of its lights.
        @param first  layer of the first light that the stage has seen
        @param cut    a light that was cut short; the next one belongs to the same layer
        @param but    expected differences from an undisturbed print, in the words of objections()
        """
        self.until_over()
        lights = [light for number, light in enumerate(self.stage.lights) if number != cut]
        wrong = objections(lights, self.masks[first:], LAYER_STEPS, LIFT_STEPS, first)
        self.assertEqual(wrong + self.stage.trouble, list(but))
        seen = sum(light.before is not None for light in lights)
        self.assertGreater(seen, len(lights) // 2, "too few pictures were taken in time")

    def resumes(self):
        self.start_daemon()
        self.until("an interrupted print can go on")
        self.follow()
        self.press_start_until("homing")
        self.until_over()
        report = self.report()
        self.assertGreater(report["first_layer"], 0)
        self.assertEqual(report["state"], "finished")
        self.prints(report["first_layer"])

    def plug(self, image, **how):
        type(self).plugs += 1
        name = f"stick{self.plugs}"
        self.machine.plug(name, image, **how)
        self.plugged = name

    def pull(self):
        self.machine.pull(self.plugged)
        self.plugged = None

    def press_start(self):
        self.machine.set_line(START, 1)
        time.sleep(0.15)
        self.machine.set_line(START, 0)

    def press_start_until(self, words, after=""):
        """
        Presses start again and again: the daemon ignores a press in the first second after its question.
        @param after  only what the log says after the last of these words counts
        """
        end = time.monotonic() + PATIENCE
        while words not in (self.log().rpartition(after)[2] if after else self.log()):
            self.assertLess(time.monotonic(), end, self.log()[-2000:])
            self.press_start()
            time.sleep(1)

    def stick_files(self):
        """Descriptors of any process that lead to a stick; without one it is not mounted. Its device has the major number 8."""
        said = self.run_in_guest("for file in /proc/[0-9]*/fd/*; do stat -Lc %d $file 2> /dev/null; done; true")
        return sum(8 << 8 <= int(device) < 9 << 8 for device in said.split())

    def daemon_status(self, field):
        """A line of the daemon's /proc/PID/status. Its template has the same name and a higher number."""
        pid = min(map(int, self.run_in_guest("pidof plumblined").split()))
        return self.run_in_guest(f"grep {field} /proc/{pid}/status").split(":")[1].strip()

    def exposures(self):
        """Guest seconds of each period in which the lamp's line was on."""
        return intervals(trace_times(self.machine.run("cat /sys/kernel/tracing/trace")[1], self.lamp_gpio))

    def report(self):
        return json.loads(self.run_in_guest("cat /state/report.json"))


def main(about):
    """Runs the tests of the calling module: HOST_BUILD CROSS_BUILD [--arch arm64|armhf] [unittest's options]"""
    global OPTIONS
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("host", type=Path, help="build for this machine: its plumbline makes the masks that are compared with")
    parser.add_argument("cross", type=Path, help="build for the board")
    parser.add_argument("--arch", choices=("arm64", "armhf"), default="arm64")
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest])
