#!/usr/bin/env python3
"""One job is not taken for another, and no press for an answer to the question after: over the socket and the page of a real plumblined,
with two clicks of one finger, with answers that come late, and with restarts between slicing, looking and starting."""

import json
import os
import random
import time
import unittest

from case import main
from glances_test import archive_of
from page_client import PagePrinter
from sliced_test import square

GAPS = (0.2, 0.4, 0.8)  # s between two clicks
PAIRS = int(os.environ.get("PLUMBLINE_PAIRS", "6"))
INI = "expTime = 2.5\nexpTimeFirst = 4\nnumFade = 0\nlayerHeight = 0.05\n"


class Identity(PagePrinter):
    def archive(self, *sizes):
        layers = {f"part{i:05}.png": square(size) for i, size in enumerate(sizes)}
        return archive_of(self.dir / "made.sl1", {"config.ini": INI, **layers})

    def open(self, start="after_preview", speedup=1, page=True, **options):
        printer = self.page_board("local", start=start)
        self.daemon, user = self.start(printer=printer, speedup=speedup, **options)
        if page:
            self.start_page(start=start)
            self.token = self.paired()
        return user

    def again(self, speedup):
        """A power cut of the board, or an update: the page stays, the daemon is another process."""
        self.daemon.kill()
        self.daemon.wait()
        return self.open(speedup=speedup, page=False, plate=False)

    def by_page(self, do, **members):
        status, _, data = self.ask("POST", "/command", {"do": do, **members}, headers=self.token)
        return status, json.loads(data)

    def until_page(self, holds):
        """The page's own state, which may be a moment behind."""
        end = time.monotonic() + 60
        while time.monotonic() < end:
            status, _, data = self.ask("GET", "/state")
            if status == 200 and holds(json.loads(data)):
                return json.loads(data)
            time.sleep(0.02)
        return self.fail(data[:500])

    def sliced(self, user):
        return user.until(lambda s: s["state"] == "offered" and s["sliced"] and s["commands"], "what was sliced is offered")


class TwoClicks(Identity):
    """At the speed of people."""

    def check_second(self, way):
        """@param way  of a command: a function of the client and the word, which returns the reply"""
        user = self.open()
        self.put_stick({"a.sl1": self.archive(100, 120)})
        user.state("offered", "start")
        for gap in GAPS:
            time.sleep(1.1)
            first = way(user, "start")
            time.sleep(gap)
            second = way(user, "start")
            self.assertTrue(first["ok"], first)
            self.assertFalse(second["ok"], (gap, second))
            self.assertIn(second["told"]["code"], ("answer_soon", "command_not_now"))
            self.sliced(user)
            self.assertNotIn("checks", [state["state"] for state in user.states], "nobody has confirmed the preview")
            time.sleep(1.1)
            self.assertTrue(way(user, "cancel")["ok"])
            user.state("idle", "offer")
            user.do("offer")
            user.until(lambda s: s["state"] == "offered" and not s["sliced"] and s["commands"], "offered again")

    def test_of_two_clicks_on_print_the_second_does_nothing_by_socket(self):
        self.check_second(lambda user, do: user.ask(do))

    def test_of_two_clicks_on_print_the_second_does_nothing_by_page(self):
        self.check_second(lambda user, do: self.by_page(do)[1])


