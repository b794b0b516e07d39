#!/usr/bin/env python3
"""What a printer goes through, at real moments: sticks plugged and pulled, an opened cover, a power cut.

Usage: board_test.py HOST_BUILD CROSS_BUILD [--arch arm64|armhf] [unittest options]

This machine runs as the host lets it, so no milliseconds are judged here: exact_test.py does that.
"""

import time

import guest
import rig
from printer import COVER, LAMP


class Board(rig.Rig):
    maxDiff = None

    @classmethod
    def scans(cls):
        super().scans()
        rig.write_lentil(cls.dir / "big.ply", points=150_000)
        cls.big_stick = cls.dir / "big.img"
        guest.make_stick(cls.big_stick, [cls.dir / "big.ply"])

    def setUp(self):
        super().setUp()
        self.follow()
        self.start_daemon()

    def test_pulled_in_mid_read_it_says_so_and_takes_the_next(self):
        self.plug(self.big_stick, bytes_per_second=1_000_000)
        self.until("reading big.ply")
        time.sleep(1)
        self.pull()
        self.until("PL-107")
        self.assertEqual(self.mounts(), 0)
        self.plug(self.stick)
        self.until("the stick may be pulled")
        self.assertEqual(self.mounts(), 0, "nothing stays mounted")
        self.until_lit(2)
        self.pull()
        self.prints()

    def test_cover_opened_in_an_exposure_is_dark_and_goes_on_when_told(self):
        self.plug(self.stick)
        self.until_lit(3)
        self.machine.set_line(COVER, 1)
        self.until("cover open")
        self.assertFalse(self.stage.lit())
        cut = self.exposures()
        self.assertEqual(len(cut), len(self.stage.lights))
        self.assertLess(cut[-1], 0.99, "it was to last a second")
        self.machine.set_line(COVER, 0)
        self.until("paused")
        self.assertEqual(len(self.exposures()), len(cut), "it waits to be told")
        self.press_start()
        # The rest of the layer comes after the pause's lift, which is 10 mm (quick.toml).
        light = len(cut) - 1
        self.prints(cut=light, but=[f"light {light}: {95 + 2 * 500} steps before it and not 95"])

    def test_bad_sticks_are_told_and_the_next_works(self):
        hostile = self.dir / "hostile.ply"
        hostile.write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
                            b"property float y\nproperty float z\nend_header\n" + bytes(500))
        damaged, wrong = self.dir / "damaged.img", self.dir / "hostile.img"
        guest.make_stick(damaged, [self.scan], damaged=True)
        guest.make_stick(wrong, [hostile])
        for image, how, code in (
            (damaged, {}, "PL-109"),
            (wrong, {}, "PL-10"),
            (self.big_stick, {"bad_sector": 2048 + 5000}, "PL-10"),  # in the middle of the scan
        ):
            with self.subTest(stick=image.name, **how):
                self.plug(image, **how)
                self.until(code)
                self.assertEqual(self.mounts(), 0)
                self.pull()
                self.run_in_guest("sleep 1; > /tmp/log")
        self.plug(self.stick)
        self.until("the stick may be pulled")

    def test_takes_no_memory_from_ready_on(self):
        calls = [f"events/syscalls/sys_enter_{call}/enable" for call in ("brk", "mmap", "mremap")]
        # All threads of the firmware and of its keeper, and what they start.
        self.run_in_guest("cd /sys/kernel/tracing; echo > trace; echo 1 > options/event-fork; for process in $(pidof plumblined"
                          " plumbline-keeper); do ls /proc/$process/task; done > set_event_pid; "
                          + "; ".join(f"echo 1 > {call}" for call in calls))
        self.plug(self.stick)
        self.prints()
        text = self.machine.run("cd /sys/kernel/tracing; cat trace; echo > set_event_pid; "
                                + "; ".join(f"echo 0 > {call}" for call in calls))[1]
        taken = [line for line in text.splitlines() if "sys_brk" in line or "sys_mmap" in line or "sys_mremap" in line]
        self.assertEqual(taken, [])
        peak = self.machine.run("grep VmHWM /proc/$(pidof plumblined)/status")[1]
        self.tell(f"resident at most: {peak}")

    def test_power_cut_in_mid_print_then_it_resumes_with_the_same_masks(self):
        self.plug(self.stick)
        self.until_lit(5)
        time.sleep(0.2)
        self.machine.ask("system_reset")
        self.boot()
        self.pull()
        self.assertFalse(self.machine.level.get(LAMP, False))
        self.resumes()


if __name__ == "__main__":
    rig.main(__doc__)
