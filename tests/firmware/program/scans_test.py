#!/usr/bin/env python3
"""Several files that are one scan: on a stick, because job.toml says so or somebody chooses them, and for the command line."""

import json
import os
import shutil

from case import SIM2K, main, split, write_sphere
from state_client import StatePrinter, same_age


class Scans(StatePrinter):
    same = ("--printer", SIM2K, "--supports", "none", "--layer-height", 0.1)
    settings = '[job]\nscan = %s\nsupports = "none"\n[placement]\nlayer_height = 0.1\n'

    def setUp(self):
        super().setUp()
        self.front, self.back = self.dir / "front.ply", self.dir / "back.ply"
        write_sphere(self.scan, points=5000, radius=2.0)
        split(self.scan, 2600, self.front, self.back)
        self.halves = {path.name: path.read_bytes() for path in (self.front, self.back)}

    def slice_masks(self, *scans):
        self.run_it("slice", *scans, "-o", self.out, "--no-preview", *self.same)
        return self.manifest()["hashes"]["layers"]

    def manifest(self):
        return json.loads((self.out / "manifest.json").read_text())

    def printed(self, user):
        done = user.state("plate in use", "plate-empty")
        self.assertEqual(done["job"]["result"], "finished")
        report = json.loads((self.folder / "report.json").read_text())
        return report, [line["mask_hash"] for line in report["exposures"]]

    def put_folder(self, name, scans, job=""):
        """A stick with a folder."""
        new = self.dir / "new"
        (new / name).mkdir(parents=True)
        for file, what in scans.items():
            (new / name / file).write_bytes(what)
        if job:
            (new / "job.toml").write_text(job)
        same_age(new)
        new.rename(self.stick)

    def test_job_file_lists_files_and_a_print_goes_on_after_a_power_cut(self):
        hashes = self.slice_masks(self.front, self.back)
        daemon, user = self.start()
        self.put_stick(self.halves, self.settings % '["front.ply", "back.ply"]')
        job = user.state("offered", "start")["job"]
        self.assertEqual((job["scan"], job["files"], job["number"]), ("front.ply and 1 more", ["front.ply", "back.ply"], None))
        shown = self.run_it("status", "--socket", self.path).stdout
        self.assertIn("job.toml asks for 2 scans as one: front.ply and 1 more", shown)
        self.assertRegex(shown, r"(?m)^files +front.ply\n +back.ply$")
        user.do("start")
        user.until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] > 3, "layer 4")
        daemon.kill()
        daemon.wait()
        shutil.rmtree(self.stick)
        _, user = self.start(plate=False, speedup=1e4)
        user.state("interrupted", "resume")
        user.do("resume")
        report, masks = self.printed(user)
        self.assertEqual((report["scan"], report["files"]), ("front.ply and 1 more", ["front.ply", "back.ply"]))
        self.assertEqual(user.states[-1]["job"]["files"], report["files"])
        self.assertGreater(report["first_layer"], 0)
        self.assertEqual(masks, hashes[report["first_layer"]:])

    def test_job_file_names_a_folder_whose_scans_are_sorted_by_name(self):
        hashes = self.slice_masks(self.back, self.front)
        _, user = self.start(speedup=1e4)
        self.put_folder("bust", {**self.halves, "readme.txt": b"no scan", "view.jpg": b"no scan"}, self.settings % '"bust/"')
        job = user.state("offered", "start")["job"]
        self.assertEqual(job["files"], ["bust/back.ply", "bust/front.ply"])
        user.do("start")
        report, masks = self.printed(user)
        self.assertEqual((report["scan"], report["files"], masks), ("bust/back.ply and 1 more", job["files"], hashes))

    def test_bad_file_is_named(self):
        _, user = self.start(speedup=1e4)
        for name, files, scan, words in (
            ("cut", {**self.halves, "back.ply": self.halves["back.ply"][:5000]}, '["front.ply", "back.ply"]', "back.ply: "),
            ("missing", self.halves, '["front.ply", "bakc.ply"]', "bakc.ply: No such file"),
            ("archive", {**self.halves, "part.sl1": b"PK"}, '["front.ply", "part.sl1"]', "part.sl1: is sliced already, so it can't be part"),
        ):
            with self.subTest(name):
                self.put_stick(files, self.settings % scan)
                user.state("offered", "start")
                user.do("start")
                self.assertIn(words, user.state("fault", "seen")["fault"]["message"])
                self.pull(user)
        many = {f"{i}.ply": self.halves["back.ply"] for i in range(33)}
        for files, words in ((many, "bust: the folder has 33 scans, but one scan may have 32"), ({}, "bust: the folder has no scans")):
            self.put_folder("bust", files, self.settings % '"bust"')
            self.assertIn(words, user.state("fault", "seen")["fault"]["message"])
            self.pull(user)

    def pull(self, user):
        shutil.rmtree(self.stick)
        pulled = user.until(lambda s: s["state"] in ("idle", "fault") and not s["stick"]["present"], "an empty port")
        if pulled["state"] == "fault":
            user.do("seen", **{"for": pulled["asks"]})
        user.until(lambda s: s["state"] == "idle" and not s["stick"]["present"], "nothing but an empty port")

    def test_names_that_say_so_are_offered_as_one_and_apart(self):
        hashes = self.slice_masks(self.back, self.front)
        _, user = self.start(speedup=1e4)
        (self.dir / "new").mkdir()
        for folder in ("", "scans", "others"):
            (self.dir / "new" / folder).mkdir(exist_ok=True)
            for i, name in enumerate(("back.ply", "front.ply") if folder != "others" else ("cat.ply", "dog.ply")):
                (self.dir / "new" / folder / name).write_bytes(self.halves["front.ply" if i else "back.ply"])
        same_age(self.dir / "new")
        (self.dir / "new").rename(self.stick)
        offered = user.state("offered", "start")
        self.assertEqual([(s["number"], s["name"], s["files"]) for s in offered["stick"]["scans"]],
                         [(1, "back.ply", 1), (2, "front.ply", 1), (3, "others/cat.ply", 1), (4, "others/dog.ply", 1), (5, "back.ply", 2), (6, "scans/back.ply", 2)])
        self.assertEqual((offered["job"]["files"], offered["job"]["number"]), (["back.ply"], 1), "nothing is joined unless somebody asks")
        self.assertEqual(offered["stick"]["scans"][4]["bytes"], sum(map(len, self.halves.values())))
        self.run_it("ctl", "choose", 6, "--socket", self.path)
        job = user.until(lambda s: s["job"]["number"] == 6, "the folder")["job"]
        self.assertEqual(job["files"], ["scans/back.ply", "scans/front.ply"])
        shown = self.run_it("status", "--socket", self.path).stdout
        self.assertIn("*  6  2 scans as one: scans/back.ply, ...", shown)
        for key, value in (("supports", "none"), ("layer_height", 0.1)):
            user.do("set", key=key, value=value)
        user.do("start")
        self.assertEqual(self.printed(user)[1], hashes)

    def test_series_may_lie_in_a_folder_of_a_project(self):
        hashes = self.slice_masks(self.back, self.front)
        _, user = self.start(speedup=1e4)
        self.put_folder("bust/scans", {**self.halves, "notes.skp": b"no scan"})
        job = user.state("offered", "start")["job"]
        self.assertEqual(job["files"], ["bust/scans/back.ply", "bust/scans/front.ply"])
        for key, value in (("supports", "none"), ("layer_height", 0.1)):
            user.do("set", key=key, value=value)
        user.do("start")
        self.assertEqual(self.printed(user)[1], hashes)

    def test_what_lies_alone_in_a_folder_is_offered_behind_the_top_folder(self):
        scan = self.halves["front.ply"]
        new = self.dir / "new"
        for path in ("bust.stl", "B\u00fcste (Kopie)/Scan final.PLY", "B\u00fcste (Kopie)/notes.txt", "prints/a/part.sl1", "prints/papers.zip",
                     "._bust.stl", ".Trashes/old.ply", "__MACOSX/._a.ply", "__MACOSX/a.ply", "$RECYCLE.BIN/$R1.ply", "System Volume Information/x.ply",
                     "a/b/c/deep.ply", "own/job.toml", "own/scan.ply"):
            (new / path).parent.mkdir(parents=True, exist_ok=True)
            (new / path).write_bytes(scan)
        same_age(new)
        os.utime(new / "bust.stl")
        _, user = self.start(speedup=1e4)
        new.rename(self.stick)
        offered = user.state("offered", "start")
        self.assertEqual([s["name"] for s in offered["stick"]["scans"]],
                         ["bust.stl", "B\u00fcste (Kopie)/Scan final.PLY", "a/b/c/deep.ply", "prints/a/part.sl1"])
        self.assertEqual(offered["job"]["files"], ["bust.stl"])
        user.do("choose", scan=2)
        user.until(lambda s: s["job"]["number"] == 2, "the folder's")
        user.do("start")
        user.until(lambda s: s["state"] == "printing", "the folder's scan being printed")

    def test_folders_are_opened_and_the_newest_is_offered_first(self):
        scan, new = self.halves["front.ply"], self.dir / "new"
        for i in range(70):
            path = new / f"prints/2024/part{i:02}.ply"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(scan)
            os.utime(path, (1.7e9 - i, 1.7e9 - i))
        (new / "a/b/c/d/e/f/g/h/i").mkdir(parents=True)
        (new / "a/top.ply").write_bytes(scan)
        _, user = self.start(speedup=1e4)
        user.refused("It takes no command now", "open", folder=1)
        new.rename(self.stick)
        offered = user.state("offered", "open")
        stick = offered["stick"]
        self.assertEqual((stick["folder"], [s["name"] for s in stick["scans"]][:2], len(stick["scans"])), (None, ["a/top.ply", "prints/2024/part00.ply"], 16))
        self.assertEqual(stick["folders"], [{"number": 1, "name": "a", "entries": 1}, {"number": 2, "name": "prints", "entries": 70}])
        self.assertEqual((stick["left_out"], stick["folders_left_out"], stick["not_listed"]), (0, 1, "not listed: 1 folder"))
        self.assertEqual(stick["not_listed_told"], {"code": "stick_not_listed", "values": {"folders": 1}})
        user.refused("there is no folder 3 here: there are 2", "open", folder=3)
        user.refused("there is no folder 0 here", "open", folder=0)
        self.run_it("ctl", "open", 2, "--socket", self.path)
        stick = user.until(lambda s: s["stick"]["folder"] == "prints" and "open" in s["commands"], "the folder")["stick"]
        self.assertEqual([folder["name"] for folder in stick["folders"]], ["2024"])
        user.do("open", folder=1)
        opened = user.until(lambda s: s["stick"]["folder"] == "prints/2024" and "open" in s["commands"], "the folder in it")
        self.assertEqual([s["name"] for s in opened["stick"]["scans"]], [f"part{i:02}.ply" for i in range(64)])
        self.assertEqual((opened["stick"]["left_out"], opened["job"]["files"]), (6, ["prints/2024/part00.ply"]))
        self.assertEqual(opened["job"]["number"], offered["job"]["number"])
        self.assertNotEqual(opened["job"]["id"], offered["job"]["id"], "the first one is another scan here")
        shown = self.run_it("status", "--socket", self.path).stdout
        self.assertRegex(shown, r"(?m)^folders +0  back up: this is prints/2024$")
        self.assertRegex(shown, r"(?m)^ +not listed: 6 files$")
        # After a print the folder is still open, and the same scan is offered.
        for key, value in (("supports", "none"), ("layer_height", 0.1)):
            user.do("set", key=key, value=value)
        user.do("choose", scan=3)
        user.do("start")
        self.printed(user)
        user.do("plate-empty")
        again = user.state("offered", "open")
        self.assertEqual((again["stick"]["folder"], again["job"]["number"]), ("prints/2024", 3))
        user.do("open", folder=0)
        user.until(lambda s: s["stick"]["folder"] == "prints", "the folder above")
        # Another stick begins at its top.
        self.pull(user)
        self.put_folder("prints", {"part00.ply": scan})
        self.assertIsNone(user.state("offered", "open")["stick"]["folder"])

    def test_all_partitions_are_listed(self):
        """The first one is the EFI partition that a Mac or a GPT of Windows makes."""
        efi, data = self.dir / "new", self.dir / "stick.2"
        for file, what in ((efi / "EFI/BOOT/bootx64.efi", b"x"), (data / "back.ply", self.halves["back.ply"]), (data / "job.toml", b"")):
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(what)
        (efi / "back.ply").write_bytes(b"another one")
        (data / "job.toml").write_text(self.settings % '"back.ply"')
        hashes = self.slice_masks(self.back)
        _, user = self.start(speedup=1e4)
        efi.rename(self.stick)
        self.assertEqual(user.state("offered", "start")["job"]["files"], ["2:back.ply"], "its own partition's")
        user.do("start")
        self.assertEqual(self.printed(user)[1], hashes)
        user.do("plate-empty")
        user.state("offered", "start")
        self.pull(user)
        (data / "job.toml").unlink()
        efi.mkdir()
        (efi / "front.ply").write_bytes(self.halves["front.ply"])
        for path in (efi / "front.ply", data / "back.ply"):
            os.utime(path, (1.7e9, 1.7e9))
        efi.rename(self.stick)
        offered = user.state("offered", "start")
        self.assertEqual([(s["name"], s["files"]) for s in offered["stick"]["scans"]], [("back.ply", 1), ("front.ply", 1), ("back.ply", 2)])
        self.assertEqual(offered["job"]["files"], ["back.ply"])
        user.do("cancel")
        user.state("idle", "offer")
        for folder, name in ((self.stick, "Job.toml"), (data, "job.toml")):
            (folder / name).write_text(self.settings % '"back.ply"')
        user.do("offer")
        self.assertIn("the stick has two jobs", user.state("fault", "seen")["fault"]["message"])

    def test_only_scan_may_lie_in_a_folder(self):
        _, user = self.start(speedup=1e4)
        self.put_folder("Scans", {"bust.ply": self.halves["front.ply"], "readme.txt": b"no scan"})
        self.assertEqual(user.state("offered", "start")["job"]["files"], ["Scans/bust.ply"])

    def test_job_in_a_folder_is_told(self):
        _, user = self.start(speedup=1e4)
        self.put_folder("Scans", {"bust.ply": self.halves["front.ply"], "Job.toml": b"[job]"})
        fault = user.state("fault", "seen")["fault"]
        self.assertEqual((fault["message"], fault["told"]["code"]), ("Scans/Job.toml: is in a folder", "stick_inner_job"))

    def test_scan_under_the_name_of_a_sliced_print_is_told(self):
        _, user = self.start(speedup=1e4)
        (self.dir / "new").mkdir()
        (self.dir / "new/part.sl1").write_bytes(self.halves["front.ply"])
        (self.dir / "new").rename(self.stick)
        user.do("start")
        fault = user.state("fault", "seen")["fault"]
        self.assertEqual((fault["message"], fault["told"]["code"]), ("part.sl1: is a scan or mesh, no sliced print", "not_sliced"))

    def test_project_that_is_not_read_is_named(self):
        _, user = self.start(speedup=1e4)
        self.put_folder("bust/scans", {"2.fls": b"no scan", "1.fls": b"no scan"})
        fault = user.state("fault", "seen")["fault"]
        self.assertEqual(fault["message"], "bust/scans/1.fls is a scan that is not read (FARO)")
        self.assertEqual(fault["told"], {"code": "foreign_scan", "values": {}, "name": "bust/scans/1.fls"})
        self.pull(user)
        self.put_folder("bust/Scan001.fls", {"Main": b"a scan of FARO's is a folder"})
        self.assertEqual(user.state("fault", "seen")["fault"]["message"], "bust/Scan001.fls is a scan that is not read (FARO)")

    def test_series_too_long_for_a_scan_is_refused_in_words(self):
        _, user = self.start(speedup=1e4)
        self.put_folder("turntable", {f"scan_{i:03}.ply": b"ply" for i in range(40)})
        offered = user.state("offered", "start")
        self.assertEqual([(s["name"], s["problem"]) for s in offered["stick"]["scans"]],
                         [("turntable/scan_000.ply", "one scan may have 32 files at most")])
        user.do("start")
        self.assertIn("one scan may have 32 files at most", user.state("fault", "seen")["fault"]["message"])

    def test_command_line_takes_a_folder(self):
        folder = self.dir / "project"
        folder.mkdir()
        for path in (self.front, self.back):
            shutil.copy(path, folder)
        (folder / "notes.txt").write_text("no scan")
        hashes = self.slice_masks(self.back, self.front)
        shutil.rmtree(self.out)
        self.assertEqual(self.slice_masks(f"{folder}/"), hashes)
        inspected = self.run_it("inspect", folder).stdout
        self.assertIn("back.ply: 2400 points", inspected)
        self.assertIn("front.ply: 2600 points", inspected)
        for i in range(40):
            (folder / f"{i}.ply").touch()
        refused = self.run_it("slice", folder, "-o", self.dir / "many", status=1).stderr
        self.assertIn("project: the folder has 42 scans, but one scan may have 32 files at most", refused)


if __name__ == "__main__":
    main()
