#!/usr/bin/env python3
"""plumbline profile: what PrusaSlicer slices with it, the board prints as its profile says."""

import json
import re
import shutil
import subprocess
import unittest

from case import SIM2K, SOURCE_DIR, Program, main
from sliced_test import write_ell

BOARDS = sorted((SOURCE_DIR / "board").glob("*.toml"))


class Profile(Program):
    def profile(self, program, board, *arguments):
        text = self.run_it("profile", "--for", program, "--printer", board, *arguments).stdout
        return dict(re.findall(r"^(\w+) = (.*)$", text, re.MULTILINE))

    def test_each_board_has_one(self):
        for board in BOARDS:
            with self.subTest(board.stem):
                ini = self.profile("prusaslicer", board)
                self.assertEqual((ini["printer_technology"], ini["printer_model"]), ("SLA", board.stem))
                self.assertEqual(list(ini), list(dict.fromkeys(ini)))
                printer = self.profile("uvtools", board)
                self.assertEqual(printer, {key: ini[key] for key in printer})
                self.assertNotIn("exposure_time", printer, "UVtools has printers apart from materials")

    def test_says_the_boards_panel_and_the_profiles_values(self):
        out = self.dir / "draft.ini"
        self.run_it("profile", "--for", "prusaslicer", "--printer", SIM2K, "--profile", "draft", "-o", out)
        ini = dict(re.findall(r"^(\w+) = (.*)$", out.read_text(), re.MULTILINE))
        self.assertEqual((ini["display_pixels_x"], ini["display_pixels_y"], ini["display_width"]), ("1440", "2560", "68.04"))
        self.assertEqual((ini["layer_height"], ini["exposure_time"], ini["initial_exposure_time"]), ("0.1", "3", "25"))
        self.assertEqual((ini["faded_layers"], ini["max_exposure_time"], ini["gamma_correction"]), ("6", "60", "1"))
        self.assertEqual((ini["absolute_correction"], ini["relative_correction_x"], ini["material_correction_z"]), ("0", "1", "1"))
        self.assertEqual(self.profile("prusaslicer", SOURCE_DIR / "board/mono2k.toml")["gamma_correction"], "0", "no grey")
        for note in ("BottomLayerCount_3", "LiftHeight_3", "LiftSpeed_120", "RetractSpeed2_120", "WaitTimeBeforeCure_0.2"):
            self.assertIn(f"\\n{note}\\n", ini["printer_notes"])
        self.assertEqual(ini["support_pillar_diameter"], "1")

    def test_wrong_use_is_named(self):
        self.assertIn("prusaslicer", self.run_it("profile", "--for", "chitubox", "--printer", SIM2K, status=2).stderr)
        self.run_it("profile", "--for", "uvtools", "--printer", "nosuch", status=1)

    @unittest.skipUnless(shutil.which("prusa-slicer"), "needs prusa-slicer")
    def test_what_prusaslicer_slices_with_it_prints_as_the_profile_says(self):
        mesh, ini, part, report = (self.dir / name for name in ("ell.stl", "board.ini", "part.sl1", "report.json"))
        write_ell(mesh, height=1.5)
        for board in BOARDS:
            with self.subTest(board.stem):
                told = self.profile("prusaslicer", board, "--profile", "standard")
                self.run_it("profile", "--for", "prusaslicer", "--printer", board, "--profile", "standard", "-o", ini)
                ini.write_text(re.sub("(?m)^supports_enable = 1$", "supports_enable = 0\npad_enable = 0", ini.read_text()))
                centre = f"{float(told['display_width']) / 2},{float(told['display_height']) / 2}"
                subprocess.run(["prusa-slicer", "--loglevel", "1", "--export-sla", "--load", ini, "--center", centre, mesh, "-o", part],
                               check=True, capture_output=True)
                inspected = json.loads(self.run_it("inspect", part, "--printer", board, "--json").stdout)
                self.assertEqual((inspected["fits"], inspected["turned"]), (True, False))
                said = inspected["archive"]
                self.assertEqual((said["layers"], said["layer_height"], said["initial_layer_height"]), (30, 0.05, 0.05))
                self.assertEqual((said["exposure_time"], said["initial_exposure_time"]), (2.5, 30))
                self.assertEqual((said["bottom_layer_count"], said["faded_layers"]), (5, 8))
                self.assertEqual((said["lift_height"], said["lift_speed"], said["retract_height2"]), (4, 60, 2))
                if board == SIM2K:
                    self.print_and_compare(mesh, part, report)

    def print_and_compare(self, mesh, part, report):
        """No mirror image: the layers are those of our own slicing, but for the pixels of the outline."""
        kept, ours = self.dir / "kept", self.dir / "ours"
        self.run_it("print", part, "--printer", SIM2K, "--report", report, "--keep-part", kept, "--quiet")
        told = json.loads(report.read_text())
        self.assertEqual((told["state"], told["layer_height_mm"], told["objections"]), ("finished", 0.05, []))
        asked = [line["asked_s"] for line in told["exposures"]]
        self.assertEqual((asked[:5], asked[13:]), ([30.0] * 5, [2.5] * 17))
        self.run_it("slice", mesh, "-o", ours, "--printer", SIM2K, "--layer-height", 0.05, "--supports", "none", "--no-preview")
        from case import png_rows
        both = either = 0
        for a, b in zip(*(png_rows((folder / "layers/00010.png").read_bytes())[1] for folder in (ours, kept))):
            a, b = int.from_bytes(a, "big"), int.from_bytes(b, "big")
            both += (a & b).bit_count()
            either += (a | b).bit_count()
        self.assertGreater(both / either, 0.98)


if __name__ == "__main__":
    main()
