#!/usr/bin/env python3
"""The printer's page, asked by HTTP as browsers and as those who mean harm ask: a real plumbline-page at a real plumblined."""

import contextlib
import gzip
import itertools
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest

from case import PLUMBLINE, main, write_sphere
from page_client import PAGE, PagePrinter
from state_client import Client

CODE = "the code for a browser is "


class Page(PagePrinter):
    def events(self):
        """@returns a function that waits for a state for which holds(state)"""
        stream = socket.create_connection(("127.0.0.1", self.port), 30)
        self.addCleanup(stream.close)
        stream.sendall(f"GET /events HTTP/1.1\r\nHost: localhost:{self.port}\r\n\r\n".encode())
        file = stream.makefile("rb")
        self.addCleanup(file.close)

        def until(holds):
            for line in iter(file.readline, b""):
                if not line.startswith(b"data: "):
                    continue
                state = {"state": None, **json.loads(line[6:].strip() or b"{}")}  # None: the printer does not answer
                if holds(state):
                    return state
            return self.fail("the stream has ended")

        return until

    def test_a_print_by_page_from_the_stick_to_the_report(self):
        self.start(plate=False, speedup=100, printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        until = self.events()
        until(lambda s: s["state"] == "plate in use")
        self.post("/command", {"do": "plate-empty"}, headers=token)
        self.put_stick({"a.ply": 2, "b.ply": 2})
        self.assertFalse(until(lambda s: s["state"] == "offered")["masks"])
        self.post("/command", {"do": "choose", "scan": 2}, headers=token)
        self.post("/command", {"do": "set", "key": "layer_height", "value": "0.1"}, headers=token)
        until(lambda s: s["job"]["number"] == 2 and s["job"]["layer_height"] == 0.1)
        # What the printer refuses is said in its words.
        refused = self.post("/command", {"do": "choose", "scan": 3}, status=409, headers=token)
        self.assertIn("no scan 3", refused["error"])
        self.post("/command", {"do": "start"}, headers=token)
        sliced = until(lambda s: s["state"] == "offered" and s["sliced"])
        self.assertTrue(sliced["masks"])
        # The masks that would be printed, in any order.
        last = sliced["sliced"]["layers"] - 1
        masks = [self.get(f"/mask?n={n}") for n in (last // 2, 0, last, last // 2)]
        self.assertTrue(all(mask.startswith(b"\x89PNG") for mask in masks))
        self.assertEqual(masks[0], masks[3])
        self.assertNotEqual(masks[0], masks[1])
        for path in (f"/mask?n={last + 1}", "/mask?n=4294967295", "/picture/none"):
            self.assertEqual(self.ask("GET", path)[0], 404, path)
        for path in ("/mask", "/mask?n=-1", "/mask?n=x", "/mask?n=99999999999"):
            self.assertEqual(self.ask("GET", path)[0], 400, path)
        preview = self.get("/picture/preview")
        self.assertTrue(preview.startswith(b"\x89PNG"))
        self.assertTrue(self.get("/part").startswith(b"PLM1"))
        self.post("/command", {"do": "start"}, headers=token)
        printing = until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] > 2)
        self.assertFalse(printing["masks"])
        self.assertTrue(self.get("/picture/layer").startswith(b"\x89PNG"))
        self.assertEqual(self.ask("GET", "/report.json")[0], 404, "no report is read while the printer prints")
        job = json.loads(self.get("/api/job"))
        self.assertEqual((job["state"], job["job"]["file"]["name"]), ("Printing", "b.ply"))
        self.assertTrue(json.loads(self.get("/api/printer"))["state"]["flags"]["printing"])
        self.assertEqual(json.loads(self.get("/api/version"))["api"], "0.1")
        tables = dict(re.findall(r"^const (\w+) = (.*);$", self.get("/words.js").decode(), re.MULTILINE))
        german = json.loads(tables["printerTexts"])["de"]
        self.assertEqual(german["faults"]["PL-102"]["title"], "Kein Scan")
        self.assertIn("{count?Insel von|Inseln bis}", german["told"]["island"][0])
        self.assertEqual(json.loads(tables["factDigits"])["area_mm2"], -3)
        self.post("/command", {"do": "pause"}, headers=token)
        until(lambda s: s["state"] == "paused")
        self.post("/command", {"do": "resume"}, headers=token)
        done = until(lambda s: s["state"] == "plate in use" and s["commands"])
        self.assertEqual((done["job"]["result"], done["report"]), ("finished", True))
        # In parts of 24 kB, and whole.
        _, headers, report = self.ask("GET", "/report.json")
        self.assertIn("attachment", headers["Content-Disposition"])
        self.assertEqual(report, (self.folder / "report.json").read_bytes())
        # It is kept, with the preview that was seen before the print.
        self.assertEqual([(print["number"], print["scan"], print["result"]) for print in done["prints"]], [(1, "b.ply", "finished")])
        self.assertEqual(self.get("/report.json?n=1"), report)
        self.assertEqual(self.get("/print.png?n=1"), preview)
        for path, status in (("/print.png?n=2", 404), ("/report.json?n=2", 404), ("/print.png", 400), ("/print.png?n=0", 400)):
            self.assertEqual(self.ask("GET", path)[0], status, path)
        self.assertEqual(json.loads(self.get("/state"))["state"], "plate in use")

    def test_an_archive_shows_the_masks_of_its_scan_and_their_issues(self):
        board = self.page_board("local")
        self.start(printer=board)
        self.start_page()
        token = self.paired()
        until = self.events()
        scan, part = self.dir / "ball.ply", self.dir / "part.sl1"
        write_sphere(scan, points=5000, radius=2)
        self.run_it("slice", scan, "-o", part, "--no-preview", "--printer", board, "--layer-height", 0.1, "--supports", "none")

        def masks(file):
            self.put_stick({file.name: file.read_bytes()})
            until(lambda s: s["state"] == "offered" and s["job"] and s["job"]["scan"] == file.name)
            if file == scan:
                for key, value in (("layer_height", "0.1"), ("supports", "none")):
                    self.post("/command", {"do": "set", "key": key, "value": value}, headers=token)
            self.post("/command", {"do": "start"}, headers=token)
            last = until(lambda s: s["masks"])["sliced"]["layers"] - 1
            shown = [self.get(f"/mask?n={n}") for n in (last, last // 2, last // 2 + 1, last // 2)]
            shown.append(self.get("/picture/issues"))
            self.assertEqual(self.ask("GET", f"/mask?n={last + 1}")[0], 404)
            self.post("/command", {"do": "cancel"}, headers=token)
            until(lambda s: s["state"] == "idle" and not s["masks"])
            self.assertEqual(self.ask("GET", "/mask?n=0")[0], 404)
            shutil.rmtree(self.stick)
            until(lambda s: not s["stick"]["present"])
            return shown

        of_scan, of_archive = masks(scan), masks(part)
        self.assertEqual(of_scan, of_archive)
        self.assertEqual(of_archive[1], of_archive[3])
        self.assertNotEqual(of_archive[0], of_archive[1])

    def test_a_command_that_was_given_up_is_not_carried_out_later(self):
        daemon, _ = self.start(printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        until = self.events()
        self.put_stick({"a.ply": 2})
        until(lambda s: s["state"] == "offered" and "set" in s["commands"])
        daemon.send_signal(signal.SIGSTOP)
        self.addCleanup(daemon.send_signal, signal.SIGCONT)
        given_up = self.post("/command", {"do": "set", "key": "layer_height", "value": "0.1"}, status=504, headers=token)
        self.assertEqual(given_up["told"]["code"], "command_withdrawn")
        daemon.send_signal(signal.SIGCONT)
        end, status = time.monotonic() + 30, 503
        while status == 503 and time.monotonic() < end:  # until the page has connected again
            status = self.ask("POST", "/command", {"do": "set", "key": "scale", "value": 0.5}, headers=token)[0]
            time.sleep(0.05)
        self.assertEqual(status, 200)
        changed = until(lambda s: s["state"] == "offered" and s["job"]["scale"] == 0.5)
        self.assertIsNone(changed["job"]["layer_height"])

    def test_a_printer_that_hangs_is_said_until_it_goes_on(self):
        daemon, _ = self.start(printer=self.page_board("local"))
        self.start_page()
        until = self.events()
        until(lambda s: s["state"] == "idle")
        daemon.send_signal(signal.SIGSTOP)
        self.addCleanup(daemon.send_signal, signal.SIGCONT)
        stopped = time.monotonic()
        until(lambda s: s["state"] is None)
        self.assertLess(time.monotonic() - stopped, 9)
        self.assertEqual(json.loads(self.get("/state"))["state"], "idle", "its connection is there, so that it was")
        daemon.send_signal(signal.SIGCONT)
        until(lambda s: s["state"] == "idle")

    def stored(self):
        return sorted(path.name for path in (self.folder / "uploads").iterdir())

    def sphere(self):
        write_sphere(self.dir / "sphere.ply", points=5000, radius=2)
        return (self.dir / "sphere.ply").read_bytes()

    def begin_upload(self, name, size, headers):
        """@returns a connection through which `size` bytes are awaited"""
        asked = self.post("/upload", {"do": "upload", "name": name, "bytes": size}, headers=headers)
        line = socket.create_connection(("127.0.0.1", self.port), 30)
        self.addCleanup(line.close)
        host = f"localhost:{self.port}"
        fields = {"Host": host, "Origin": f"http://{host}", "Content-Type": "application/octet-stream", "Content-Length": size, **headers}
        head = f"POST /upload/body?n={asked['upload']} HTTP/1.1\r\n" + "".join(f"{key}: {value}\r\n" for key, value in fields.items())
        line.sendall(f"{head}\r\n".encode())
        return line

    def test_a_scan_is_uploaded_and_printed(self):
        self.start(speedup=100, printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        until = self.events()
        self.assertEqual(until(lambda s: s["state"] == "idle")["upload_limit"], 256 << 20)
        self.assertEqual(self.upload("bust (2).ply", self.sphere(), token), {"ok": True})
        offered = until(lambda s: s["state"] == "offered")
        self.assertEqual([scan["name"] for scan in offered["stick"]["scans"]], ["bust (2).ply"])
        self.assertEqual((offered["stick"]["present"], offered["stick"]["uploaded"], offered["upload"]["stage"]), (False, True, "kept"))
        # Another one is offered instead, though its name is the same. It is no scan, which a child finds out.
        self.upload("bust (2).ply", b"hello", token)
        until(lambda s: s["state"] == "offered" and s["stick"]["scans"][0]["bytes"] == 5)
        self.post("/command", {"do": "start"}, headers=token)
        fault = until(lambda s: s["state"] == "fault")
        self.assertEqual((fault["fault"]["code"], fault["stick"]["scans"][0]["problem"][:6]), ("PL-102", "PL-102"))
        # Nobody needs to read that first: the next one has come.
        self.upload("bust.ply", self.sphere(), token)
        offered = until(lambda s: s["state"] == "offered" and s["stick"]["scans"][0]["name"] == "bust.ply")
        self.assertIsNone(offered["stick"]["scans"][0]["problem"])
        self.post("/command", {"do": "set", "key": "layer_height", "value": "0.1"}, headers=token)
        self.post("/command", {"do": "start"}, headers=token)
        until(lambda s: s["state"] == "offered" and s["sliced"])
        self.assertTrue(self.get("/picture/preview").startswith(b"\x89PNG"))
        self.post("/command", {"do": "start"}, headers=token)
        printing = until(lambda s: s["state"] == "printing")
        self.assertEqual(printing["upload_limit"], 0)
        refused = self.post("/upload", {"do": "upload", "name": "gear.ply", "bytes": 5}, status=409, headers=token)
        self.assertIn("at rest, and its state is", refused["error"])
        done = until(lambda s: s["state"] == "plate in use" and s["commands"])
        self.assertEqual((done["job"]["result"], done["job"]["scan"]), ("finished", "bust.ply"))
        self.post("/command", {"do": "plate-empty"}, headers=token)
        until(lambda s: s["state"] == "offered")
        self.assertEqual(self.stored(), ["bust.ply"])

    def test_a_stick_and_an_upload_are_offered_one_after_the_other(self):
        self.put_stick({"stick.ply": 2})
        self.start(printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        until = self.events()
        until(lambda s: s["state"] == "offered")
        self.upload("upload.ply", self.sphere(), token)
        until(lambda s: s["state"] == "offered" and s["job"]["scan"] == "upload.ply")
        self.post("/command", {"do": "cancel"}, headers=token)
        until(lambda s: s["state"] == "idle" and "offer" in s["commands"])
        for scan in ("stick.ply", "upload.ply"):
            if scan == "stick.ply":
                self.post("/command", {"do": "offer"}, headers=token)
            until(lambda s, scan=scan: s["state"] == "offered" and s["job"]["scan"] == scan and s["commands"])
            self.post("/command", {"do": "cancel"}, headers=token)
        until(lambda s: s["state"] == "idle" and "offer" in s["commands"])

    def test_uploads_of_others_and_of_what_is_no_scan_are_refused(self):
        self.start(printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        ask = {"do": "upload", "name": "a.ply", "bytes": 5}
        self.post("/upload", ask, status=401)
        self.post("/upload", ask, status=403, headers={**token, "Origin": "http://evil.example"})
        self.post("/upload", ask, status=415, headers={**token, "Content-Type": "text/plain"})
        for wrong in ({"do": "start"}, {}, [], {**ask, "bytes": -1}, {**ask, "bytes": 1e99}, {**ask, "path": "/"}, {**ask, "name": "a" * 80}):
            self.post("/upload", wrong, status=400, headers=token)
        self.post("/command", ask, status=400, headers=token)
        for name in ("../../etc/a.ply", "a/b.ply", ".a.ply", "job.toml", "a.exe", "", "a\nb.ply", "a\u0000.ply", "b\u00fcste.ply"):
            self.post("/upload", {**ask, "name": name}, status=409, headers=token)
        for size, words in ((0, "is empty"), ((256 << 20) + 1, "takes 256 MiB at most"), (2**53, "takes 256 MiB at most")):
            self.assertIn(words, self.post("/upload", {**ask, "bytes": size}, status=409, headers=token)["error"])
        body = {**token, "Content-Type": "application/octet-stream"}
        self.post("/upload/body?n=1", b"hello", status=409, headers=body)
        asked = self.post("/upload", ask, headers=token)
        path = f"/upload/body?n={asked['upload']}"
        self.assertIn("another scan", self.post("/upload", ask, status=409, headers=token)["error"])
        self.post(path, b"hello", status=401, headers={**body, "Plumbline-Token": "0" * 32})
        self.post(path, b"hello", status=403, headers={**body, "Origin": "http://evil.example"})
        self.post(path, b"hello", status=415, headers=token)
        self.post(path, b"hello!", status=409, headers=body)
        self.post("/upload/body?n=99", b"hello", status=409, headers=body)
        self.post("/upload/body", b"hello", status=409, headers=body)
        self.assertEqual(self.ask("POST", path, b"hello", headers=body, host="evil.example")[0], 421)
        for method in ("GET", "PUT"):
            self.assertIn(self.ask(method, path)[0], (405, 411))
        self.assertIn(b" 411 ", self.raw(b"POST /upload/body?n=1 HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nf\r\n"))
        self.assertEqual(self.stored(), [".incoming"])
        self.post(path, b"hello", headers=body)
        self.assertEqual(self.stored(), ["a.ply"])

    def test_an_upload_that_breaks_off_leaves_nothing(self):
        daemon, _ = self.start(printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        until = self.events()
        self.upload("whole.ply", self.sphere(), token)
        until(lambda s: s["state"] == "offered")
        # The browser goes.
        line = self.begin_upload("half.ply", 1000, token)
        line.sendall(b"x" * 500)
        until(lambda s: s["upload"]["stage"] == "coming" and s["upload"]["received"] == 500)
        line.close()
        failed = until(lambda s: s["upload"]["stage"] == "failed")
        self.assertIn("ended after 500 of 1000 bytes", failed["upload"]["problem"])
        self.assertEqual(self.stored(), ["whole.ply"])
        # A job begins, here that of the upload before: what is written meanwhile could make a mask late.
        line = self.begin_upload("half.ply", 100_000_000, token)
        line.sendall(b"x" * 500)
        until(lambda s: s["upload"]["stage"] == "coming" and s["upload"]["received"] == 500)
        self.post("/command", {"do": "start"}, headers=token)
        failed = until(lambda s: s["upload"]["stage"] == "failed")
        self.assertIn("begun another job", failed["upload"]["problem"])
        with contextlib.suppress(OSError):
            for _ in range(100):
                line.sendall(b"x" * 1_000_000)
            self.fail("the rest of it is not taken")
        self.post("/command", {"do": "cancel"}, headers=token)
        # The daemon is killed, as by a power cut.
        until(lambda s: s["upload_limit"] > 0)
        line = self.begin_upload("half.ply", 1000, token)
        line.sendall(b"x" * 500)
        until(lambda s: s["upload"]["stage"] == "coming" and s["upload"]["received"] == 500)
        daemon.kill()
        daemon.wait()
        self.assertEqual(self.stored(), [".incoming", "whole.ply"])
        until(lambda s: s["state"] is None)
        self.start(printer=self.page_board("local"))
        idle = until(lambda s: s["state"] == "idle" and s["commands"])
        self.assertEqual((idle["commands"], idle["upload"], self.stored()), (["offer", "remove"], None, ["whole.ply"]))
        self.post("/command", {"do": "offer"}, headers=token)
        until(lambda s: s["state"] == "offered" and s["job"]["scan"] == "whole.ply")

    def test_an_uploaded_scan_is_removed(self):
        self.start(speedup=100, printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        until = self.events()
        remove = {"do": "remove", "name": "a.ply"}
        self.assertIn("takes no command", self.post("/command", remove, status=409, headers=token)["error"])
        self.upload("a.ply", self.sphere(), token)
        until(lambda s: s["state"] == "offered" and "remove" in s["commands"] and s["stored"] == {"name": "a.ply", "bytes": len(self.sphere())})
        self.post("/command", remove, status=401)
        self.post("/command", remove, status=403, headers={**token, "Origin": "http://evil.example"})
        self.post("/command", {"do": "remove"}, status=400, headers=token)
        for name in ("../journal", "b.ply", "", "a.ply\n"):
            self.assertIn("not in the printer's store", self.post("/command", {**remove, "name": name}, status=409, headers=token)["error"])
        self.assertEqual(self.stored(), ["a.ply"])
        # What is offered is taken back.
        self.post("/command", remove, headers=token)
        idle = until(lambda s: s["state"] == "idle" and not s["stored"])
        self.assertEqual((idle["stick"]["scans"], self.stored()), ([], []))
        # So is what has been sliced. A stick that is offered is not.
        self.upload("a.ply", self.sphere(), token)
        until(lambda s: s["state"] == "offered" and s["commands"])
        self.post("/command", {"do": "set", "key": "layer_height", "value": "0.1"}, headers=token)
        self.post("/command", {"do": "start"}, headers=token)
        until(lambda s: s["masks"] and "remove" in s["commands"])
        self.post("/command", remove, headers=token)
        until(lambda s: s["state"] == "idle" and not s["masks"])
        self.upload("a.ply", self.sphere(), token)
        until(lambda s: s["state"] == "offered" and s["commands"])
        self.post("/command", {"do": "cancel"}, headers=token)
        self.put_stick({"stick.ply": 2})
        until(lambda s: s["state"] == "offered" and s["job"] and s["job"]["scan"] == "stick.ply" and s["commands"])
        self.post("/command", remove, headers=token)
        self.assertEqual(until(lambda s: not s["stored"])["state"], "offered")
        self.post("/command", {"do": "set", "key": "layer_height", "value": "0.1"}, headers=token)
        # While it reads and prints the printer removes nothing.
        self.upload("a.ply", self.sphere(), token)
        until(lambda s: s["state"] == "offered" and s["job"]["scan"] == "a.ply" and s["commands"])
        self.post("/command", {"do": "start"}, headers=token)
        until(lambda s: s["state"] == "offered" and s["masks"])
        self.post("/command", {"do": "start"}, headers=token)
        until(lambda s: s["state"] == "printing")
        self.assertIn("It takes pause, cancel", self.post("/command", remove, status=409, headers=token)["error"])
        self.assertEqual(self.stored(), ["a.ply"])
        self.post("/command", {"do": "cancel"}, headers=token)
        until(lambda s: s["state"] == "plate in use" and "remove" in s["commands"])
        self.post("/command", remove, headers=token)
        until(lambda s: not s["stored"])
        self.post("/command", {"do": "plate-empty"}, headers=token)
        idle = until(lambda s: s["state"] == "idle" and s["commands"])
        self.assertEqual((idle["commands"], self.stored()), (["offer"], []))

    def crowd(self, stop, asked):
        """Seven followers, a page that reads on, and two clients that ask for pictures, until `stop` is set."""
        followers = [subprocess.Popen([PLUMBLINE, "status", "--follow", "--json", "--socket", self.path], stdout=subprocess.DEVNULL)
                     for _ in range(7)]
        until = self.events()

        def ask():
            client = Client(self, self.commands)
            names = [{"picture": "scan", "scan": 1}, {"picture": "scan", "scan": 2}, {"picture": "part", "from": 0},
                     {"picture": "layer"}, {"picture": "preview"}]
            while not stop.is_set():
                reply = client.ask("picture", **names[len(asked) % len(names)])
                asked.append(reply["ok"])

        askers = [threading.Thread(target=ask) for _ in range(2)]
        for thread in askers:
            thread.start()
        until(lambda s: stop.is_set())
        for thread in askers:
            thread.join()
        for process in followers:
            process.kill()
            process.wait()

    def test_screen_page_followers_and_pictures_make_no_mask_late(self):
        # The printer's own exposures, forty times as fast; a few layers are enough.
        board = self.page_board("local", start="on_request")
        _, user = self.start("--screen", self.dir / "screen", speedup=40, printer=board)
        self.start_page()
        self.put_stick({"a.ply": 1, "b.ply": 1})
        slack, asked = [], []
        for crowded in (False, True):
            user.until(lambda s: s["state"] == "offered" and all(scan["picture"] for scan in s["stick"]["scans"]), "all pictures")
            user.do("set", key="supports", value="none")
            user.do("set", key="layer_height", value=0.1)
            stop = threading.Event()
            crowd = threading.Thread(target=self.crowd, args=(stop, asked))
            if crowded:
                crowd.start()
            user.do("start")
            user.state("printing")
            done = user.state("plate in use", "plate-empty")
            stop.set()
            report = json.loads((self.folder / "report.json").read_text())
            self.assertEqual((done["job"]["result"], report["late_masks"]), ("finished", 0))
            slack.append(report["masks"]["smallest_slack_s"])
            user.do("plate-empty")
            if crowded:
                crowd.join()
        self.assertGreater(sum(asked), 20)
        shortest = min(exposure["asked_s"] for exposure in report["exposures"])
        print(f"smallest slack: {slack[0]:.4f} s alone, {slack[1]:.4f} s with {sum(asked)} pictures, of exposures of {shortest} s")
        self.assertGreater(slack[1], shortest / 2)

    def test_a_large_upload_takes_no_memory(self):
        self.start(printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        before = self.facts()
        data = bytes(range(256)) * (40 << 12)
        began = time.monotonic()
        self.upload("large.xyz", data, token)
        self.assertLess(time.monotonic() - began, 30)
        self.assertEqual((self.folder / "uploads/large.xyz").read_bytes(), data)
        if "PLUMBLINE_SANITIZED" not in os.environ:
            self.assertLess(int(self.facts()["VmHWM"].split()[0]) - int(before["VmHWM"].split()[0]), 2000)

    def code(self, number=-1):
        """Waits for a code in the log of the page."""
        end = time.monotonic() + 30
        while time.monotonic() < end:
            codes = [line.split(CODE)[1].strip() for line in self.log if CODE in line]
            if len(codes) > number and codes:
                return codes[number]
            time.sleep(0.02)
        return self.fail(self.log)

    def pair(self, name="", **options):
        """Pairs a browser of the network. @returns its headers"""
        before = sum(CODE in line for line in self.log)
        self.post("/pair", {"ask": name}, **options)
        return {"Plumbline-Token": self.post("/pair", {"code": self.code(before), "ask": name, "name": name}, **options)["token"]}

    def test_a_browser_of_the_network_needs_the_code_on_the_screen(self):
        frames = self.dir / "frames"
        self.start("--screen", frames, printer=self.page_board("network"))
        self.start_page("network")
        until = self.events()
        until(lambda s: s["state"] == "idle")
        self.post("/command", {"do": "offer"}, status=401)
        self.post("/command", {"do": "offer"}, status=401, headers={"Plumbline-Token": "0" * 32})
        self.post("/pair", {"code": "123456"}, status=403)
        before = max(frames.glob("0*.png")).read_bytes()
        self.assertNotIn("token", self.post("/pair", {}))
        end = time.monotonic() + 30
        while max(frames.glob("0*.png")).read_bytes() == before and time.monotonic() < end:
            time.sleep(0.05)
        self.assertNotEqual(max(frames.glob("0*.png")).read_bytes(), before, "the screen shows the code")
        code = self.code()
        self.assertNotIn(code, self.get("/state").decode())
        wrong = "000000" if code != "000000" else "000001"
        refused = self.post("/pair", {"code": wrong}, status=403)
        self.assertEqual(refused["told"]["code"], "code_wrong")
        token = {"Plumbline-Token": self.post("/pair", {"code": code})["token"]}
        self.assertTrue(json.loads(self.get("/access", headers=token))["paired"])
        self.assertIn("no command now", self.post("/command", {"do": "offer"}, status=409, headers=token)["error"])
        # Another one has to read a new code, and has three guesses.
        self.post("/pair", {"code": code}, status=403)
        self.post("/pair", {})
        for _ in range(3):
            self.post("/pair", {"code": "x"}, status=403)
        self.assertEqual(self.post("/pair", {}, status=429)["told"]["code"], "codes_too_many")
        # The page forgets nobody.
        self.end_page()
        self.start_page("network")
        self.assertTrue(json.loads(self.get("/access", headers=token))["paired"])

    def test_a_code_is_for_the_browser_that_asked_and_others_wait(self):
        self.start(printer=self.page_board("network"))
        self.start_page("network")
        self.events()(lambda s: s["state"] == "idle")
        self.post("/pair", {"ask": "phone"}, come_from="127.0.0.2")
        code = self.code()
        waits = self.post("/pair", {"ask": "laptop"}, status=429, come_from="127.0.0.3")
        self.assertEqual(waits["told"]["code"], "code_of_other")
        self.assertGreater(waits["told"]["values"]["wait_s"], 100)
        # Regression: three wrong codes of anybody made the right one void.
        wrong = "000000" if code != "000000" else "000001"
        for _ in range(4):
            self.post("/pair", {"code": wrong, "ask": "laptop"}, status=403, come_from="127.0.0.3")
        self.post("/pair", {"code": code, "ask": "laptop"}, status=403, come_from="127.0.0.3")
        self.post("/pair", {"code": code}, status=403, come_from="127.0.0.2")
        got = self.post("/pair", {"code": code, "ask": "phone", "name": "Firefox, <Android>\u202e"}, come_from="127.0.0.2")
        phone = {"Plumbline-Token": got["token"]}
        self.logged("paired browser 1 at 127.0.0.2: Firefox")
        # The laptop's turn comes at once; a browser that wants no code any more leaves the screen to others.
        self.post("/pair", {"ask": "laptop"}, come_from="127.0.0.3")
        self.post("/pair", {"ask": "laptop", "stop": True}, come_from="127.0.0.3")
        laptop = self.pair("tablet", come_from="127.0.0.4")
        # They are listed for those that are paired, and can be forgotten.
        self.assertEqual(self.ask("GET", "/browsers")[0], 401)
        listed = json.loads(self.get("/browsers", headers=phone))["browsers"]
        self.assertEqual([(one["number"], one["this"]) for one in listed], [(1, True), (2, False)])
        self.assertTrue(listed[0]["name"].startswith("Firefox, <Android>"))
        for key in ("paired_at", "seen_at"):
            self.assertRegex(listed[0][key], r"^20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        self.assertNotIn(got["token"], json.dumps(listed))
        for wrong_one in (0, 3, -1, 2**40, "1", None):
            self.post("/forget", {"browser": wrong_one}, status=409, headers=phone)
        self.post("/forget", {"browser": 1}, status=401)
        self.post("/forget", {"browser": 1}, status=403, headers={**phone, "Origin": "http://evil.example"})
        self.post("/forget", {"browser": 1}, headers=laptop)
        self.post("/command", {"do": "offer"}, status=401, headers=phone)
        self.post("/command", {"do": "offer"}, status=409, headers=laptop)
        self.end_page()
        self.start_page("network")
        self.assertFalse(json.loads(self.get("/access", headers=phone))["paired"])
        self.assertTrue(json.loads(self.get("/access", headers=laptop))["paired"])

    def flood(self, stop, come_from):
        """Asks for codes as fast as it can until `stop` is set."""
        host = f"127.0.0.1:{self.port}"
        head = f"POST /pair HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{{}}"
        while not stop.is_set():
            with contextlib.suppress(OSError), contextlib.closing(socket.create_connection(("127.0.0.1", self.port), 2, (come_from, 0))) as line:
                line.sendall(head.encode())
                self.flooded += 1
                line.recv(1000)

    def crawl(self, stop, come_from):
        """Sixteen connections on which a request comes bit by bit, until `stop` is set."""
        lines = []
        while not stop.is_set():
            if len(lines) < 16:
                with contextlib.suppress(OSError):
                    lines.append(socket.create_connection(("127.0.0.1", self.port), 2, (come_from, 0)))
            for line in list(lines):
                try:
                    line.sendall(b"G")
                except OSError:
                    lines.remove(line)
                    line.close()
            stop.wait(0.05)
        for line in lines:
            line.close()

    def test_a_paired_browser_is_served_whatever_others_do(self):
        self.start(printer=self.page_board("network"), speedup=20)
        self.start_page("network")
        until = self.events()
        until(lambda s: s["state"] == "idle")
        token = self.pair("phone")
        data = self.sphere()
        stop, self.flooded = threading.Event(), 0
        asked = itertools.count()

        def slowest(holds):
            """@returns the longest that a command takes, s, while holds(seconds)"""
            worst, began = 0.0, time.monotonic()
            while holds(time.monotonic() - began):
                at = time.monotonic()
                self.post("/command", {"do": "set", "key": "scale", "value": 0.5 + next(asked) / 1000}, headers=token)
                worst = max(worst, time.monotonic() - at)
                self.get("/state")
            return worst

        self.upload("calm.ply", data, token)
        until(lambda s: s["state"] == "offered" and "set" in s["commands"])
        calm = slowest(lambda seconds: seconds < 1)
        harm = [threading.Thread(target=self.flood, args=(stop, "127.0.0.2"))]
        harm += [threading.Thread(target=self.crawl, args=(stop, address)) for address in ("127.0.0.3", "127.0.0.4")]
        for thread in harm:
            thread.start()
        try:
            worst = slowest(lambda seconds: seconds < 2 or (self.flooded < 300 and seconds < 30))
            self.upload("part.ply", data, token)
            until(lambda s: s["state"] == "offered" and s["job"] and s["job"]["scan"] == "part.ply")
            # Who looks without being paired finds a place, too.
            self.assertEqual(self.ask("GET", "/state", come_from="127.0.0.5")[0], 200)
        finally:
            stop.set()
            for thread in harm:
                thread.join()
        print(f"slowest command: {calm:.3f} s alone, {worst:.3f} s of {next(asked)} while {self.flooded} requests came", file=sys.stderr)
        self.assertLess(worst, max(1, 3 * calm))
        self.assertGreaterEqual(self.flooded, 300)
        self.assertLess(len(self.log), 10, "the log is not flooded")
        self.logged("too many requests: refused")

    def test_only_the_pages_own_scripts_may_command(self):
        self.start(printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        host = f"localhost:{self.port}"
        for headers in ({"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": ""}, {"Origin": f"http://{host}"}):
            self.post("/command", {"do": "offer"}, status=403, headers={**token, **headers})
            self.post("/pair", {}, status=403, headers=headers)
        self.post("/command", {"do": "offer"}, status=415, headers={**token, "Content-Type": "text/plain"})
        # Another site's name that was pointed at this machine, and the network's names while the page is local.
        for name in ("evil.example", f"evil.example:{self.port}", "printer.local", "192.168.1.2"):
            self.assertEqual(self.ask("GET", "/state", host=name)[0], 421, name)
        for body in ({"do": "picture", "picture": "layer"}, {"do": "mask", "layer": 0}, {"do": "report", "from": 0}, {"do": "code", "code": "1"},
                     {"do": "dance"}, {}, [], "start", {"do": "start", "do2": 1}):
            self.post("/command", body, status=400, headers=token)
        for method in ("PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "BREW"):
            self.assertEqual(self.ask(method, "/command")[0], 405, method)
        self.assertEqual(self.ask("POST", "/state", {})[0], 405)
        _, headers, page = self.ask("GET", "/")
        self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
        self.assertIn(b"<!DOCTYPE html>", page)
        for path in ("/page.js", "/gestures.js", "/part.js", "/layers.js", "/page.css", "/words.js"):
            self.assertIn("charset=utf-8", self.ask("GET", path)[1]["Content-Type"])
        files = ("/", "/page.js", "/gestures.js", "/part.js", "/layers.js", "/page.css", "/words.js")
        packed = {path: self.ask("GET", path, headers={"Accept-Encoding": "deflate, gzip, br"}) for path in files}
        for path, (_, headers, data) in packed.items():
            self.assertEqual(headers["Content-Encoding"], "gzip")
            _, headers, plain = self.ask("GET", path, headers={"Accept-Encoding": "gzip;q=0"})
            self.assertNotIn("Content-Encoding", headers)
            self.assertEqual(gzip.decompress(data), plain)
        self.assertLess(sum(len(data) for _, _, data in packed.values()), 48000)
        for path in ("/../../etc/passwd", "/%2e%2e/etc/passwd", "/page.js/", "//", "/\u00e4".encode("latin-1").decode("latin-1")):
            self.assertEqual(self.ask("GET", path.replace("\u00e4", "%e4"))[0], 404, path)

    def facts(self):
        with open(f"/proc/{self.page.pid}/status", encoding="ascii") as file:
            return dict(line.rstrip("\n").split(":\t", 1) for line in file if ":\t" in line)

    def test_is_there_before_and_after_the_printer_and_has_no_rights(self):
        self.folder.mkdir()
        self.start_page()
        self.assertEqual(self.ask("GET", "/state")[0], 503)
        self.assertEqual(json.loads(self.get("/api/job"))["state"], "Offline")
        daemon, _ = self.start(printer=self.page_board("local"))
        until = self.events()
        until(lambda s: s["state"] == "idle")
        daemon.kill()
        daemon.wait()
        until(lambda s: s["state"] is None)
        self.start(printer=self.page_board("local"))
        until(lambda s: s["state"] == "idle")
        facts = self.facts()
        self.assertEqual({facts[key].strip() for key in ("CapInh", "CapPrm", "CapEff", "CapAmb")}, {"0" * 16})
        if "PLUMBLINE_SANITIZED" not in os.environ:
            self.assertEqual((facts["Seccomp"].strip(), facts["NoNewPrivs"].strip(), facts["Threads"].strip()), ("2", "1", "1"))

    def raw(self, data, patience=0.2):
        """Sends bytes on a connection of their own. @returns what came back, until the end of an answer's headers"""
        with contextlib.closing(socket.create_connection(("127.0.0.1", self.port), 5)) as line:
            with contextlib.suppress(OSError):
                line.sendall(data)
            line.settimeout(patience)
            got = b""
            with contextlib.suppress(OSError):
                while b"\r\n\r\n" not in got and (part := line.recv(65536)):
                    got += part
            return got

    def test_hostile_http_is_refused_and_takes_no_memory(self):
        self.start(printer=self.page_board("local"))
        self.start_page()
        token = self.paired()
        host = f"Host: localhost:{self.port}\r\n".encode()
        post = b"POST /command HTTP/1.1\r\n" + host + f"Origin: http://localhost:{self.port}\r\n".encode() + b"Content-Type: application/json\r\n"
        post += f"Plumbline-Token: {token['Plumbline-Token']}\r\n".encode()
        hostile = [
            b"", b"\r\n\r\n", b"\x00" * 2000, b"\xff\xfe\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"x" * 500,
            b"GET", b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\n\r\n", b"GET / HTTP/9.9\r\n" + host + b"\r\n", b"GET /\r\n\r\n", b"get / http/1.1\r\n\r\n",
            b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\n" + host + b"\r\n", b"GET / HTTP/1.1\r\n" + host + b"X: " + b"y" * 100_000 + b"\r\n\r\n",
            b"GET / HTTP/1.1\r\n" + host + b"X: y\r\n" * 20_000 + b"\r\n", b"GET / HTTP/1.1\r\nHost:\r\n\r\n", b"GET / HTTP/1.1\r\n" + host + host + b"\r\n",
            b"GET http://evil.example/ HTTP/1.1\r\nHost: evil.example\r\n\r\n", b"GET /%00 HTTP/1.1\r\n" + host + b"\r\n", b"GET /%zz%f HTTP/1.1\r\n" + host + b"\r\n",
            b"GET /mask?" + b"n=1&" * 3000 + b" HTTP/1.1\r\n" + host + b"\r\n", b"CONNECT evil.example:25 HTTP/1.1\r\n" + host + b"\r\n",
            b"GET / HTTP/1.1\r\nHost: localhost\r\n X: folded\r\n\r\n", b"GET / HTTP/1.1\r\n" + host + b"no colon\r\n\r\n",
            post + b"Content-Length: 99999999999999999999999\r\n\r\n", post + b"Content-Length: 1048576\r\n\r\n" + b"{" * 1_000_000,
            post + b"Content-Length: -1\r\n\r\n", post + b"Content-Length: 0x10\r\n\r\n", post + b"Content-Length: 500\r\n\r\n{}",
            post + b"Content-Length: 2\r\nContent-Length: 5\r\n\r\n{}", post + b"Transfer-Encoding: chunked\r\n\r\nFFFFFFFFFFFFFFFF\r\nx",
            post + b"Transfer-Encoding: chunked\r\nContent-Length: 2\r\n\r\n{}", post + b"Content-Length: 1000\r\n\r\n" + b'{"do":' * 166 + b"xxxx",
            post + b"Content-Length: 13\r\n\r\n" + b'{"do":"\xc3\xc3"}', post + b"Expect: 100-continue\r\nContent-Length: 4\r\n\r\nnull",
            post + b"Upgrade: websocket\r\nConnection: Upgrade\r\nContent-Length: 4\r\n\r\nnull", b"GET / HTTP/1.1\r\n" + host + b"\r\n" + b"garbage" * 1000,
        ]
        for round_ in range(2):
            for data in hostile:
                got = self.raw(data)
                self.assertIsNone(self.page.poll(), data[:200])
                if got:
                    # The page itself is what the harmless first half of two of them asks for.
                    self.assertRegex(got, rb"^HTTP/1\.[01] (?:[45]\d\d|100|200) ", data[:200])
            if round_ == 0:
                before = self.facts()
        self.assertEqual(json.loads(self.get("/state"))["state"], "idle")
        if "PLUMBLINE_SANITIZED" not in os.environ:
            after = self.facts()
            grown = {key: int(after[key].split()[0]) - int(before[key].split()[0]) for key in ("VmData", "VmStk")}
            self.assertLess(max(grown.values()), 300, grown)

    def test_connections_are_bounded_and_are_free_again(self):
        self.start(printer=self.page_board("local"))
        self.start_page()
        lines = []
        for _ in range(60):
            line = socket.create_connection(("127.0.0.1", self.port), 5)
            self.addCleanup(line.close)
            with contextlib.suppress(OSError):
                line.sendall(b"GET / HTTP/1.1\r\nHost: loc")
            lines.append(line)
        self.assertLess(len(os.listdir(f"/proc/{self.page.pid}/fd")), 40 + 16)
        for line in lines:
            line.close()
        end = time.monotonic() + 20
        while time.monotonic() < end:
            with contextlib.suppress(OSError, AssertionError):
                self.get("/state")
                return
        self.fail("the page serves nobody any more")

    def test_there_is_no_page_unless_the_board_file_says_so(self):
        board = self.page_board("off")
        done = subprocess.run([PAGE, "--printer", board], capture_output=True, text=True, timeout=30, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("so there is no page", done.stdout)
        done = subprocess.run([PAGE, "--printer", self.page_board("local"), "--listen", "0.0.0.0"], capture_output=True, text=True, timeout=30,
                              check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("is for this machine", done.stderr)


if __name__ == "__main__":
    main()
