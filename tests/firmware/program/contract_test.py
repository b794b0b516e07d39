#!/usr/bin/env python3
"""What is shown is what is printed: the values of a print, who has said them, and what a person changes."""

import io
import json
import shutil
import zipfile

from case import SIM2K, SOURCE_DIR, add_ball, main, write_sphere
from sliced_test import square
from state_client import StatePrinter


def archive(settings=None, layers=12):
    """A zip of layers with a config.ini, or without any settings."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as zipped:
        for k in range(layers):
            zipped.writestr(f"a{k:03}.png", square())
        if settings:
            zipped.writestr("config.ini", settings)
    return packed.getvalue()


def values(state):
    return {one["key"]: (one["value"], one["source"]) for one in state["sliced"]["values"]}


class Contract(StatePrinter):
    def offer(self, packed):
        """@returns the client, and the state that asks "Print this?" """
        _, user = self.start(speedup=1e4)
        self.put_stick({"part.zip": packed})
        user.state("offered", "start")
        user.do("start")
        return user, user.until(lambda s: s["state"] == "offered" and s["sliced"] and "start" in s["commands"], "a question")

    def finish(self, user):
        user.do("start")
        user.state("plate in use")
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual((report["state"], report["objections"]), ("finished", []))
        return report

    def test_silent_archive_is_asked_about_and_changed_there(self):
        user, asked = self.offer(archive())
        self.assertEqual({one["told"]["code"] for one in asked["findings"]} & {"archive_no_height", "archive_no_exposure"},
                         {"archive_no_height", "archive_no_exposure"})
        self.assertIn("does not say how long its layers are exposed: 2.5 s and 30 s for the first are the profile's", asked["message"])
        self.assertEqual(values(asked)["exposure_time"], (2.5, "profile"))
        self.assertEqual(values(asked)["elefant_foot_compensation"], (0, "archive"))
        user.refused("can't be changed once the layers are made", "set", key="layer_height", value=0.1)
        user.refused("allowed is 0.1 to 120 s", "set", key="exposure_time", value=0)
        user.refused("this printer's lamp may be lit for 60 s at most", "set", key="initial_exposure_time", value=61)
        for key, value in (("exposure_time", 3.25), ("initial_exposure_time", 12), ("bottom_layer_count", 2), ("faded_layers", 0),
                           ("lift_height", 6)):
            user.do("set", key=key, value=value)
        changed = user.until(lambda s: values(s)["lift_height"] == (6, "person"), "the change")
        self.assertNotIn("archive_no_exposure", [one["told"]["code"] for one in changed["findings"]])
        self.assertGreater(changed["sliced"]["time_s"], 0)
        user.do("set", key="lift_height", value="")
        user.until(lambda s: values(s)["lift_height"][1] == "profile", "the profile's lift again")
        report = self.finish(user)
        self.assertEqual([line["asked_s"] for line in report["exposures"]], [12] * 2 + [3.25] * 10)
        shown = {one["key"]: (one["value"], one["source"]) for one in report["contract"]["values"]}
        self.assertEqual(shown["exposure_time"], (3.25, "person"))
        self.assertEqual(shown["layer_height"], (0.05, "profile"))

    def test_archive_that_says_it_all_is_not_asked_about(self):
        _, user = self.start(speedup=1e4)
        self.put_stick({"part.sl1": archive("layerHeight = 0.025\nexpTime = 2\nexpTimeFirst = 9\nnumFade = 0\n")})
        user.state("offered", "start")
        user.do("start")
        done = user.state("plate in use")
        self.assertEqual(values(done)["layer_height"], (0.025, "archive"))
        self.assertEqual(values(done)["exposure_time"], (2, "archive"))
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual({line["asked_s"] for line in report["exposures"]}, {2, 9})

    def test_values_are_set_before_slicing_or_in_the_job_file(self):
        _, user = self.start(speedup=1e4)
        self.put_stick({"ball.ply": 2.0}, '[job]\nscan = "ball.ply"\n[placement]\nlayer_height = 0.1\n[print]\nexposure_time = 4\n')
        offered = user.state("offered", "start")
        self.assertEqual(offered["job"]["values"], {"exposure_time": 4})
        user.do("set", key="bottom_layer_count", value=3)
        user.refused("allowed is a whole number from 1 to 100 layers", "set", key="bottom_layer_count", value=2.5)
        user.do("start")
        done = user.state("plate in use")
        shown = values(done)
        self.assertEqual((shown["exposure_time"], shown["bottom_layer_count"], shown["layer_height"]),
                         ((4, "person"), (3, "person"), (0.1, "person")))
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual(report["exposures"][-1]["asked_s"], 4)

    def test_a_job_may_have_layers_as_high_as_the_surface_allows(self):
        _, user = self.start(speedup=1e4)
        self.put_stick({"ball.ply": 3.0}, '[job]\nscan = "ball.ply"\n[placement]\nlayer_height = "adaptive"\n')
        self.assertEqual(user.state("offered", "start")["job"]["layer_height"], "adaptive")
        user.do("set", key="layer_height", value=0.05)
        user.until(lambda s: s["job"]["layer_height"] == 0.05, "even layers")
        user.do("set", key="layer_height", value="adaptive")
        user.until(lambda s: s["job"]["layer_height"] == "adaptive", "adaptive layers")
        user.refused("allowed is 0.005 to 1 mm, adaptive", "set", key="layer_height", value="fine")
        user.do("start")
        done = user.state("plate in use")["sliced"]
        heights, below = [], 0
        for end, step in done["layer_runs"]:
            heights += [step * done["layer_height_mm"]] * (end - below)
            below = end
        self.assertEqual((len(heights), round(min(heights), 3), round(max(heights), 3)), (done["layers"], 0.02, 0.1))
        self.assertAlmostEqual(sum(heights), done["height_mm"], delta=1e-3)
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual((report["state"], report["objections"], report["late_masks"]), ("finished", [], 0))
        self.assertEqual([line["layer"] for line in report["exposures"]], list(range(done["layers"])))

    def test_scan_whose_points_lie_off_the_print_is_asked_about(self):
        twice = self.dir / "twice.ply"  # as if one of two views were in the wrong place: surface of either lies inside the other
        write_sphere(twice, points=10_000, radius=4)
        add_ball(twice, 10_000, 4, (3.6, 0, 0))
        how = ("--printer", SIM2K, "--layer-height", 0.1, "--supports", "none")
        sliced = self.run_it("slice", twice, "-o", self.out, "--no-preview", *how)
        self.assertRegex(sliced.stderr, r"warning: [\d.]+ % of the points lie more than 0\.2 mm off what is printed")
        self.assertRegex(sliced.stdout, r"(?m)^proven     [78]\d\.\d % of the points lie within 0\.2 mm of what is printed")
        proof = json.loads((self.out / "manifest.json").read_text())["proof"]
        self.assertAlmostEqual(proof["off"] / proof["points"], 0.2, delta=0.04)
        self.assertIn("Add --accept to print it so", self.run_it("print", twice, *how, status=1).stderr)
        self.assertIn("off what is printed", self.run_it("print", twice, *how, "--accept").stderr)
        _, user = self.start(speedup=1e4)
        self.put_stick({"twice.ply": twice.read_bytes()}, '[job]\nscan = "twice.ply"\nsupports = "none"\n[placement]\nlayer_height = 0.1\n')
        user.state("offered", "start")
        user.do("start")
        asked = user.until(lambda s: s["state"] == "offered" and s["sliced"] and "start" in s["commands"], "a question")
        self.assertIn("off what is printed", asked["message"])
        self.assertIn("points_off", [one["told"]["code"] for one in asked["findings"]])
        self.assertAlmostEqual(asked["sliced"]["points_off_percent"], 20, delta=4)
        user.do("start", **{"for": asked["asks"]})
        user.state("plate in use")
        report = json.loads((self.folder / "report.json").read_text())
        self.assertGreater(report["contract"]["points_off_percent"], 16)

    def test_supports_are_set_by_hand_before_slicing_and_after(self):
        job = '[job]\nscan = "ball.ply"\nsupports = "auto"\n[supports]\nno_support_at = [[1, 2, 3]]\n[placement]\nlayer_height = 0.1\n'
        shutil.copytree(SOURCE_DIR / "board" / "profiles", self.dir / "board" / "profiles")
        board = self.dir / "board" / "sim2k.toml"
        board.write_text(SIM2K.read_text().replace('"on_request"', '"after_preview"'))
        _, user = self.start(speedup=1e4, printer=board)
        self.put_stick({"ball.ply": 4.0}, job)
        offered = user.state("offered", "start")
        self.assertEqual(offered["job"]["support_values"], {"no_support_at": [[1, 2, 3, 2]]})
        user.refused("support_at: found '1,nan,3', allowed is up to 32 places x, y, z", "set", key="support_at", value="1,2,3;1,nan,3")
        # As long as the longest list: coordinates with hundredths, and radii.
        most = [f"{100 + i}.25,{100 + i}.75,{100 + i}.05,2.5" for i in range(32)]
        user.do("set", key="no_support_at", value=";".join(most))
        user.until(lambda s: len(s["job"]["support_values"]["no_support_at"]) == 32, "32 areas")
        user.refused("no_support_at: found '1,2,3'", "set", key="no_support_at", value=";".join([*most, "1,2,3"]))
        user.do("set", key="no_support_at", value="1,2,3")
        user.do("set", key="support_at", value="12.5,-3,20.1; 40,22,8")
        user.do("set", key="exposure_time", value=3)
        user.until(lambda s: s["job"]["support_values"].get("support_at") == [[12.5, -3, 20.1], [40, 22, 8]], "the places")
        # Another size, orientation or lift: the places would be others.
        for key, value in (("height", "7mm"), ("rotate_x_deg", 10), ("support_object_elevation", 3), ("supports", "none")):
            user.until(lambda s: "support_at" in s["job"]["support_values"], "places")
            user.do("set", key=key, value=value)
            cleared = user.until(lambda s: "support_at" not in s["job"]["support_values"], "no places")
            self.assertEqual(cleared["message_told"]["code"], "supports_cleared")
            if key != "supports":
                user.do("set", key="support_at", value="12.5,3,20.1")
        user.do("set", key="support_object_elevation", value="")
        user.refused("support_at is given, but supports are off", "set", key="support_at", value="1,2,3")
        user.do("set", key="supports", value="auto")
        user.do("start")
        asked = user.until(lambda s: s["state"] == "offered" and s["masks"], "a question")
        self.assertNotIn("support_missed", [one["told"]["code"] for one in asked["findings"] if one["told"]])
        user.refused("allowed is up to 32 places", "set", key="support_at", value="1,2")
        # Undersides are raised by what light cures: it is sliced anew with the exposure, and asked about again.
        user.refused("this printer's lamp may be lit for 60 s at most", "set", key="initial_exposure_time", value=61)
        user.do("set", key="exposure_time", value=4)
        before = asked
        asked = user.until(lambda s: s["state"] == "offered" and s["masks"] and s["job"]["id"] != before["job"]["id"], "a question")
        self.assertEqual(values(asked)["exposure_time"], (4, "person"))
        self.assertNotEqual(asked["sliced"]["resin_ml"], before["sliced"]["resin_ml"], "other layers")
        # It is sliced anew with the place, and asked about again, with what was changed meanwhile.
        user.do("set", key="support_at", value="1,1,30", **{"for": asked["job"]["id"]})
        again = user.until(lambda s: s["state"] == "offered" and s["masks"] and s["job"]["id"] != asked["job"]["id"], "the next question")
        self.assertEqual(again["job"]["support_values"]["support_at"], [[1, 1, 30]])
        missed = next(one for one in again["findings"] if one["told"] and one["told"]["code"] == "support_missed")
        self.assertEqual(missed["told"]["values"], {"count": 1, "x_mm": 1, "y_mm": 1, "from_mm": 30})
        self.assertEqual((again["job"]["layer_height"], values(again)["exposure_time"]), (0.1, (4, "person")))
        # Without its stick it can't be sliced anew.
        self.stick.rename(self.dir / "pulled")
        user.until(lambda s: not s["stick"]["present"], "no stick")
        user.refused("the scan is no longer there", "set", key="support_at", value="")
        self.finish(user)

    def test_command_line_asks_and_takes_values(self):
        part = self.dir / "part.zip"
        part.write_bytes(archive(layers=3))
        run = ["print", part, "--printer", SIM2K]
        refused = self.run_it(*run, status=1).stderr
        self.assertIn("part.zip does not say how high its layers are: 0.05 mm is the profile's", refused)
        self.assertIn("--set exposure_time=SECONDS", refused)
        said = self.run_it(*run, "--layer-height", 0.1, "--set", "exposure_time=3", "--set", "initial_exposure_time=8").stderr
        self.assertIn("layers     layer_height 0.1 mm, initial_layer_height 0.1 mm (person), elefant_foot_compensation 0 mm (archive)", said)
        self.assertIn("exposure_time 3 s (person)", said)
        self.assertIn("0.05 mm is the profile's", self.run_it(*run, "--accept").stderr)
        wrong = self.run_it(*run, "--set", "exposure_time=0", status=2).stderr
        self.assertIn("exposure_time: found '0', allowed is 0.1 to 120 s", wrong)


if __name__ == "__main__":
    main()