class Answers(Identity):
    def test_each_names_its_question_and_one_that_is_over_is_refused(self):
        user = self.open(speedup=30)
        self.put_stick({"a.sl1": self.archive(100, 120), "b.sl1": self.archive(*range(200, 215))})
        offered = user.state("offered", "start")
        first = offered["asks"]
        # Another scan is another question, and another job.
        user.do("choose", scan=2)
        other = user.until(lambda s: s["job"]["number"] == 2, "b")
        self.assertNotIn(other["asks"], (first, None))
        self.assertNotEqual(other["job"]["id"], offered["job"]["id"])
        for do in ("start", "cancel"):
            self.assertEqual(user.ask(do, **{"for": first})["told"]["code"], "answer_stale")
        for wrong in ({"for": "1"}, {"for": 5}, {"for": "0" * 16}):
            user.refused("16 hexadecimal digits", "start", **wrong)
        # So is another setting of it, for whoever starts it. Whoever sets one more names the job.
        user.do("set", key="profile", value="draft", **{"for": other["job"]["id"]})
        changed = user.until(lambda s: s["job"]["profile"] == "draft", "draft")
        self.assertEqual(changed["job"]["id"], other["job"]["id"])
        self.assertEqual(user.ask("start", **{"for": other["asks"]})["told"]["code"], "answer_stale")
        user.do("start", **{"for": changed["asks"]})
        sliced = self.sliced(user)
        self.assertEqual(sliced["job"]["id"], other["job"]["id"])
        # What has been sliced can't be changed for another scan, and says so before anybody tries. Its exposures can, which is another question.
        self.assertEqual(sliced["commands"], ["start", "cancel", "set", "settings"])
        user.refused("It takes start, cancel, set, settings", "choose", scan=1)
        user.do("set", key="exposure_time", value=3, **{"for": sliced["job"]["id"]})
        seen, sliced = sliced, user.until(lambda s: s["asks"] != sliced["asks"], "another question")
        self.assertEqual(user.ask("start", **{"for": seen["asks"]})["told"]["code"], "answer_stale")
        self.assertEqual(user.ask("start", **{"for": changed["asks"]})["told"]["code"], "answer_stale")
        # One that names its question counts at once, also in the first second.
        user.do("start", **{"for": sliced["asks"]})
        printing = user.state("printing")
        self.assertIsNone(printing["asks"])
        user.do("pause", **{"for": printing["job"]["id"]})
        taken = user.until(lambda s: s["message_told"] and s["message_told"]["code"] == "pause_taken" or s["state"] == "paused", "taken")
        if taken["state"] == "printing":
            self.assertNotIn("pause", taken["commands"])
        paused = user.state("paused", "resume")
        # "Cancel the print?" of this print ends this print, whatever it does meanwhile.
        self.assertEqual(user.ask("resume", **{"for": sliced["asks"]})["told"]["code"], "answer_stale")
        user.do("resume", **{"for": paused["asks"]})
        user.state("printing")
        user.do("cancel", **{"for": printing["job"]["id"]})
        plate = user.state("plate in use", "plate-empty")
        self.assertEqual(json.loads((self.folder / "report.json").read_text())["id"], printing["job"]["id"])
        user.do("plate-empty", **{"for": plate["asks"]})
        again = user.until(lambda s: s["state"] == "offered" and not s["sliced"] and s["asks"], "offered again")
        # The second click of the same finger, and the question that was left open over there.
        self.assertEqual(user.ask("plate-empty", **{"for": plate["asks"]})["told"]["code"], "answer_stale")
        self.assertEqual(user.ask("start", **{"for": plate["asks"]})["told"]["code"], "answer_stale")
        user.do("start", **{"for": again["asks"]})
        user.do("start", **{"for": self.sliced(user)["asks"]})
        user.state("printing")
        for do in ("cancel", "pause"):
            status, reply = self.by_page(do, **{"for": printing["job"]["id"]})
            self.assertEqual((status, reply["told"]["code"]), (409, "answer_stale"), "that print is over")
        self.assertEqual(user.state("plate in use", "plate-empty")["job"]["result"], "finished")
        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual(report["objections"], [], "the person has taken the first part off")
        self.assertNotEqual(report["id"], printing["job"]["id"])

    def test_a_print_keeps_its_id_over_a_power_cut(self):
        user = self.open(start="on_request", speedup=50)
        self.put_stick({"a.sl1": self.archive(*range(100, 120))})
        user.state("offered", "start")
        user.do("start", **{"for": user.states[-1]["asks"]})
        printing = user.until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] > 1, "layer 2")
        user = self.again(50)
        interrupted = user.state("interrupted", "resume")
        self.assertEqual(user.ask("cancel", **{"for": printing["job"]["id"]})["told"]["code"], "answer_stale")
        user.do("resume", **{"for": interrupted["asks"]})
        self.assertEqual(user.until(lambda s: s["job"], "its job")["job"]["id"], printing["job"]["id"])


class Signals(Identity):
    def test_a_signal_darkens_a_lit_lamp_at_once(self):
        """In simulation, too: it was noticed when the exposure was over."""
        user = self.open(start="on_request", speedup=5, page=False)
        long = INI.replace("= 2.5", "= 30").replace("= 4", "= 30")
        layers = {f"part{i:05}.png": square(100) for i in range(4)}
        self.put_stick({"a.sl1": archive_of(self.dir / "made.sl1", {"config.ini": long, **layers})})
        user.state("offered", "start")
        user.do("start", **{"for": user.states[-1]["asks"]})
        user.until(lambda s: s["state"] == "printing" and s["progress"]["layers_done"] == 1, "layer 2")
        # The next light begins after some 2 s here, and lasts 6 s.
        time.sleep(4.5)
        self.daemon.terminate()
        self.daemon.wait(60)
        last = json.loads((self.folder / "report.json").read_text())["exposures"][-1]
        self.assertEqual((last["layer"], last["end"]), (1, "stopped"))
        self.assertLess(last["lit_s"], 25)


