#!/usr/bin/env python3
"""Settings stay with their scan: back from "Print this?", after "Not now", after another scan, until the stick leaves or somebody resets them."""

import shutil

from case import SIM2K, SOURCE_DIR, main, write_sphere
from contract_test import archive, values
from state_client import StatePrinter


class Settings(StatePrinter):
    def open(self, start="after_preview"):
        shutil.copytree(SOURCE_DIR / "board" / "profiles", self.dir / "board" / "profiles")
        board = self.dir / "board" / "sim2k.toml"
        board.write_text(SIM2K.read_text().replace('"on_request"', f'"{start}"'))
        _, user = self.start(speedup=1e4, printer=board, eager=True)
        return user

    def offered(self, user, also=lambda s: True):
        return user.until(lambda s: s["state"] == "offered" and not s["sliced"] and s["commands"] and s["job"] and also(s), "an offer")

    def sliced(self, user, before=None):
        """@param before  the state of the question before, of another job"""
        return user.until(lambda s: s["state"] == "offered" and s["sliced"] and s["commands"]
                          and (not before or s["job"]["id"] != before["job"]["id"]), "a question")

    def set(self, user, **settings):
        for key, value in settings.items():
            user.do("set", key=key, value=value)

    def plain(self, job):
        """Whether nobody has changed a setting."""
        return (job["scale"], job["size"], job["rotate_x_deg"], job["layer_height"], job["values"], job["profile"]) == (1, None, 0, None, {}, "standard")

    def test_the_question_has_a_way_back_and_not_now_forgets_nothing(self):
        user = self.open()
        self.put_stick({"a.ply": 3, "b.ply": 2})
        self.offered(user)
        self.assertNotIn("settings", user.states[-1]["commands"])
        user.refused("It takes start, cancel, choose, set, propose", "settings")
        self.set(user, height="7mm", rotate_x_deg=30, layer_height=0.1, profile="draft", supports="none")
        user.do("start")
        asked = self.sliced(user)
        self.assertEqual(asked["commands"], ["start", "cancel", "set", "settings"])
        self.assertAlmostEqual(asked["sliced"]["height_mm"], 7, delta=0.3)
        self.set(user, lift_height=6)
        changed = user.until(lambda s: values(s)["lift_height"] == (6, "person"), "the lift")
        self.assertEqual(changed["job"]["id"], asked["job"]["id"], "no new layers")
        self.assertEqual(user.ask("settings", **{"for": asked["asks"]})["told"]["code"], "answer_stale")
        user.do("settings", **{"for": asked["job"]["id"]})
        back = self.offered(user)
        self.assertNotEqual(back["job"]["id"], asked["job"]["id"])
        self.assertEqual((back["findings"], back["masks"], back["pictures"]["preview"], back["pictures"]["part"]), ([], False, None, None))

        def same(state):
            job = state["job"]
            return (job["number"], job["size"], job["rotate_x_deg"], job["layer_height"], job["profile"], job["values"]) == (
                1, {"side": "height", "mm": 7}, 30, 0.1, "draft", {"lift_height": 6})

        self.assertTrue(same(back), back["job"])
        # Another scan has settings of its own.
        user.do("choose", scan=2)
        other = self.offered(user, lambda s: s["job"]["number"] == 2)
        self.assertTrue(self.plain(other["job"]), other["job"])
        self.set(user, scale=2)
        user.do("choose", scan=1)
        self.offered(user, same)
        # Not now, before slicing and after.
        user.do("cancel")
        user.state("idle", "offer")
        user.do("offer")
        self.offered(user, same)
        user.do("start")
        asked = self.sliced(user)
        self.assertEqual(values(asked)["lift_height"], (6, "person"))
        user.do("set", key="lift_height", value="")
        user.until(lambda s: values(s)["lift_height"][1] == "profile", "the profile's, whoever changed it when")
        self.set(user, lift_height=6)
        user.do("cancel")
        user.state("idle", "offer")
        user.do("offer")
        self.offered(user, same)
        # A reset, of this scan alone.
        user.refused("reset: allowed is", "set", key="reset", value="all")
        user.do("set", key="reset", value="")
        self.offered(user, lambda s: s["job"]["number"] == 1 and self.plain(s["job"]))
        user.do("choose", scan=2)
        self.offered(user, lambda s: s["job"]["number"] == 2 and s["job"]["scale"] == 2)
        # Another stick with the same files.
        shutil.rmtree(self.stick)
        user.until(lambda s: not s["stick"]["present"], "no stick")
        self.put_stick({"a.ply": 3, "b.ply": 2})
        self.assertTrue(self.plain(self.offered(user, lambda s: s["job"]["number"] == 1)["job"]))
        user.do("choose", scan=2)
        self.assertTrue(self.plain(self.offered(user, lambda s: s["job"]["number"] == 2)["job"]))

    def test_stopped_slicing_keeps_them(self):
        user = self.open()
        self.put_stick({"a.ply": 3}, '[job]\nscan = "a.ply"\n[placement]\nrotate_z_deg = 10\n', points=300_000)
        self.offered(user)
        self.set(user, height="9mm")
        user.do("start")
        user.state("slicing", "cancel")
        user.do("cancel")
        user.state("idle", "offer")
        user.do("offer")
        again = self.offered(user)["job"]
        self.assertEqual((again["size"], again["rotate_z_deg"]), ({"side": "height", "mm": 9}, 10))
        user.do("set", key="reset", value="")
        self.offered(user, lambda s: s["job"]["size"] is None and s["job"]["rotate_z_deg"] == 10)  # as its job file says

    def test_any_setting_at_the_question_slices_anew(self):
        user = self.open()
        self.put_stick({"a.ply": 3, "b.ply": 2})
        self.offered(user)
        user.do("choose", scan=2)
        self.set(user, layer_height=0.1, supports="none")
        user.do("start")
        asked = self.sliced(user)
        # What is as it was already, and what is refused, changes nothing.
        for key, value in (("scale", 1), ("supports", "none"), ("layer_height", 0.1), ("profile", "")):
            user.do("set", key=key, value=value)
        for key, value, words in (("scale", 0, "allowed is 1e-6"), ("scael", 1, "unknown setting"), ("profile", "thicc", "no profile"),
                                  ("support_at", "1,1,1", "supports are off"), ("height", "tall", "a length")):
            user.refused(words, "set", key=key, value=value)
        user.do("set", key="lift_height", value=6)
        last = user.until(lambda s: values(s)["lift_height"][0] == 6, "the lift")
        self.assertEqual(last["job"]["id"], asked["job"]["id"])
        for key, value in (("scale", 1.5), ("height", "5mm"), ("supports", "auto"), ("rotate_x_deg", 90), ("profile", "draft")):
            before = asked
            user.do("set", key=key, value=value, **{"for": asked["job"]["id"]})
            asked = self.sliced(user, before)
            self.assertNotIn("idle", [s["state"] for s in user.states[user.states.index(before):]])
            self.assertEqual(asked["job"]["number"], 2)
            self.assertEqual(values(asked)["lift_height"], (6, "person"))
            if key == "scale":
                self.assertAlmostEqual(asked["sliced"]["height_mm"], 6, delta=0.3)
        self.assertEqual((asked["job"]["size"], asked["job"]["supports"], asked["job"]["profile"]), ({"side": "height", "mm": 5}, "auto", "draft"))
        # Without its stick it can't be sliced anew, but waits for it.
        self.stick.rename(self.dir / "pulled")
        gone = user.until(lambda s: not s["stick"]["present"], "no stick")
        self.assertEqual(gone["commands"], ["start", "cancel", "set"])
        reply = user.ask("set", key="height", value="4mm")
        self.assertEqual(reply["told"], {"code": "scan_not_there", "values": {}, "name": "height"})
        user.refused("It takes start, cancel, set", "settings")
        user.do("set", key="lift_height", value=7)
        (self.dir / "pulled").rename(self.stick)
        user.until(lambda s: "settings" in s["commands"], "the stick")
        user.do("settings")
        back = self.offered(user)["job"]
        self.assertEqual((back["number"], back["size"], back["rotate_x_deg"], back["values"]), (2, {"side": "height", "mm": 5}, 90, {"lift_height": 7}))
        user.do("start")
        asked = self.sliced(user)
        user.do("set", key="reset", value="")
        asked = self.sliced(user, asked)
        self.assertTrue(self.plain(asked["job"]), asked["job"])
        user.do("start", **{"for": asked["asks"]})
        user.state("plate in use", "plate-empty")

    def test_an_archive_goes_back_and_stays_as_it_was_sliced(self):
        user = self.open()
        self.put_stick({"part.zip": archive(layers=3)})
        self.offered(user)
        user.do("start")
        self.sliced(user)
        user.refused("can't be changed once the layers are made", "set", key="height", value="5mm")
        self.set(user, exposure_time=3)
        user.until(lambda s: values(s)["exposure_time"] == (3, "person"), "3 s")
        user.do("settings")
        self.assertEqual(self.offered(user)["job"]["values"], {"exposure_time": 3})
        user.do("start")
        self.assertEqual(values(self.sliced(user))["exposure_time"], (3, "person"))

    def test_a_rig_that_starts_by_itself_goes_back_too(self):
        """It asks only because of what it found; going back must not start it again."""
        user = self.open("on_stick")
        self.put_stick({"part.zip": archive(layers=3)})  # which doesn't say how long its layers are exposed
        self.sliced(user)
        user.do("settings")
        self.assertIn("start", self.offered(user)["commands"])

    def test_an_uploaded_scan_keeps_them_until_it_is_replaced(self):
        user = self.open()
        self.put_stick({"stick.ply": 2})
        scan = self.dir / "up.ply"
        write_sphere(scan, points=5000, radius=3)

        def upload():
            self.run_it("ctl", "upload", scan, "--socket", self.path)
            return self.offered(user, lambda s: s["stick"]["uploaded"] and s["job"]["scan"] == "up.ply")

        self.offered(user)
        self.set(user, height="8mm")
        upload()
        self.set(user, height="9mm", layer_height=0.1)
        user.do("start")
        asked = self.sliced(user)
        self.run_it("ctl", "settings", "--socket", self.path)
        self.offered(user, lambda s: s["stick"]["uploaded"] and s["job"]["size"] == {"side": "height", "mm": 9})
        user.do("cancel")
        user.state("idle", "offer")
        user.do("offer")
        # Both are offered then; each has its own.
        self.offered(user, lambda s: s["job"]["scan"] == "stick.ply" and s["job"]["size"] == {"side": "height", "mm": 8})
        user.do("cancel")
        self.offered(user, lambda s: s["job"]["scan"] == "up.ply" and s["job"]["size"] == {"side": "height", "mm": 9})
        user.do("start")
        asked = self.sliced(user, asked)
        # Another one comes while it is asked about: nobody can go back to this one.
        write_sphere(scan, points=6000, radius=3)
        self.run_it("ctl", "upload", scan, "--socket", self.path)
        user.until(lambda s: "settings" not in s["commands"] and s["upload"]["stage"] == "kept", "replaced")
        user.refused("the scan is no longer there", "set", key="height", value="4mm")
        user.do("cancel")
        self.assertTrue(self.plain(self.offered(user, lambda s: s["stick"]["uploaded"])["job"]))


if __name__ == "__main__":
    main()
