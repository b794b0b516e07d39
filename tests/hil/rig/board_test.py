#!/usr/bin/env python3
"""In real time: sticks that come and go, and a power cut.

Usage: board_test.py HOST_BUILD CROSS_BUILD [--arch arm64|armhf] [unittest options]

This machine runs only when the host gives it time, so these tests judge no milliseconds; exact_test.py does.
"""

import json
import re
import struct
import sys
import time
import zipfile
import zlib

import guest
import rig
from printer import LAMP

sys.path.append(str(guest.SOURCE / "tests/firmware/program"))
from rgb_picture import rgb_rows  # noqa: E402

# System calls that take memory, as the trace names them; mmap has another name on 32 bits.
MEMORY_CALLS = "events/syscalls/sys_enter_brk events/syscalls/sys_enter_mmap* events/syscalls/sys_enter_mremap"
# By whichever process of the daemon; `plumbline` itself is only asked for the state.
OURS_TAKES = r"^ *(plumbline(?!-\d+ )|libusb).*: sys_(brk|mmap|mremap)"


def grey_png(columns, rows):
    """A grey picture."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    pixels = zlib.compress((b"\0" + b"\x90" * columns) * rows)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


class Board(rig.Rig):
    PROGRAMS = ("firmware/plumbline",)
    SCREEN = 320, 240
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

    def test_pulled_while_reading_it_says_so_and_takes_the_next(self):
        self.start_daemon()
        self.plug(self.big_stick, bytes_per_second=400_000)
        self.until("reading big.ply")
        time.sleep(1)
        self.pull()
        self.until("PL-107")
        self.assertEqual(self.stick_files(), 0)
        self.plug(self.stick)
        self.until("the stick may be pulled")
        self.assertEqual(self.stick_files(), 0, "nothing stays mounted")
        self.until_lit(2)
        self.pull()
        self.prints()

    def test_bad_sticks_are_reported_and_the_next_works(self):
        hostile = self.dir / "hostile.ply"
        hostile.write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
                            b"property float y\nproperty float z\nend_header\n" + bytes(500))
        damaged, wrong = self.dir / "damaged.img", self.dir / "hostile.img"
        guest.make_stick(damaged, [self.scan], damaged=True)
        guest.make_stick(wrong, [hostile])
        self.start_daemon()
        for image, how, code in (
            (damaged, {}, "PL-109"),
            (wrong, {}, "PL-10"),
            (self.big_stick, {"bad_sector": 2048 + 5000}, "PL-10"),  # in the middle of the scan
        ):
            with self.subTest(stick=image.name, **how):
                self.plug(image, **how)
                self.until(code)
                self.assertEqual(self.stick_files(), 0)
                self.pull()
                self.run_in_guest("sleep 1; > /tmp/log")
        self.plug(self.stick)
        self.until("the stick may be pulled")

    def test_takes_no_memory_from_ready_on(self):
        # Traces the guest's first process and all it starts; the firmware's start shows that the trace works.
        self.run_in_guest("cd /sys/kernel/tracing; echo 1 > options/event-fork; echo 1 > set_event_pid;"
                          f" for call in {MEMORY_CALLS}; do echo 1 > $call/enable; done")
        self.start_daemon()
        self.run_in_guest("echo from here on > /sys/kernel/tracing/trace_marker")
        sizes = ("VmLck", "VmData", "VmRSS")
        at_ready = {name: self.daemon_status(name) for name in sizes}
        self.tell(f"at ready: {at_ready}")
        # Several scans and an archive are offered, each with a picture, and the first one is printed.
        stick, second, archive = self.dir / "reports.img", self.dir / "second.ply", self.dir / "third.sl1"
        rig.write_lentil(second, points=20_000)
        with zipfile.ZipFile(archive, "w") as written:
            for name, side in (("part1.png", 480), ("thumbnail/thumbnail400x400.png", 400)):
                written.writestr(name, grey_png(640 if side == 480 else side, side))
        guest.make_stick(stick, [self.scan, second, archive], folders=["plumbline-reports"])
        self.plug(stick, writable=True)
        self.until("scan 1 of 3")
        end = time.monotonic() + rig.PATIENCE
        while self.run_in_guest("plumbline status --json | grep -o '\"picture\": [0-9]' | wc -l").strip() != "3":
            self.assertLess(time.monotonic(), end, self.run_in_guest("plumbline status --json"))
        self.assertEqual({name: self.daemon_status(name) for name in sizes[:2]}, {name: at_ready[name] for name in sizes[:2]})
        self.tell(f"with pictures of the scans: {self.daemon_status('VmRSS')}")
        self.press_start_until("reading lentil.ply")
        self.prints()
        self.until("of the last prints are on the stick now")
        self.assertEqual(self.stick_files(), 0, "nothing stays mounted")
        names = guest.stick_folder(stick, "plumbline-reports")
        reports = [name for name in names if name.endswith(".json")]
        self.assertEqual(json.loads(guest.stick_file(stick, f"plumbline-reports/{reports[-1]}")), self.report())
        text = self.run_in_guest(f"cd /sys/kernel/tracing; cat trace; echo > set_event_pid; for call in {MEMORY_CALLS};"
                                 " do echo 0 > $call/enable; done")
        before, after = ([line for line in part.splitlines() if re.search(OURS_TAKES, line)]
                         for part in text.split("from here on"))
        for call in ("sys_brk", "sys_mmap"):
            self.assertTrue(any(call in line for line in before), f"{call} at the start: {before}")
        self.assertEqual(after, [])
        self.assertEqual({name: self.daemon_status(name) for name in sizes[:2]}, {name: at_ready[name] for name in sizes[:2]})
        self.tell(f"resident at most: {self.daemon_status('VmHWM')}")

    def test_its_screen_shows_what_the_golden_pictures_show(self):
        self.start_daemon()
        self.until_shown("idle")
        self.plug(self.stick)
        self.until_lit(3)
        self.until_shown("printing")
        self.prints()
        self.until_shown("finished")

    def until_shown(self, name):
        """Waits until the screen has the title of a golden picture, but for the printer's name."""
        wide, high = 3 * 200, 34  # bytes, rows
        rows_of_it = rgb_rows(guest.SOURCE / f"tests/firmware/screen/golden/{name}-320.png", high)[1]
        golden = b"".join(row[:wide] for row in rows_of_it)
        end = time.monotonic() + rig.PATIENCE
        while time.monotonic() < end:
            columns, rows, shown = self.machine.colours("screen")
            title = b"".join(shown[3 * columns * y : 3 * columns * y + wide] for y in range(high))
            # PNG files and panels widen five and six bits to eight in ways that differ by a few levels.
            if (columns, rows) == self.SCREEN and all(abs(a - b) <= 4 for a, b in zip(title, golden)):
                return
            time.sleep(0.2)
        self.fail(f"the screen of {columns} x {rows} pixels has another title than {name}")

    def test_setup_lists_what_the_board_has(self):
        free = self.run_in_guest("plumbline setup --list")
        for words in ("Virtual-1", "/dev/watchdog0"):
            self.assertIn(words, free)
        lines = [line for line in free.splitlines() if "9030000.pl061" in line]
        self.assertEqual([re.search(r"9030000\.pl061 (\d)", line).group(1) for line in lines], list("01234567"), free)
        self.start_daemon()
        held = self.run_in_guest("plumbline setup --list")
        self.tell(held)
        # Line 3 is nobody's (board/rig.toml).
        held_by = {int(line): who for line, who in re.findall(r"9030000\.pl061 (\d).* held by (.*)", held)}
        self.assertEqual(set(held_by), {0, 1, 2, 4, 5, 6, 7}, held)

    def test_a_reader_that_crashes_is_an_error_of_its_scan_and_has_no_rights(self):
        self.start_daemon()
        self.plug(self.big_stick, bytes_per_second=400_000)
        self.until("reading big.ply")
        self.run_in_guest("until pidof plumbline-scan; do usleep 10000; done")
        time.sleep(1)
        child = "/proc/$(pidof plumbline-scan)"
        status = self.run_in_guest(f"cat {child}/status")
        for line in ("CapEff:\t0000000000000000", "NoNewPrivs:\t1", "Seccomp:\t2"):
            self.assertIn(line, status)
        self.assertEqual(self.run_in_guest(f"ls {child}/fd").split(), ["0"])
        self.run_in_guest("kill -SEGV $(pidof plumbline-scan)")
        self.until("PL-102.*big.ply.*signal 11")
        self.assertEqual(self.stick_files(), 0)
        self.pull()
        self.plug(self.stick)
        self.until("the stick may be pulled")

    def test_power_cut_in_mid_print_then_it_resumes_with_the_same_masks(self):
        self.start_daemon()
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
