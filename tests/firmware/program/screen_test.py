#!/usr/bin/env python3
"""A job from the stick to the finished part, as the printer's screen shows it: a real plumblined writes its frames, and the title of each is
compared with that of the golden pictures that a person has looked at."""

import base64
import shutil
import time

from case import SOURCE_DIR, main
from rgb_picture import rgb_rows
from state_client import SECONDS, StatePrinter

GOLDEN = SOURCE_DIR / "tests/firmware/screen/golden"
TITLE_ROWS = 34  # of a screen of 320 x 240


def sliced_state_pictures(user):
    pictures = user.states[-1]["pictures"]
    return pictures["preview"], pictures["issues"], pictures["layer"]


def bright_runs(row):
    """Lengths of the runs of bright pixels in a row of RGB."""
    runs, inside = [], False
    for at in range(0, len(row), 3):
        bright = sum(row[at : at + 3]) > 3 * 110
        if bright and not inside:
            runs.append(0)
        if bright:
            runs[-1] += 1
        inside = bright
    return runs


class Screen(StatePrinter):
    def titles(self):
        """Names of the golden pictures whose titles the frames have, each change once."""
        known, seen = {}, []
        for name in ("idle", "scans", "reading", "preview", "checks", "homing", "printing", "paused", "raising", "finished"):
            known[tuple(rgb_rows(GOLDEN / f"{name}-320.png", TITLE_ROWS)[1])] = name
        for frame in sorted(self.frames.glob("0*.png")):
            name = known.get(tuple(rgb_rows(frame, TITLE_ROWS)[1]), "another")
            if not seen or seen[-1] != name:
                seen.append(name)
        return seen

    def test_shows_a_job_from_the_stick_to_the_finished_part(self):
        self.frames = self.dir / "screen"
        profiles = self.dir / "profiles"
        shutil.copytree(SOURCE_DIR / "board/profiles", profiles)
        self.printer = self.dir / "sim2k.toml"
        self.printer.write_text((SOURCE_DIR / "board/sim2k.toml").read_text().replace('"on_request"', '"after_preview"'))
        # So slow that a busy machine, on which this test may not run for seconds, has not finished the print meanwhile.
        daemon, user = self.start("--screen", self.frames, speedup=40, printer=self.printer, eager=True)
        user.state("idle")
        self.shown("idle")
        self.put_stick({"ball.ply": 2})
        self.assertEqual(user.state("offered", "start")["profiles"], sorted(path.stem for path in profiles.glob("*.toml")))
        self.shown("scans")
        for key, value in (("layer_height", 0.1), ("supports", "none")):
            user.do("set", key=key, value=value)
        user.do("start")
        user.state("slicing")
        sliced = user.until(lambda s: s["state"] == "offered" and s["sliced"], "a preview")["sliced"]
        self.assertEqual(sliced["layers"], 40)
        for side in ("width_mm", "depth_mm", "height_mm"):
            self.assertAlmostEqual(sliced[side], 4, delta=0.1)
        self.assertAlmostEqual(sliced["resin_ml"], 4 / 3 * 3.1416 * 8 / 1000, delta=0.01)
        self.shown("preview")
        self.assertEqual(sliced_state_pictures(user), (1, 1, None))
        preview = self.picture(user, "preview")
        self.assertEqual(preview[0], 320)
        # A ball is as wide from each of the three sides: the middle row crosses three shapes of one width.
        runs = bright_runs(preview[1][len(preview[1]) // 2])
        self.assertEqual(len(runs), 3)
        self.assertLess(max(runs) - min(runs), 6)
        # Without supports the ball's first layers hang over the ones below: a red ring round each.
        columns, rows = self.picture(user, "issues")
        self.assertEqual((columns, len(rows)), (320, 180))
        red = sum(row[at : at + 3] == bytes((232, 78, 56)) for row in rows for at in range(0, len(row), 3))
        self.assertGreater(red, 500)
        # The part from all sides, and what of it was scanned: all of it.
        reply = user.ask("picture", picture="part", **{"from": 0})
        self.assertEqual((reply["ok"], reply["from"], reply["number"]), (True, 0, 1))
        self.assertTrue(base64.b64decode(reply["data"]).startswith(b"PLM1"))
        user.refused("no such part", "picture", picture="part", **{"from": reply["size"]})
        user.refused("no picture 'layer'", "picture", picture="layer")
        user.refused("preview, issues, layer, part, proposal or scan", "picture", picture="whole")
        user.state("offered", "start")
        user.do("start")
        user.until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] > 20, "the upper half, of which the masks have its size")
        # From here on it stands still, however long this takes. That it has shown "printing" is in its frames.
        user.do("pause")
        paused = user.state("paused", "resume")
        self.shown("paused")
        columns, rows = self.picture(user, "layer")
        self.assertTrue(84 <= columns == len(rows) <= 102, "the ball of 4 mm and a twelfth around it, in pixels of 47.25 um")
        # The section of the ball above its middle.
        white = sum(sum(row) for row in rows) / 255
        done = paused["progress"]["layers_done"]
        areas = [3.1416 * (z * (4 - z)) / 0.04725 ** 2 for z in (0.1 * (done - 1) + 0.05, 0.1 * (done + 1) + 0.05)]
        self.assertTrue(0.9 * areas[0] < white < 1.1 * areas[1], (areas, white))
        file = self.dir / "layer.png"
        self.run_it("status", "--picture", "layer", "--output", file, "--socket", self.path)
        self.assertEqual(rgb_rows(file)[0], columns)
        user.do("resume")
        going = user.until(lambda s: s["state"] == "printing", "it goes on")
        pause = going["progress"]["elapsed_s"] - paused["progress"]["elapsed_s"]  # 40 s for each second of this test
        done = user.state("plate in use", "plate-empty")
        self.assertEqual(done["job"]["result"], "finished")
        self.assertLess(abs((done["progress"]["elapsed_s"] - pause) / sliced["time_s"] - 1), 0.2)
        self.shown("finished")
        user.do("plate-empty")
        user.state("offered", "start")
        daemon.terminate()
        self.assertEqual(daemon.wait(60), 0)
        titles = self.titles()
        for name in ("idle", "scans", "preview", "printing", "paused", "printing", "finished"):
            self.assertIn(name, titles, "in this order")
            titles = titles[titles.index(name):]

    def test_one_of_the_best_ways_up_is_chosen_and_printed_again(self):
        daemon, user = self.start(eager=True)
        user.state("idle")
        self.put_stick({"ball.ply": 3, "small.ply": 2, "junk.ply": b"ply\n"}, points=200_000)  # time enough to cancel
        user.state("offered", "propose")
        # A glance at each scan, while the printer waits. What is no scan has no picture.
        seen = user.until(lambda s: s["stick"]["scans"] and s["stick"]["scans"][2]["picture"], "pictures of the scans")
        first = seen["stick"]["scans"][0]["picture"]  # random, so that no restart repeats it
        self.assertEqual([scan["picture"] for scan in seen["stick"]["scans"]], [first, None, first + 1])
        for scan in (1, 3):
            columns, rows = self.picture(user, "scan", scan=scan)
            self.assertEqual((columns, len(rows)), (64, 64))
        user.refused("no picture 'scan'", "picture", picture="scan", scan=2)
        user.refused("needs \"scan\"", "picture", picture="scan")
        user.do("choose", scan=3)
        user.do("set", key="layer_height", value=0.1)
        user.refused("the best orientations are not known", "set", key="proposal", value=1)
        user.do("propose")
        user.until(lambda s: s["state"] == "slicing" and s["slicing"]["proposes"], "it looks for them")
        found = user.until(lambda s: s["state"] == "offered" and s["proposals"] and s["commands"], "the best ways up")
        self.assertEqual((found["job"]["number"], found["job"]["proposal"], found["pictures"]["proposal"]), (3, 0, 1))
        self.assertEqual([way["number"] for way in found["proposals"]], [0, 1, 2, 3, 4])
        for way in found["proposals"]:
            self.assertAlmostEqual(way["height_mm"], 4, delta=0.2)
            columns, rows = self.picture(user, "proposal", proposal=way["number"])
            self.assertEqual((columns, len(rows)), (160, 160))
        user.refused("a number from 0 to 4", "picture", picture="proposal", proposal=5)
        user.refused("allowed is 0 to 4", "set", key="proposal", value="5")
        second = found["proposals"][2]
        user.do("set", key="proposal", value=2)

        def follows(state):
            job = state["job"]
            return (job["rotate_x_deg"], job["rotate_y_deg"]) == (second["rotate_x_deg"], second["rotate_y_deg"])

        user.until(lambda s: s["job"]["proposal"] == 2 and follows(s), "the second way up")
        listed = self.run_it("status", "--socket", self.path).stdout
        self.assertRegex(listed, r"\* 2  x -?[0-9.]+, y -?[0-9.]+ degrees: [0-9.]+ ml to support, [0-9.]+ mm high")
        # The figures are those of one size; the way up stays.
        user.do("set", key="height", value="5mm")
        user.until(lambda s: s["proposals"] is None and s["pictures"]["proposal"] is None and follows(s), "no figures")
        user.do("set", key="scale", value=1)
        # Whoever stops it keeps the offer.
        user.do("propose")
        user.until(lambda s: s["state"] == "slicing", "it looks for them")
        user.do("cancel")
        user.until(lambda s: s["state"] == "offered" and s["commands"] and follows(s), "the offer")
        before = len(user.states)
        user.do("start")
        printed = user.state("plate in use", "plate-empty")
        self.assertEqual(printed["job"]["result"], "finished")
        whole = [state["slicing"]["whole"] for state in user.states[before:] if state["slicing"]]
        self.assertEqual(whole, sorted(whole))
        self.assertTrue(whole[0] < whole[-1] <= 1, whole)
        user.do("plate-empty")
        again = user.state("offered", "start")["job"]
        self.assertTrue(again["number"] == 3 and again["layer_height"] == 0.1 and follows({"job": again}), again)
        # Another stick begins anew, though its scan has that name.
        shutil.rmtree(self.stick)
        user.until(lambda s: not s["stick"]["present"], "no stick")
        shutil.rmtree(self.dir / "new", ignore_errors=True)
        self.put_stick({"ball.ply": 3, "small.ply": 2, "junk.ply": b"ply\n"})
        fresh = user.state("offered", "start")["job"]
        self.assertEqual((fresh["number"], fresh["rotate_x_deg"], fresh["layer_height"]), (1, 0, None))
        # A scan that can't be read is a fault as if it were printed.
        user.do("choose", scan=2)
        user.do("propose")
        self.assertEqual(user.state("fault", "seen")["fault"]["code"], "PL-102")
        user.do("seen")
        self.assertIn("PL-102", user.state("offered", "start")["stick"]["scans"][1]["problem"])
        daemon.terminate()
        self.assertEqual(daemon.wait(60), 0)

    def picture(self, user, name, **which):
        """(columns, rows) of a picture that the socket sends."""
        reply = user.ask("picture", picture=name, **which)
        self.assertTrue(reply["ok"], reply)
        self.assertEqual(reply["picture"], name)
        file = self.dir / f"{name}.png"
        file.write_bytes(base64.b64decode(reply["png"], validate=True))
        return rgb_rows(file)

    def shown(self, name):
        """Waits until the newest picture has the title of a golden one."""
        golden = rgb_rows(GOLDEN / f"{name}-320.png", TITLE_ROWS)[1]
        end, newest = time.monotonic() + SECONDS, self.frames / "screen.png"
        while time.monotonic() < end:
            if newest.exists() and rgb_rows(newest, TITLE_ROWS)[1] == golden:
                return
            time.sleep(0.1)
        self.fail(f"the screen does not show {name}")


if __name__ == "__main__":
    main()
