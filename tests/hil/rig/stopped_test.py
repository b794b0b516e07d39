#!/usr/bin/env python3
"""On the exact machine: firmware, keeper or both are stopped or killed at random moments of real exposures.

Usage: stopped_test.py HOST_BUILD CROSS_BUILD [--arch arm64|armhf] [unittest options]
PLUMBLINE_STOP_ROUNDS=200 does it that often; otherwise each once.
"""

import os
import random
import re
import time

import rig
from printer import LAMP, trace_times

ROUNDS = int(os.environ.get("PLUMBLINE_STOP_ROUNDS", "6"))
SEED = int(os.environ.get("PLUMBLINE_STOP_SEED", "1"))
KINDS = [(who, number) for number in ("STOP", "KILL") for who in ("plumblined", "plumbline-keeper", "plumblined plumbline-keeper")]
TRACE = "/sys/kernel/tracing/trace"


class Stopped(rig.Rig):
    EXACT = True
    DISK = False

    def setUp(self):
        super().setUp()
        self.follow()

    def light(self):
        """Starts the daemon, or goes on with the one that runs, until the lamp is lit in the guest's eyes."""
        self.run_in_guest(f"echo > {TRACE}")
        # An idle guest's clock leaps from timer to timer, past the time limits of devices that the host plays. So keep it busy.
        self.run_in_guest("while :; do :; done & echo $! > /tmp/busy; renice 19 $!")
        if not self.machine.run("pidof plumblined")[1]:
            self.start_daemon()
            if "interrupted" not in self.log():
                self.plug(self.stick)
        if "the stick may be pulled" not in self.log():
            self.until("the stick may be pulled", "interrupted")
        if "interrupted" in self.log():
            self.run_in_guest("> /tmp/log")
            self.press_start_until("homing")
        self.run_in_guest("kill $(cat /tmp/busy)")

    def strike(self, who, number, after_us):
        """Sends a signal so long after the lamp has gone on. @returns guest seconds from then until dark; None if it stays lit"""
        text = self.run_in_guest(
            f"struck=$(pidof {who}); until grep -q 'set 1' {TRACE}; do usleep 20000; done; usleep {after_us};"
            f" echo struck > {TRACE}_marker; kill -{number} $struck; usleep 200000; cat {TRACE}", seconds=rig.PATIENCE)
        struck = float(re.search(r"([0-9.]+): tracing_mark_write: struck", text).group(1))
        changes = trace_times(text, self.lamp_gpio)
        self.assertTrue([level for at, level in changes if at < struck][-1], "lit as the signal was sent")
        return next((at - struck for at, level in changes if at > struck and not level), None)

    def test_whoever_is_stopped_or_killed_the_lamp_is_dark_within_50_ms(self):
        chance, worst = random.Random(SEED), {}
        for done in range(ROUNDS):
            who, number = KINDS[done % len(KINDS)]
            with self.subTest(round=done, who=who, number=number):
                self.light()
                dark = self.strike(who, number, chance.randrange(800_000))
                if " " in who and dark is None:
                    self.until_reset()
                    self.tell(f"round {done}: {who}, {number}: reset by the watchdog")
                    continue
                self.assertIsNotNone(dark, "still lit")
                self.assertLess(dark, 0.050)
                self.assertFalse(self.stage.lit())
                self.tell(f"round {done}: {who}, {number}: dark after {1e3 * dark:.3f} ms")
                worst[who, number] = max(dark, worst.get((who, number), 0))
                if who == "plumbline-keeper":
                    self.until("PL-303")
                    self.assertTrue(self.machine.run("pidof plumbline-keeper")[1], "the next keeper")
                    # The first press acknowledges the fault. light() gives the second, which resumes.
                    self.run_in_guest("> /tmp/log")
                    self.press_start_until("interrupted")
                else:
                    self.assertFalse(self.machine.run("pidof plumblined")[1], "ended")
                    # The idle guest's clock would leap to the watchdog's end.
                    self.run_in_guest(f"while pidof plumbline-keeper; do usleep 50000; done; {rig.DISARM}")
        for (who, number), dark in worst.items():
            self.tell(f"{who}, {number}: dark after {1e3 * dark:.3f} ms of the guest's time at most")

    def until_reset(self):
        """Nobody is left to turn the lamp off, so the board's watchdog does."""
        self.assertTrue(self.stage.lit())
        until = time.monotonic() + rig.PATIENCE
        while not self.machine.reset_by_watchdog():
            self.assertLess(time.monotonic(), until, "the watchdog does not reset the board")
            time.sleep(0.05)
        self.boot()
        self.run_in_guest("touch /state/plate-is-empty /state/tank-is-full")  # the state was in memory
        self.pull()
        self.assertFalse(self.machine.level.get(LAMP, False))
        self.follow()

    def test_the_board_stays_awake_while_the_lamp_is_lit(self):
        # A suspend that respects wake-up events reads this file first. The read waits as long as one is held.
        count, said = "/sys/power/wakeup_count", "/tmp/count"
        self.run_in_guest(f"timeout 5 cat {count} > {said}; test -s {said}")
        self.light()
        self.run_in_guest(f"until grep -q 'set 1' {TRACE}; do usleep 20000; done; (cat {count} > {said}) & usleep 300000;"
                          f" test ! -s {said}", seconds=rig.PATIENCE)
        self.run_in_guest(f"until tail -n 1 {TRACE} | grep -q 'set 0'; do usleep 20000; done; usleep 100000; test -s {said}",
                          seconds=rig.PATIENCE)


if __name__ == "__main__":
    rig.main(__doc__)
