#!/usr/bin/env python3
"""A scan of 1,000,000 points for a panel of 1440 x 2560 pixels, in a guest with 256 MB: read, built, and its first layers printed.

Usage: full_size_test.py HOST_BUILD CROSS_BUILD [--arch arm64|armhf] [unittest options]
"""

import re
import subprocess
import time

import guest
import rig
from printer import objections

POINTS = 1_000_000
LAYERS = 3
# Minutes: an emulated processor is far slower than a board's.
SLICING_S = 1500


class FullSize(rig.Rig):
    BOARD = {
        "columns": 1440,
        "rows": 2560,
        "pixel_pitch_x_mm": 0.05,
        "pixel_pitch_y_mm": 0.05,
        "travel_mm": 65.0,
        "end_stop_height_mm": 75.0,
        "arena_mib": 96,
    }

    @classmethod
    def scans(cls):
        scan = cls.dir / "bust.ply"
        program = rig.OPTIONS.host / "firmware" / "plumbline"
        subprocess.run([program, "sample", scan, "--points", str(POINTS), "--quiet"], check=True)
        cls.masks = rig.masks_of(scan, cls.dir, cls.board, LAYERS)
        cls.stick = cls.dir / "bust.img"
        guest.make_stick(cls.stick, [scan])

    def available_mib(self):
        return int(re.search(r"MemAvailable: +(\d+)", self.run_in_guest("cat /proc/meminfo")).group(1)) / 1024

    def test_a_million_points_fit_256_mb(self):
        self.follow()
        self.start_daemon()
        at_first = least = self.available_mib()
        self.plug(self.stick)
        started = time.monotonic()
        while "the stick may be pulled" not in self.log():
            self.assertNotIn("PL-", self.log())
            self.assertLess(time.monotonic() - started, SLICING_S, self.log())
            least = min(least, self.available_mib())
            time.sleep(2)
        sliced = time.monotonic() - started
        self.until_lit(LAYERS + 1)
        least = min(least, self.available_mib())
        peak = int(re.search(r"(\d+)", self.run_in_guest("grep VmHWM /proc/$(pidof plumblined)/status")).group(1)) / 1024
        self.tell(f"{POINTS} points read and built in {sliced:.0f} s; resident at most {peak:.1f} MiB; "
                  f"{at_first:.0f} MiB available at first, {least:.0f} MiB at least")
        self.assertNotIn("Out of memory", self.machine.run("dmesg")[1])
        self.assertEqual(objections(self.stage.lights[:LAYERS], self.masks, rig.LAYER_STEPS, rig.LIFT_STEPS), [])
        self.assertEqual(self.stage.trouble, [])


if __name__ == "__main__":
    rig.main(__doc__)
