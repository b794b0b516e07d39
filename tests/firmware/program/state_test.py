#!/usr/bin/env python3
"""The printer's state and its commands, over the real sockets of a real plumblined: every state and command that a print has, and clients
that mean harm. The schema of firmware/state checks every line where python3-jsonschema is installed."""

import json
import os
import shutil
import socket
import stat
import subprocess
import threading
import time
import unittest
from pathlib import Path

from case import PLUMBLINE, SOURCE_DIR, main, write_sphere
from state_client import SCHEMA, SECONDS, Client, Draft202012Validator, StatePrinter


class State(StatePrinter):
    def test_a_print_from_the_plate_to_the_plate_with_every_command(self):
        daemon, user = self.start("--fault", "cover.opens@layer=9,for=60s", plate=False, speedup=50)
        first = user.state("plate in use", "plate-empty")
        self.assertEqual((first["commands"], first["job"], first["stick"]["present"]), (["plate-empty"], None, False))
        user.refused("'plate in use'. It takes plate-empty", "start")
        user.do("plate-empty")
        user.state("idle")
        user.refused("'idle'. It takes no command now", "offer")
        self.put_stick({"a.ply": 2, "b.ply": 2.0, "empty.xyz": b""})
        offered = user.state("offered", "start")
        self.assertEqual([scan["name"] for scan in offered["stick"]["scans"]], ["a.ply", "b.ply", "empty.xyz"])
        self.assertEqual([scan["problem"] for scan in offered["stick"]["scans"]], [None, None, "the file is empty"])
        self.assertEqual(offered["stick"]["scans"][0]["bytes"], (self.stick / "a.ply").stat().st_size)
        self.assertEqual((offered["job"]["scan"], offered["job"]["number"]), ("a.ply", 1))
        self.assertEqual(offered["commands"], ["start", "cancel", "choose", "set", "propose"])
        # Declined, and offered again.
        user.do("cancel")
        user.state("idle", "offer")
        user.do("offer")
        user.state("offered", "choose")
        user.refused("there is no scan 4", "choose", scan=4)
        user.do("choose", scan=2)
        user.until(lambda s: s["job"]["scan"] == "b.ply" and s["job"]["number"] == 2, "b.ply")
        for key, value, words in (("scale", 0, "allowed is 1e-6"), ("scael", 1, "unknown setting"), ("profile", "thicc", "no profile"),
                                  ("units", "furlong", "mm, cm"), ("fit", 1, "true or false"), ("supports", "some", "none or auto"),
                                  ("support_stand", "up", "auto, plate or raised"), ("support_pillar_diameter", 11, "0.2 to 10 mm"),
                                  ("height", "tall", "a length from 1 mm"), ("floor", "deep", "auto, keep"), ("orient", "up", "none or auto"),
                                  ("keep_clean", "face", "none, +x, -x")):
            user.refused(words, "set", key=key, value=value)
        for key, value in (("height", "2cm"), ("floor", -3.5), ("keep_clean", "-y"), ("orient", "auto")):
            user.do("set", key=key, value=value)
        job = user.until(lambda s: s["job"]["orient"] == "auto", "a size")["job"]
        self.assertEqual((job["size"], job["floor"], job["keep_clean"], job["scale"]), ({"side": "height", "mm": 20}, -3.5, "-y", 1))
        user.do("set", key="floor", value="auto")
        for key, value in (("support_stand", "raised"), ("support_buildplate_only", True), ("support_object_elevation", 3)):
            user.do("set", key=key, value=value)
        user.do("set", key="support_buildplate_only", value="")
        user.until(lambda s: s["job"]["support_values"] == {"support_stand": "raised", "support_object_elevation": 3}, "supports")
        for key in ("support_stand", "support_object_elevation"):
            user.do("set", key=key, value="")
        # A scale takes the place of a size, and a rotation that of the best way up.
        for key, value in (("scale", 0.5), ("profile", "draft"), ("supports", "none"), ("layer_height", 0.1), ("keep_all", True),
                           ("rotate_z_deg", -90), ("base", "none"), ("units", "mm"), ("fit", "false")):
            user.do("set", key=key, value=value)
        job = user.until(lambda s: s["job"]["rotate_z_deg"] == -90 and s["job"]["fit"] is False, "the settings")["job"]
        self.assertEqual((job["scale"], job["profile"], job["supports"], job["layer_height"], job["keep_all"], job["base"],
                          job["size"], job["orient"], job["floor"]),
                         (0.5, "draft", "none", 0.1, True, "none", None, "none", "auto"))
        user.do("set", key="layer_height", value="")
        user.do("start")
        # Homing takes some 40 ms here. A client that is late for it gets the newest state.
        user.until(lambda s: s["state"] in ("homing", "printing"), "homing or printing")
        user.do("pause")
        paused = user.state("paused", "resume")
        self.assertEqual(paused["commands"], ["resume", "cancel"])
        self.assertIsNone(paused["progress"]["ends_at"])
        user.do("resume")
        printing = user.until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] > 2, "layer 3")
        self.assertGreater(printing["progress"]["layers"], 10)
        self.assertGreater(printing["progress"]["slack_s"], 0)
        self.assertGreater(printing["progress"]["left_s"], 0)
        self.assertIsNotNone(printing["progress"]["ends_at"])
        self.assertGreater(printing["resin"]["needed_ml"], printing["resin"]["used_ml"])
        self.assertIn("cover", [check["check"] for check in printing["checks"]])
        user.state("cover open")
        user.state("paused", "resume")
        user.do("resume")
        done = user.state("plate in use", "plate-empty")
        self.assertEqual(done["job"]["result"], "finished")
        machine = done["machine"]
        self.assertAlmostEqual(machine["resin_ml"], 180 - done["resin"]["used_ml"], delta=0.002)
        self.assertEqual((machine["filled_ml"], machine["film_layers"], machine["unseen_faults"]), (180, done["progress"]["layers"], []))
        self.assertGreater(machine["hottest_c"]["lamp"], 25)
        self.assertLessEqual(done["temperatures_c"]["lamp"], round(machine["hottest_c"]["lamp"]))
        self.assertIsNone(done["address"], "sim2k has no page on the network")
        user.refused("a full tank holds 180 ml", "filled", ml=181)
        user.do("filled", ml=50.5)
        user.until(lambda s: s["machine"]["resin_ml"] == 50.5, "what somebody says")
        user.do("filled")
        user.until(lambda s: s["machine"]["resin_ml"] == 180, "a full tank")
        self.assertEqual(done["progress"]["layers_done"], done["progress"]["layers"])
        self.assertEqual(len(done["findings"]) > 0, True, "the ball is 2 mm long, which is suspicious")
        small = done["findings"][0]["told"]
        self.assertEqual(small["code"], "object_small")
        self.assertAlmostEqual(small["values"]["longest_mm"], 2, delta=0.1)
        self.assertEqual([check["check"] for check in done["checks"] if not check["told"]], [], "a check has no code")
        user.do("plate-empty")
        user.state("offered", "start")
        user.do("start")
        user.until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] > 0, "layer 1")
        user.do("cancel")
        cancelled = user.state("plate in use", "plate-empty")
        self.assertEqual(cancelled["job"]["result"], "cancelled")
        self.check_kept_prints(user, cancelled)
        self.check_stored_reports(user, cancelled)
        sequences = [state["sequence"] for state in user.states]
        self.assertEqual(sequences, sorted(set(sequences)))
        daemon.terminate()
        self.assertEqual(daemon.wait(60), 0)

    def check_stored_reports(self, user, state):
        """A folder on the stick gets the reports of both prints, and nothing is overwritten."""
        folder = self.dir / "stick/plumbline-reports"
        folder.mkdir()
        names = [
            f"sim2k-{kept['ended_at'][:10].replace('-', '')}-{kept['number']:04}"
            for kept in reversed(state["prints"])
        ]
        (folder / f"{names[0]}.png").write_text("mine")
        user.do("plate-empty")
        user.state("offered", "start")
        stored = [f"{names[0]}.json", f"{names[0]}.png", f"{names[1]}.json"]
        self.assertEqual(sorted(path.name for path in folder.iterdir() if path.name != f"{names[1]}.png"), stored)
        self.assertEqual((folder / f"{names[0]}.png").read_text(), "mine")
        self.assertEqual((folder / f"{names[1]}.json").read_bytes(), (self.folder / "report.json").read_bytes())

    def check_kept_prints(self, user, state):
        """The two prints of before, by socket and command line."""
        second, first = state["prints"]
        self.assertEqual((first["number"], first["scan"], first["profile"], first["result"], first["layers_done"], first["preview"]),
                         (1, "b.ply", "draft", "finished", first["layers"], True))
        self.assertEqual((second["number"], second["result"]), (2, "cancelled"))
        self.assertLess(second["layers_done"], second["layers"])
        user.refused("print 3 is not kept", "report", print=3, **{"from": 0})
        user.refused("only the preview", "picture", picture="layer", print=1)
        report, picture = self.dir / "kept.json", self.dir / "kept.png"
        for number, kept in ((1, first), (2, second)):
            self.run_it("status", "--socket", self.path, "--report", number, "-o", report)
            told = json.loads(report.read_text())
            self.assertEqual((told["state"], told["next_layer"]), (kept["result"], kept["layers_done"]))
        self.assertEqual(report.read_bytes(), (self.folder / "report.json").read_bytes())
        self.run_it("status", "--socket", self.path, "--preview", 1, "-o", picture)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        shown = self.run_it("status", "--socket", self.path, "--prints").stdout
        self.assertRegex(shown, r"(?m)^ +2 .* cancelled .* b\.ply\n +1 .* finished .* b\.ply$")

    def test_says_where_its_page_is_and_how_warm_it_is(self):
        shutil.copytree(SOURCE_DIR / "board/profiles", self.dir / "profiles")
        printer = self.dir / "sim2k.toml"
        printer.write_text((SOURCE_DIR / "board/sim2k.toml").read_text().replace('page = "off"', 'page = "network"'))
        _, user = self.start(printer=printer)
        state = user.state("idle")
        self.assertEqual(state["temperatures_c"], {"lamp": 25, "resin": 25, "board": 45})
        if state["address"] is None:
            up = [path.parent.name for path in Path("/sys/class/net").glob("*/operstate") if path.read_text().strip() == "up"]
            self.assertEqual([name for name in up if name != "lo"], [])
        else:
            self.assertRegex(state["address"], r"^http://([\d.]+|[\w-]+\.local):8080$")

    def test_a_fault_says_what_to_do_and_its_scan_is_marked(self):
        daemon, user = self.start()
        self.put_stick({"bad.ply": b"ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
                                  b"end_header\n1 2 3\n", "good.ply": 2})
        user.state("offered", "start")
        user.do("start")
        fault = user.state("fault", "seen")
        self.assertEqual(fault["fault"]["code"], "PL-102")
        self.assertNotIn("--", fault["fault"]["remedy"])
        shown = self.run_it("status", "--socket", self.path).stdout
        self.assertIn("PL-102, not a scan", shown)
        self.assertRegex(shown, r"(?m)^do +\S")
        user.do("seen")
        again = user.state("offered", "start")
        self.assertIsNone(again["fault"])
        self.assertIn("PL-102", again["stick"]["scans"][0]["problem"])
        # The same as a code, which has come out of the slicing child: the file ends too early.
        self.assertEqual((fault["fault"]["told"], again["stick"]["scans"][0]["told"]), ({"code": "file_cut", "values": {}},) * 2)
        # A power cut's print: seen, resumed, given up.
        user.do("choose", scan=2)
        user.do("start")
        user.until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] > 1, "layer 2")
        daemon.kill()
        daemon.wait(60)
        _, user = self.start(plate=False)
        self.assertEqual(user.state("interrupted", "resume")["commands"], ["resume", "cancel"])
        user.do("resume")
        user.state("homing")
        # Regression: cancelled before the stage knew its height, it ended with PL-903, a mistake in the firmware.
        user.do("cancel")
        self.assertEqual(user.state("plate in use", "plate-empty")["job"]["result"], "cancelled")

    def test_a_report_that_cant_be_kept_disturbs_no_print(self):
        _, user = self.start(speedup=1e4)
        (self.folder / "prints").rmdir()  # now nothing can be written in it
        self.put_stick({"a.ply": 2})
        for _ in range(2):
            user.state("offered", "start")
            user.do("start")
            done = user.state("plate in use", "plate-empty")
            self.assertEqual((done["job"]["result"], done["report"], done["prints"]), ("finished", True, []))
            user.do("plate-empty")

    @unittest.skipUnless(Draft202012Validator, "no python3-jsonschema")
    def test_the_schema_holds_for_the_examples_and_for_nothing_else(self):
        check = Draft202012Validator(SCHEMA)
        examples = [json.loads(line) for line in (SOURCE_DIR / "firmware/state/examples.ndjson").read_text().splitlines()]
        for example in examples:
            check.validate(example)
        wrong = {**examples[0], "state": "printin"}
        self.assertFalse(check.is_valid(wrong))
        self.assertTrue(check.is_valid({"do": "set", "key": "fit", "value": True}))
        self.assertFalse(check.is_valid({"do": "set", "kye": "fit"}))

    def test_a_script_uploads_a_scan_and_nothing_else(self):
        _, user = self.start()
        user.state("idle")

        def upload(name, size, file):
            user.asked += 1
            request = {"do": "upload", "name": name, "bytes": size, "id": user.asked}
            socket.send_fds(user.socket, [json.dumps(request).encode() + b"\n"], [file.fileno()])
            while not user.replies or user.replies[-1]["id"] != user.asked:
                user.receive(time.monotonic() + 30)
            return user.replies[-1]

        write_sphere(self.dir / "a.ply", points=5000, radius=2)
        scan = (self.dir / "a.ply").read_bytes()
        with open("/dev/zero", "rb") as file:
            self.assertIn("no socket", upload("a.ply", 5, file)["error"])
        user.refused("no socket", "upload", name="a.ply", bytes=5)
        ours, theirs = socket.socketpair()
        with ours:
            with theirs:
                self.assertEqual(upload("a.ply", len(scan), theirs), {"type": "reply", "id": user.asked, "ok": True, "upload": 1})
            ours.sendall(scan)
        offered = user.state("offered", "start")
        self.assertEqual((offered["upload"]["stage"], offered["stick"]["uploaded"]), ("kept", True))
        self.assertRegex(self.run_it("status", "--socket", self.path).stdout, r"(?m)^uploaded +\*  1  a.ply")
        user.do("start")
        user.state("plate in use", "plate-empty")
        self.assertEqual(user.states[-1]["job"]["result"], "finished")

    def ctl(self, *words, status=0):
        return self.run_it("ctl", *words, "--socket", self.path, status=status).stderr

    def test_ctl_uploads_a_scan_and_removes_it(self):
        daemon, user = self.start(speedup=1e4)
        user.state("idle")
        store = self.folder / "uploads"

        def stored():
            return sorted(path.name for path in store.iterdir())

        scan = self.dir / "Büste <1>.ply"
        write_sphere(scan, points=5000, radius=2)
        self.assertIn("takes no command", self.ctl("remove", "a.ply", status=1))
        self.assertIn("in the printer's store: B_ste _1_.ply", self.ctl("upload", scan))
        self.assertEqual((store / "B_ste _1_.ply").read_bytes(), scan.read_bytes())
        offered = user.state("offered", "start")
        self.assertEqual(offered["stored"], {"name": "B_ste _1_.ply", "bytes": scan.stat().st_size})
        self.assertRegex(self.run_it("status", "--socket", self.path).stdout, r"(?m)^stored +B_ste _1_.ply, 0.1 MB, uploaded$")
        # The same limits as for a browser, in the printer's words. What was there stays.
        empty, other, large, fifo = (self.dir / name for name in ("empty.ply", "notes.doc", "large.ply", "pipe.ply"))
        empty.write_bytes(b"")
        other.write_bytes(b"x")
        with open(large, "wb") as file:
            file.truncate((256 << 20) + 1)
        os.mkfifo(fifo)
        for path, words in ((empty, "the file is empty"), (other, "not have the ending of a scan, mesh or sliced archive"), (large, "takes 256 MiB at most"),
                            (fifo, "is not a file"), (self.dir, "is not a file"), (self.dir / "none.ply", "No such file")):
            self.assertIn(words, self.ctl("upload", path, status=1))
        self.assertEqual(stored(), ["B_ste _1_.ply"])
        large.unlink()
        # A large one, of which nothing is half there.
        with open(large, "wb") as file:
            file.write(os.urandom(1 << 20) * 30)
        self.ctl("upload", large)
        self.assertEqual(stored(), ["large.ply"])
        self.assertEqual((store / "large.ply").read_bytes(), large.read_bytes())
        user.until(lambda s: s["state"] == "offered" and s["job"] and s["job"]["scan"] == "large.ply" and s["commands"], "offered")
        # It goes by its name, and only as it is shown.
        self.assertIn("is not in the printer's store. The scan there is large.ply", self.ctl("remove", "../journal", status=1))
        self.assertEqual(self.ctl("remove", "large.ply"), "")
        idle = user.until(lambda s: s["state"] == "idle" and not s["stored"], "idle")
        self.assertEqual((stored(), idle["stick"]["scans"]), ([], []))
        self.assertIn("takes no command", self.ctl("remove", "large.ply", status=1))
        # Not while it prints, and it says why.
        self.ctl("upload", scan)
        user.until(lambda s: s["state"] == "offered" and s["commands"], "offered")
        user.do("start")
        user.until(lambda s: s["state"] == "printing", "printing")
        self.assertIn("takes a scan while it is at rest", self.ctl("upload", scan, status=1))
        self.assertIn("It takes", self.ctl("remove", "B_ste _1_.ply", status=1))
        user.state("plate in use", "plate-empty")
        self.ctl("remove", "B_ste _1_.ply")
        user.do("plate-empty")
        user.until(lambda s: s["state"] == "idle" and not s["stored"], "nothing is offered again")
        daemon.kill()
        daemon.wait()
        self.assertIn("no plumblined serves", self.ctl("upload", scan, status=1))

    def test_an_upload_by_ctl_that_breaks_off_leaves_nothing(self):
        daemon, user = self.start()
        user.state("idle")
        store = self.folder / "uploads"
        large = self.dir / "large.ply"
        with open(large, "wb") as file:
            file.truncate(250 << 20)

        def begin():
            sender = subprocess.Popen([PLUMBLINE, "ctl", "upload", large, "--socket", self.path], stderr=subprocess.PIPE, text=True)
            self.addCleanup(sender.stderr.close)
            user.until(lambda s: s["upload"] and s["upload"]["stage"] == "coming" and s["upload"]["received"] > 0, "it comes")
            return sender

        sender = begin()
        sender.kill()
        sender.wait()
        failed = user.until(lambda s: s["upload"]["stage"] == "failed", "the printer notices")
        self.assertRegex(failed["upload"]["problem"], r"ended after \d+ of 262144000 bytes")
        self.assertEqual(list(store.iterdir()), [])
        # A job begins: it ends the upload, which the program says.
        self.put_stick({"a.ply": 2})
        user.state("offered", "start")
        sender = begin()
        user.do("start")
        self.assertEqual(sender.wait(60), 1)
        self.assertIn("begun another job", sender.stderr.read())
        self.assertEqual(list(store.iterdir()), [])
        user.do("cancel")
        user.state("idle", "offer")
        # The daemon is killed.
        sender = begin()
        daemon.kill()
        daemon.wait()
        self.assertEqual(sender.wait(60), 1)
        self.assertIn("plumblined has ended", sender.stderr.read())
        self.start()
        self.assertEqual(list(store.iterdir()), [])

    def test_the_programs_show_and_command(self):
        self.put_stick({"a.ply": 2}, '[job]\nscan = "a.ply"\n')
        daemon, user = self.start(speedup=1e4)
        user.state("offered", "start")
        shown = self.run_it("status", "--socket", self.path)
        self.assertIn("job.toml asks for a.ply", shown.stdout)
        self.assertRegex(shown.stdout, r"(?m)^ctl +start, cancel, set, propose$")
        follower = subprocess.Popen([PLUMBLINE, "status", "--follow", "--json", "--socket", self.path], stdout=subprocess.PIPE, text=True)
        self.addCleanup(follower.wait)
        self.addCleanup(follower.stdout.close)
        follower.stdout.readline()
        self.assertIn("allowed is 1e-6", self.run_it("ctl", "set", "scale", "big", "--socket", self.path, status=1).stderr)
        self.assertIn("It takes start, cancel, set, propose", self.run_it("ctl", "choose", "1", "--socket", self.path, status=1).stderr)
        self.run_it("ctl", "set", "scale", "0.5", "--socket", self.path)
        self.run_it("ctl", "start", "--socket", self.path)
        # It ends with the daemon.
        self.assertTrue(any(json.loads(line)["job"]["result"] == "finished" for line in follower.stdout))
        daemon.terminate()
        for _ in follower.stdout:
            pass
        self.assertEqual(follower.wait(60), 0)
        self.assertEqual(stat.S_IMODE(self.path.stat().st_mode), 0o666)
        self.assertEqual(stat.S_IMODE(self.commands.stat().st_mode), 0o660)

    def memory(self, daemon):
        """Sizes of the process, kB."""
        with open(f"/proc/{daemon.pid}/status", encoding="ascii") as file:
            return {line.split(":")[0]: int(line.split()[1]) for line in file if line.startswith(("VmData", "VmStk", "VmLck"))}

    def print_once(self, user):
        user.do("start")
        user.state("printing")
        done = user.state("plate in use", "plate-empty")
        self.assertEqual(done["job"]["result"], "finished")
        return json.loads((self.folder / "report.json").read_text())

    def harm(self, stop, counts):
        """Clients that mean harm, until `stop` is set."""
        sleepers = []
        lines = [b"x" * 1_000_000, b'{"do": "st\xc3\n', b"\xff\xfe\n", b"[" * 1000 + b"\n", b'{"do":' + b'{"do":' * 150 + b"\n", b"\n" * 900,
                 b"{}\n" * 300, b'{"do": "pause", "id": 1e999}\n', b'{"do": "cancel"', b"null\n", b"\x00" * 500 + b"\n"]
        turn = 0
        while not stop.is_set():
            for path in (self.path, self.path, self.commands):
                client = socket.socket(socket.AF_UNIX)
                client.settimeout(0.05)
                try:
                    client.connect(str(path))
                    counts["connected"] += 1
                    client.sendall(lines[turn % len(lines)])
                except OSError:
                    counts["turned away"] += 1
                turn += 1
                # Most close in the middle of a line; some stay and never read.
                if turn % 10 == 0:
                    sleepers.append(client)
                else:
                    client.close()
            if len(sleepers) > 60:
                sleepers.pop(0).close()
        for client in sleepers:
            client.close()

    @unittest.skipIf("PLUMBLINE_SANITIZED" in os.environ, "a sanitizer's memory is not the program's")
    def test_clients_that_mean_harm_change_neither_print_nor_memory(self):
        daemon, user = self.start(speedup=400)
        self.put_stick({"a.ply": 2})
        user.state("offered", "start")
        calm = self.print_once(user)
        before = self.memory(daemon)
        user.do("plate-empty")
        user.state("offered", "start")
        stop, counts = threading.Event(), {"connected": 0, "turned away": 0}
        harm = threading.Thread(target=self.harm, args=(stop, counts))
        harm.start()
        try:
            under_attack = self.print_once(user)
        finally:
            stop.set()
            harm.join()
        self.assertGreater(counts["connected"], 100)
        self.assertEqual([e["mask_hash"] for e in under_attack["exposures"]], [e["mask_hash"] for e in calm["exposures"]])
        # The simulated plate still has the first part; nobody took it off.
        self.assertEqual([text for text in under_attack["objections"] if "the part was pressed" not in text], [])
        self.assertEqual(under_attack["late_masks"], 0)
        after = self.memory(daemon)
        self.assertEqual((after["VmStk"], after["VmLck"]), (before["VmStk"], before["VmLck"]))
        # The simulated part takes some 100 kB of the heap; clients sent megabytes.
        self.assertLess(after["VmData"] - before["VmData"], 500)
        open_files = os.listdir(f"/proc/{daemon.pid}/fd")
        self.assertLess(len(open_files), 50)
        # Lines of those who have left may still hold their places: who comes then is turned away, and comes again.
        end = time.monotonic() + SECONDS
        reader = Client(self, self.path)
        while not reader.states and time.monotonic() < end:
            if not reader.receive(end):
                reader = Client(self, self.path)
        reader.state("plate in use")

    def test_eight_followers_make_no_mask_late(self):
        # The printer's own exposures, forty times as fast; a few layers are enough.
        _, user = self.start(speedup=40)
        self.put_stick({"a.ply": 1})
        slack = []
        for followers in (0, 8):
            user.state("offered", "start")
            user.do("set", key="supports", value="none")
            user.do("set", key="layer_height", value=0.1)
            shown = [subprocess.Popen([PLUMBLINE, "status", "--follow", "--json", "--socket", self.path], stdout=subprocess.DEVNULL)
                     for _ in range(followers)]
            for process in shown:
                self.addCleanup(process.wait)
                self.addCleanup(process.kill)
            report = self.print_once(user)
            self.assertEqual(report["late_masks"], 0)
            slack.append(report["masks"]["smallest_slack_s"])
            user.do("plate-empty")
        shortest = min(exposure["asked_s"] for exposure in report["exposures"])
        print(f"smallest slack: {slack[0]:.3f} s alone, {slack[1]:.3f} s with eight followers, of exposures of {shortest} s")
        self.assertGreater(slack[1], shortest / 2)


if __name__ == "__main__":
    main()
