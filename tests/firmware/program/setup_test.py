#!/usr/bin/env python3
"""plumbline setup as a program: a file of answers, a terminal, and every way to stop it."""

import os
import pty
import re
import select
import signal
import subprocess
import termios
import time
import unittest

from case import PLUMBLINE, SIM2K, SOURCE_DIR, Program, main

LIKE = SOURCE_DIR / "board" / "pine64_ls055.toml"
# The panel of LIKE seen without rotation or mirror; its stage as its file says.
ANSWERS = {
    "z_stage.travel_mm": "140",
    "look.corners": "1 2 3 4",
    "move.ready": "yes",
    "move.1": "1",
    "move.2": "5.1",
    "lamp.how": "skip",
}


def keep_what_was_said(terminal):
    """Else the kernel throws away at Ctrl-C what was not read yet, and perhaps what is said to it."""
    attributes = termios.tcgetattr(terminal)
    attributes[3] |= termios.NOFLSH
    termios.tcsetattr(terminal, termios.TCSANOW, attributes)


class Setup(Program):
    def setUp(self):
        super().setUp()
        self.file = self.dir / "mine.toml"
        self.answers = self.dir / "answers.txt"

    def setup_with(self, answers, status=0):
        self.answers.write_text("# answers\n" + "".join(f"{name} = {text}\n" for name, text in answers.items()))
        return self.run_it("setup", self.file, "--simulated", LIKE, "--answers", self.answers, status=status)

    def test_a_file_of_answers_makes_a_board_file(self):
        done = self.setup_with(ANSWERS)
        self.assertIn("Wrote", done.stderr)
        self.assertNotIn("\\x0a", done.stderr)
        self.assertRegex(done.stderr, r"(?m)^Stand before the printer, ")
        text = self.file.read_text()
        for line in ('name = "mine" ', "travel_mm = 140 ", 'mirror = "x" ', "microsteps = 16 ", 'chip = "1c20800.pinctrl" '):
            self.assertIn("\n" + line, text)
        self.assertTrue(all("#" in line for line in text.splitlines() if " = " in line))
        again = self.run_it("setup", self.file, "--simulated", LIKE, "--answers", self.answers, status=1)
        self.assertRegex(again.stderr, "mine.toml: exists already")
        self.assertEqual(self.file.read_text(), text)
        self.assertEqual(sorted(p.name for p in self.dir.iterdir() if "mine" in p.name), ["mine.toml"])

    def test_a_wrong_answer_names_its_line_and_writes_nothing(self):
        for change, message in (
            ({"look.corners": "1 3 2 4"}, "answers.txt:3: look.corners: no panel shows the corners as 1 3 2 4"),
            ({"z_stage.travel_mm": "tall"}, "answers.txt:2: z_stage.travel_mm: found a string 'tall', allowed is a number from 1"),
            ({"z_stag.travel_mm": "1"}, "answers.txt:8: nobody asked z_stag.travel_mm"),
            ({"move.ready": "perhaps"}, "answers.txt:4: move.ready: answer yes or no"),
            ({"move.2": "77"}, "no answer to move.3"),
        ):
            done = self.setup_with(ANSWERS | change, status=1)
            self.assertIn(message, done.stderr.splitlines()[-1])
            self.assertFalse(self.file.exists())

    def test_without_measuring_the_file_is_like_the_other(self):
        self.setup_with({"measure": "no"})
        self.assertIn('connector = "HDMI-A-1"', self.file.read_text())

    def at_a_question(self, name, act, status):
        """Runs it on a terminal, presses return until it asks `name`, then acts."""
        process, terminal = pty.fork()
        if process == 0:
            os.execv(PLUMBLINE, [str(PLUMBLINE), "setup", str(self.file), "--simulated", str(LIKE)])
        keep_what_was_said(terminal)
        said, end = b"", time.monotonic() + 20
        while time.monotonic() < end:
            try:
                said += os.read(terminal, 4096)
            except OSError:
                break
            if said.endswith(b"> ") and said.rstrip().split(b"\r\n\r\n")[-1].startswith(name.encode()):
                act(process, terminal)
                name = "nothing more"
            elif said.endswith(b"> "):
                os.write(terminal, b"\n")
                said += b"."
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), status, said.decode())
        self.assertFalse(self.file.exists())
        self.assertIn("nothing was written", said.decode())

    def test_stops_for_ctrl_c_sigterm_and_the_end_of_the_input(self):
        self.at_a_question("panel.rows", lambda _, terminal: os.write(terminal, b"\x03"), 130)
        self.at_a_question("look.corners", lambda _, terminal: os.write(terminal, b"\x03"), 130)
        self.at_a_question("look.corners", lambda process, _: os.kill(process, signal.SIGTERM), 130)
        self.at_a_question("look.corners", lambda _, terminal: os.write(terminal, b"\x04"), 130)
        closed = subprocess.run(
            [PLUMBLINE, "setup", self.file, "--simulated", LIKE], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20
        )
        self.assertEqual(closed.returncode, 130)
        self.assertIn("the input has ended: nothing was written", closed.stderr)

    def changes(self):
        """The lamp's line: on or off, and when, in ns of the monotonic clock."""
        text = self.line.read_text() if self.line.exists() else ""
        return [(word, int(at)) for word, at in (line.split() for line in text[: text.rfind("\n") + 1].splitlines())]

    def struck_in_light(self, strike):
        """Lights the lamp for 20 s of the host's time, then strikes. @returns seconds until it is dark, what the program said"""
        answers = {"move.ready": "no", "lamp.how": "sheet", "lamp.seconds": "30", "lamp.light": "yes"}
        said, struck = self.on_a_terminal(answers, "--speedup", "1.5", strike=strike)
        return (self.changes()[-1][1] - struck) / 1e9, said

    def on_a_terminal(self, answers, *options, strike=None, status=130):
        """
        A person who answers, and presses return where `answers` has nothing. The lamp is lit once, and nothing is written.
        @param strike  called when the lamp is lit
        @returns what the program said, when it was struck
        """
        self.line = self.dir / "lamp-line"
        self.line.unlink(missing_ok=True)
        process, terminal = pty.fork()
        if process == 0:
            os.execv(PLUMBLINE, [str(PLUMBLINE), "setup", str(self.file), "--simulated", str(SIM2K), "--lamp-line", f"file:{self.line}", *options])
        keep_what_was_said(terminal)
        said, struck, end = b"", None, time.monotonic() + 60
        while time.monotonic() < end:
            if select.select([terminal], [], [], 0.005)[0]:
                try:
                    said += os.read(terminal, 4096)
                except OSError:
                    break
            if said.endswith(b"> "):
                name = said.rstrip().split(b"\r\n\r\n")[-1].split(b":")[0].decode()
                if name == "look.corners" and answers.get(name) != "light":
                    answers[name] = re.findall("simulated: you see ([1-4 ]+)", said.decode())[-1]
                os.write(terminal, answers.get(name, "").encode() + b"\n")
                said += b"."
            if strike and struck is None and self.changes()[-1:] and self.changes()[-1][0] == "on":
                struck = time.monotonic_ns()
                strike(process, terminal)
        os.close(terminal)  # ends it, should it still ask
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), status, said.decode())
        self.assertFalse(self.file.exists())
        self.assertEqual([word for word, _ in self.changes()], ["on", "off"])
        return said.decode(), struck

    def test_ctrl_c_and_sigterm_turn_the_lit_lamp_off_at_once(self):
        for strike in (lambda _, terminal: os.write(terminal, b"\x03"), lambda process, _: os.kill(process, signal.SIGTERM)):
            dark_after, said = self.struck_in_light(strike)
            # 10 ms on an idle machine; other tests may run beside this one.
            self.assertLess(dark_after, 1)
            self.assertIn("interrupted: the lamp is dark, the plate stands, and nothing was written", said)
            self.assertNotIn("lamp.thickness", said)

    def test_a_lamp_that_stays_lit_ends_it(self):
        meter = {"move.ready": "no", "lamp.how": "meter", "lamp.light": "yes"}
        look = {"look.corners": "light", "look.light": "yes"}
        for answers, last in ((meter, "lamp.light"), (look, "look.light")):
            for fault, told in (("lamp.stuck_on", "the lamp went off only when its supply was cut: have the lamp repaired"),
                                ("lamp.runaway", "the lamp stays on even with its supply cut: pull the printer's plug")):
                with self.subTest(last, fault=fault):
                    said, _ = self.on_a_terminal(answers, "--speedup", "50", "--fault", f"{fault}@t=0s", status=1)
                    # It is the last thing that is said: no other measurement, no move, no question and no file.
                    self.assertTrue(said.rstrip().splitlines()[-1].startswith(f"plumbline: {told}"), said)
                    self.assertEqual(re.findall(r"(?m)^([a-z_]+\.[a-z_0-9]+): ", said.replace("\r", ""))[-1], last)
                    for words in ("The lamp is dark again", "Moving up", "Wrote", "Not measured", "end_stop.right"):
                        self.assertNotIn(words, said)

    def test_lists_the_board(self):
        self.assertRegex(self.run_it("setup", "--list").stdout, "board")
        self.assertRegex(self.run_it("setup", status=2).stderr, "name the board file to write, or --list")


main()
