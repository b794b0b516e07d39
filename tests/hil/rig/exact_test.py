#!/usr/bin/env python3
"""Whole prints on the exact machine: every light, every step, every pixel; and three broken firmwares.

Usage: exact_test.py HOST_BUILD CROSS_BUILD [--arch arm64|armhf] [unittest options]
"""

import re

import rig
from printer import COVER, objections, trace_times

BROKEN_LIGHT = 3  # from 0


class ExactPrint(rig.Rig):
    EXACT = True
    DISK = False
    PROGRAMS = ("tests/plumblined-broken",)

    def setUp(self):
        super().setUp()
        self.follow()

    def start_print(self, program="plumblined", environment=""):
        # An idle guest's clock leaps from timer to timer, past the time limits of devices that the host plays. So keep it busy.
        self.run_in_guest("while :; do :; done & echo $! > /tmp/busy; renice 19 $!")
        self.start_daemon(program, environment)
        self.plug(self.stick)
        self.until("the stick may be pulled")
        self.run_in_guest("kill $(cat /tmp/busy)")

    def wrong_with(self, fault):
        """Prints with a firmware that fails at the light BROKEN_LIGHT (broken.cpp). @returns the findings of the checks"""
        self.start_print("plumblined-broken", f"PLUMBLINE_BROKEN={fault}")
        self.until_over()
        return objections(self.stage.lights, self.masks, rig.LAYER_STEPS, rig.LIFT_STEPS) + self.stage.trouble

    def test_every_light_has_its_mask_its_height_and_its_time(self):
        self.start_print()
        self.prints()
        self.assertTrue(all(light.before and light.after for light in self.stage.lights), "pictures")
        report = self.report()
        steps = report["stage"]
        self.assertEqual(steps["steps"], self.stage.travelled, "steps that the firmware says it took")
        self.tell(f"{steps['steps']} steps, {steps['late_steps']} late, the worst by {steps['worst_lateness_ms']:.3f} ms")
        asked = [line["asked_s"] for line in report["exposures"]]
        self.assertEqual(asked[0], 1.5)
        self.assertTrue(1.0 < asked[1] < 1.5, asked[1])
        self.assertEqual(set(asked[2:]), {1.0})
        off = [1e3 * (real - wanted) for real, wanted in zip(self.exposures(), asked, strict=True)]
        self.tell(f"{len(asked)} exposures, off by {min(off):.4f} to {max(off):.4f} ms of the guest's time")
        self.assertLess(max(map(abs, off)), 1.0, "ms")

    def test_cover_that_opens_with_the_light_ends_it_within_10_ms(self):
        self.stage.on_light = lambda light: light == 2 and self.machine.set_line(COVER, 1)
        self.start_print()
        self.until("the cover is open")
        self.machine.set_line(COVER, 0)
        self.until("press start to go on")
        self.assertEqual(len(self.stage.lights), 3)
        self.press_start_until("layer 3 of", after="press start to go on")
        # The rest of the layer comes after the pause's lift, which is 10 mm (quick.toml).
        self.prints(cut=2, but=[f"light 2: {95 + 2 * 500} steps before it and not 95"])
        lit = self.exposures()
        self.tell(f"dark {1e3 * lit[2]:.3f} ms of the guest's time after the cover was opened")
        self.assertLess(lit[2], 0.010)
        self.assertAlmostEqual(lit[2] + lit[3], 1.0, delta=0.002)

    def test_killed_in_an_exposure_it_is_dark_within_50_ms_and_resumes(self):
        self.start_print()
        trace = "/sys/kernel/tracing/trace"
        self.run_in_guest(f"killed=$(pidof plumblined); while [ $(grep -c 'set 1' {trace}) -lt 4 ]; do usleep 100000; done;"
                          f" echo killed > {trace}_marker; kill -9 $killed")
        # The idle guest's clock would leap to the watchdog's end.
        self.run_in_guest(f"sleep 1; {rig.DISARM}")
        self.assertFalse(self.stage.lit())
        text = self.run_in_guest(f"cat {trace}")
        killed = float(re.search(r"([0-9.]+): tracing_mark_write: killed", text).group(1))
        changes = trace_times(text, self.lamp_gpio)
        self.assertTrue([level for at, level in changes if at < killed][-1], "lit as it was killed")
        dark = next(at for at, level in changes if at > killed and not level)
        self.tell(f"dark {1e3 * (dark - killed):.3f} ms of the guest's time after kill -9")
        self.assertLess(dark - killed, 0.050)
        self.resumes()

    def test_light_before_the_flip_is_found(self):
        # Between two layers the panel is black.
        white = self.masks[BROKEN_LIGHT].count(0xFF)
        self.assertEqual(self.wrong_with("early-light"), [f"light {BROKEN_LIGHT}: {white} pixels wrong at its beginning"])

    def test_a_lost_step_is_found(self):
        after = range(BROKEN_LIGHT + 1, len(self.masks))
        wrong = [f"light {light}: 1 steps too low" for light in after]
        wrong.insert(1, f"light {after[0]}: 94 steps before it and not 95")
        self.assertEqual(self.wrong_with("lost-step"), wrong)
        self.assertEqual(self.report()["stage"]["steps"], self.stage.travelled + 1)

    def test_a_wrong_pixel_is_found(self):
        wrong = [f"light {BROKEN_LIGHT}: 1 pixels wrong at its {when}" for when in ("beginning", "end")]
        self.assertEqual(self.wrong_with("wrong-pixel"), wrong)


if __name__ == "__main__":
    rig.main(__doc__)
