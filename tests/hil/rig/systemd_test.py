#!/usr/bin/env python3
"""The package installed by dpkg on a board whose first process is Debian's systemd: the units as they are shipped.

Usage: systemd_test.py HOST_BUILD CROSS_BUILD [--arch arm64|armhf] [unittest options]
"""

import json
import re
import subprocess
import tempfile
from pathlib import Path

import guest
import rig
from machine import Machine

UNITS = ("plumblined", "plumbline-mount", "plumbline-awake")
STATE = "/var/lib/plumbline"


class Systemd(rig.Rig):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="plumbline-rig-")
        cls.addClassCleanup(folder.cleanup)
        cls.dir = Path(folder.name)
        cls.board = guest.board_text(cls.BOARD)
        cls.scans()
        cls.plugs = 0
        made = cls.dir / "made"
        subprocess.run(["cpack", "--config", rig.OPTIONS.cross / "CPackConfig.cmake", "-B", made], check=True, capture_output=True)
        (package,) = made.glob("*.deb")
        files = {
            "plumbline.deb": package.read_bytes(),
            "etc/plumbline/rig.toml": cls.board.encode(),
            "etc/plumbline/profiles/quick.toml": (guest.HERE / "quick.toml").read_bytes(),
            "etc/default/plumbline": b"PLUMBLINE_PRINTER=/etc/plumbline/rig.toml\n",
            "etc/tmpfiles.d/rig.conf": b"d /run/rig\n" + b"".join(
                b"f /run/rig/%s_temperature - - - - 24500\n" % sensor for sensor in (b"lamp", b"resin", b"board")),
        }  # fmt: skip
        disk = guest.make_systemd_disk(rig.OPTIONS.arch, cls.dir, files)
        root = guest.make_root(rig.OPTIONS.arch)
        guest.make_boot_initramfs(root, cls.dir / "initramfs")
        panel = cls.BOARD["columns"], cls.BOARD["rows"]
        cls.machine = Machine(cls.dir, guest.kernel_of(root), cls.dir / "initramfs", rig.OPTIONS.arch, memory_mb=512, disk=disk, panel=panel)
        cls.addClassCleanup(cls.machine.end)
        cls.boot()
        cls.tell(cls.run_in_guest("dpkg --force-depends --install /plumbline.deb; systemctl enable plumblined"))

    def setUp(self):
        self.plugged, self.stage = None, None
        self.run_in_guest(f"rm -rf {STATE}; mkdir {STATE}; touch {STATE}/plate-is-empty {STATE}/tank-is-full; chown -R plumbline:plumbline {STATE};"
                          "systemctl reset-failed")
        if self.machine.run("systemctl start plumblined")[0]:
            self.fail("plumblined does not start:\n" + self.journal())
        self.follow()

    def tearDown(self):
        if not self._outcome.success:
            self.tell(self.journal())
        self.run_in_guest("systemctl stop plumblined")
        self.stage.end()
        if self.plugged:
            self.pull()

    def journal(self):
        return self.machine.run("journalctl --no-pager -o short-monotonic | tail -n 60")[1]

    def log(self):
        """What the daemon has said since it was started last."""
        return self.machine.run("journalctl --no-pager -o cat _SYSTEMD_INVOCATION_ID=$(systemctl show plumblined -p InvocationID --value)")[1]

    def show(self, unit, *names):
        said = self.run_in_guest(f"systemctl show {unit} -p {','.join(names)}")
        return dict(line.split("=", 1) for line in said.splitlines())

    def status_of(self, pid):
        return dict(re.findall(r"^(\w+):\s*(.*)$", self.run_in_guest(f"cat /proc/{pid}/status"), re.MULTILINE))

    def test_the_daemon_is_ready_with_the_rights_that_it_needs_and_no_others(self):
        for unit in UNITS:
            self.assertEqual(self.show(unit, "ActiveState")["ActiveState"], "active", unit)
        pid = self.show("plumblined", "MainPID")["MainPID"]
        told = self.status_of(pid)
        user = self.run_in_guest("id -u plumbline")
        self.assertEqual(told["Uid"].split(), [user] * 4)
        self.assertEqual((told["NoNewPrivs"], told["Seccomp"]), ("1", "2"))
        bits = {26: "CAP_SYS_TTY_CONFIG", 36: "CAP_BLOCK_SUSPEND"}
        self.assertEqual(int(told["CapEff"], 16), sum(1 << bit for bit in bits))
        self.assertGreater(int(told["VmLck"].split()[0]), 64 << 10)  # kB: the arena
        self.assertEqual(self.run_in_guest(f"cat /proc/{pid}/oom_score_adj"), "-900")
        self.assertIn("SCHED_FIFO", self.run_in_guest(f"chrt --all-tasks --pid {pid}"))
        self.assertEqual(self.run_in_guest("stat -c '%U %a' /run/plumbline/state"), "plumbline 666")

    def test_a_stick_is_printed_and_everybody_may_read_the_state(self):
        self.plug(self.stick)
        self.until("the stick may be pulled")
        nobody = "setpriv --reuid nobody --regid nogroup --clear-groups plumbline"
        self.assertEqual(json.loads(self.run_in_guest(f"{nobody} status --json"))["job"]["scan"], "lentil.ply")
        status, said = self.machine.run(f"{nobody} ctl cancel")
        self.assertEqual(status, 1, said)
        self.assertIn("state.command", said)
        self.prints()

    def test_a_stick_with_the_folder_gets_the_reports_from_the_helper_alone(self):
        stick = self.dir / "reports.img"
        guest.make_stick(stick, [self.scan], folders=["plumbline-reports"])
        self.plug(stick, writable=True)
        self.until_lit(1)
        self.run_in_guest("plumbline ctl cancel")  # a cancelled print has a report, too, and is over sooner
        self.until("of the last prints are on the stick now")
        report = json.loads(self.run_in_guest(f"cat {STATE}/report.json"))
        # Nobody holds the stick any more, and no mount of it was ever seen outside the helper.
        self.assertEqual(self.stick_files(), 0)
        self.assertNotIn("/dev/sd", self.run_in_guest("cat /proc/mounts"))
        self.assertEqual(self.show("plumbline-mount", "NRestarts", "ActiveState"), {"NRestarts": "0", "ActiveState": "active"})
        self.pull()
        names = guest.stick_folder(stick, "plumbline-reports")
        self.assertEqual(sorted(name.rsplit(".")[-1] for name in names), ["json", "png"], names)
        (named,) = (name for name in names if name.endswith(".json"))
        self.assertEqual(json.loads(guest.stick_file(stick, f"plumbline-reports/{named}")), report)
        self.assertEqual(report["state"], "cancelled")

    def test_a_killed_daemon_comes_back_and_the_print_goes_on(self):
        self.plug(self.stick)
        self.until_lit(3)
        self.run_in_guest("kill -9 $(systemctl show plumblined -p MainPID --value)")
        self.until("an interrupted print can go on")
        self.assertFalse(self.stage.lit())
        self.assertEqual(self.show("plumblined", "NRestarts", "ActiveState"), {"NRestarts": "1", "ActiveState": "active"})
        self.press_start_until("homing")
        self.until_over()

    def test_a_stop_ends_the_light_and_keeps_the_print(self):
        self.plug(self.stick)
        self.until_lit(3)
        self.run_in_guest("systemctl stop plumblined")
        self.assertFalse(self.stage.lit())
        told = self.show("plumblined", "ActiveState", "Result", "ExecMainStatus")
        self.assertEqual((told["ActiveState"], told["Result"]), ("inactive", "success"), told)
        self.assertEqual(self.show("plumbline-mount", "ActiveState")["ActiveState"], "inactive")
        self.run_in_guest("systemctl start plumblined")
        self.until("an interrupted print can go on")

    def test_the_board_does_not_go_to_sleep(self):
        self.assertIn("plumbline", self.run_in_guest("systemd-inhibit --list --no-pager"))
        # Without a terminal, root's command would not ask, and end the daemon first.
        status, said = self.machine.run("systemctl suspend --check-inhibitors=yes")
        self.assertNotEqual(status, 0)
        self.assertIn("plumbline", said)


if __name__ == "__main__":
    rig.main(__doc__)