class Pictures(Identity):
    """Pairs of jobs of the same names and sizes of files, whose masks differ, in a random order of slicing, looking, restarting, starting."""

    def pictures_of(self, job, layers):
        masks = tuple(self.get(f"/mask?job={job}&n={n}") for n in range(layers))
        return masks, self.get(f"/picture/preview?job={job}"), self.get(f"/part?job={job}")

    def look(self, user, scan):
        """Slices a scan of the stick. @returns the state that asks about it"""
        offered = user.until(lambda s: s["state"] == "offered" and not s["sliced"] and s["commands"], "offered")
        user.do("choose", scan=scan, **{"for": offered["asks"]})
        chosen = user.until(lambda s: s["job"] and s["job"]["number"] == scan and s["asks"] != offered["asks"], f"scan {scan}")
        user.do("start", **{"for": chosen["asks"]})
        sliced = self.sliced(user)
        self.until_page(lambda s: s["job"] and s["job"]["id"] == sliced["job"]["id"] and s["masks"])
        return sliced

    def decline(self, user, sliced):
        user.do("cancel", **{"for": sliced["asks"]})
        user.state("idle", "offer")
        user.do("offer")

    def addresses(self, job):
        return [f"/mask?job={job}&n=0", f"/mask?job={job}&n=1", f"/picture/preview?job={job}&n=1", f"/part?job={job}", f"/proposal?job={job}&n=0"]

    def test_none_is_of_another_job_whatever_is_started_between(self):
        speed, layers = 200, 2
        user = self.open(speedup=speed)
        self.put_stick({"a.sl1": self.archive(100, 160), "b.sl1": self.archive(300, 240)})
        known, ids, questions = {}, set(), set()
        for scan in (1, 2):
            sliced = self.look(user, scan)
            known[scan] = self.pictures_of(sliced["job"]["id"], layers)
            self.decline(user, sliced)
        for one, other in zip(*known.values()):
            self.assertNotEqual(one, other, "the pictures tell the jobs apart")
        chance = random.Random(52)
        restarts = refused = prints = 0
        for pair in range(PAIRS):
            scans = chance.sample((1, 2), 2)
            before = self.look(user, scans[0])
            self.assertEqual(self.pictures_of(before["job"]["id"], layers), known[scans[0]], pair)
            cut = chance.choice(("after slicing", "after looking", "while it prints", "never"))
            if cut == "while it prints":
                user.do("start", **{"for": before["asks"]})
                user.state("printing")
            if cut != "never":
                user = self.again(speed)
                restarts += 1
            if cut == "while it prints":
                asked = user.state("interrupted", "cancel")
                user.do("cancel", **{"for": asked["asks"]})
                asked = user.state("plate in use", "plate-empty")
                user.do("plate-empty", **{"for": asked["asks"]})
            elif cut == "never":
                self.decline(user, before)
            after = self.look(user, scans[1])
            # Whoever had the page open since before asks for what it showed.
            for address in self.addresses(before["job"]["id"]):
                status, _, data = self.ask("GET", address)
                self.assertEqual((status, json.loads(data)["told"]["code"]), (410, "job_stale"), (pair, address))
                refused += 1
            self.assertEqual(self.pictures_of(after["job"]["id"], layers), known[scans[1]], pair)
            for do in ("start", "cancel"):
                status, reply = self.by_page(do, **{"for": before["asks"]})
                self.assertEqual((status, reply["told"]["code"]), (409, "answer_stale"), (pair, do))
            if cut == "after looking":
                user = self.again(speed)
                restarts += 1
                offered = user.state("offered", "start")
                self.until_page(lambda s: s["asks"] == offered["asks"])
                self.assertEqual(self.by_page("start", **{"for": after["asks"]})[0], 409)
            elif chance.random() < 0.5:
                user.do("start", **{"for": after["asks"]})
                asked = user.state("plate in use", "plate-empty")
                report = json.loads((self.folder / "report.json").read_text())
                self.assertEqual((report["id"], report["scan"]), (after["job"]["id"], after["job"]["scan"]))
                self.assertEqual(len(report["exposures"]), layers)
                prints += 1
                user.do("plate-empty", **{"for": asked["asks"]})
            else:
                self.decline(user, after)
            ids |= {before["job"]["id"], after["job"]["id"]}
            questions |= {before["asks"], after["asks"]}
        print(f"{PAIRS} pairs, {restarts} restarts, {prints} prints, {refused} stale pictures refused")
        self.assertEqual((len(ids), len(questions)), (2 * PAIRS, 2 * PAIRS))


if __name__ == "__main__":
    main()
