#!/usr/bin/env python3
"""What plumbline says about wrong command lines, files and disks."""

import ctypes
import os
import re
import resource
import shutil
import subprocess
import unittest

from case import PLUMBLINE, SIM2K, SOURCE_DIR, Program, box, main, write_board, write_sphere


class WorldErrors(Program):
    def refused(self, *arguments, message, **options):
        done = self.run_it(*arguments, status=1, **options)
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr.splitlines()[-1], "^plumbline: " + message)

    def test_missing_scan(self):
        self.refused("slice", self.dir / "no.ply", "-o", self.out, message=".*no.ply: the scan cannot be opened: No such file")
        self.refused("inspect", self.dir / "no.ply", message=".*no.ply: the scan cannot be opened: No such file")
        self.assertFalse(self.out.exists())

    def test_directory_for_a_scan(self):
        self.refused("slice", self.dir, "-o", self.out, message=".*: the folder has no scans: name one with files such as .ply")

    def test_a_file_that_is_given_twice(self):
        write_sphere(self.scan)
        self.refused("slice", self.scan, self.scan, "-o", self.out, message=".*sphere.ply is given twice: name each file")
        self.refused("slice", self.dir, self.scan, "-o", self.out, message=".*sphere.ply is given twice")
        self.assertFalse(self.out.exists())

    def test_file_that_is_not_a_scan(self):
        self.scan.write_bytes(bytes(range(256)) * 10)
        self.refused("slice", self.scan, "-o", self.out, message="sphere.ply: ")
        self.assertFalse(self.out.exists())

    def test_empty_file(self):
        self.scan.write_bytes(b"")
        self.refused("slice", self.scan, "-o", self.out, message="sphere.ply: ")

    def test_output_that_cannot_be_created(self):
        write_sphere(self.scan)
        self.refused("slice", self.scan, "-o", "/proc/plumbline", message="/proc/plumbline: the folder cannot be created")
        self.refused("slice", self.scan, "-o", self.scan, message=".*sphere.ply: files of this kind are not written")
        (self.dir / "letter").touch()
        self.refused("slice", self.scan, "-o", self.dir / "letter", message=".*letter: is a file, not a folder")

    def test_output_of_a_kind_that_is_not_written(self):
        write_sphere(self.scan)
        for name in ("part.ctb", "part.goo", "Part.PWMX", "part.cbddlp", "part.photon", "part.zip", "part.stl", "part.png"):
            path = self.dir / name
            self.refused("slice", self.scan, "-o", path, message=f".*{name}: files of this kind are not written. Give a folder, or an archive that")
            self.assertFalse(path.exists())
        (self.dir / "old.goo").mkdir()
        for name in ("bust.v2", "part.ctb/", "out", "old.goo"):
            self.run_it("slice", self.scan, "-o", f"{self.dir}/{name}", "--quiet", "--no-preview", "--pixel-pitch", 0.5, "--layer-height", 0.5)
            self.assertTrue((self.dir / name / "manifest.json").exists())

    def test_points_without_a_surface(self):
        scan = self.dir / "few.xyz"
        for points, said in (
            ("0 0 0\n", "all of it lies at one place, 0 0 0. Export it again"),
            ("0 0 0\n1 1 1\n", "no surface found in 2 points: most have too few neighbours"),
            ("".join(f"{i / 10} 0 0\n" for i in range(500)), "no surface found in 500 points: most have too few neighbours"),
        ):
            scan.write_text(points)
            for command in (("slice", "-o", self.out), ("inspect",), ("orient",), ("orient", "--json")):
                self.refused(command[0], scan, *command[1:], message=f"few.xyz: {said}")

    def test_outputs_that_cannot_be_written_are_refused_before_the_scan_is_opened(self):
        missing, nowhere = self.dir / "no.ply", self.dir / "no" / "file"
        sim = ("print", missing, "--printer", SIM2K)
        self.refused(*sim, "--report", nowhere, message=".*no/file: cannot be created: No such file or directory")
        self.refused(*sim, "--report", self.dir, message=f"{self.dir}: cannot be created: Is a directory")
        self.refused(*sim, "--keep-part", "/proc/part", message="/proc/part: the folder cannot be created")
        self.refused("inspect", missing, "--picture", nowhere, message=".*no/file: cannot be created: No such file or directory")
        (self.dir / "full").mkdir()
        (self.dir / "full" / "letter.txt").touch()
        self.refused(*sim, "--keep-part", self.dir / "full", message=".*full: holds 'letter.txt', which plumbline did not write")

    def test_outputs_of_a_refused_print_are_as_before(self):
        missing, old, new, part = self.dir / "no.ply", self.dir / "old.json", self.dir / "new.json", self.dir / "part"
        old.write_text("an older report")
        for report in (old, new):
            self.refused(
                "print", missing, "--printer", SIM2K, "--report", report, "--keep-part", part, message=".*no.ply: the scan cannot be opened"
            )
        self.assertEqual(old.read_text(), "an older report")
        self.assertFalse(new.exists() or part.exists())

    def test_a_truth_that_cannot_be_used_is_refused_before_the_scan_is_opened(self):
        sim, part, truth = ("print", self.dir / "no.ply", "--printer", SIM2K), self.dir / "part", self.dir / "truth.stl"
        same = ("--keep-part", part, "--truth", truth)
        self.refused(*sim, *same, message=f"--truth: {truth}: cannot be opened: No such file or directory. Name a file with a closed mesh")
        truth.touch()
        self.refused(*sim, *same, message=r"--truth: truth.stl: the file is empty \(0 bytes\)\. Name a file with a closed mesh")
        facets = box((0, 0, 0), (1, 1, 1)).split("facet normal")
        truth.write_text("solid open\n" + "facet normal".join(facets[:-1]) + "endsolid open\n")
        self.refused(*sim, *same, message=f"--truth: {truth}: is not a closed surface")
        self.assertFalse(part.exists())
        rig = ("print", self.dir / "no.ply", "--printer", SOURCE_DIR / "board" / "rig.toml")
        self.refused(*rig, "--truth", truth, message="--truth is about the part that a simulated printer makes, and rig is")

    def test_a_report_may_be_a_pipe(self):
        pipe = self.dir / "pipe"
        os.mkfifo(pipe)
        missing = self.dir / "no.ply"
        self.refused("print", missing, "--printer", SIM2K, "--report", pipe, message=".*no.ply: the scan cannot be opened")

    def test_the_part_of_a_real_printer_is_no_output(self):
        rig = ("print", self.dir / "no.ply", "--printer", SOURCE_DIR / "board" / "rig.toml")
        self.refused(*rig, "--keep-part", self.dir / "part", message="--keep-part is about the part that a simulated printer makes, and rig is")

    def test_output_without_permission(self):
        def obey_permissions():
            if os.geteuid() == 0:
                pr_capbset_drop, cap_dac_override = 24, 1  # without it, permissions also bind root
                self.assertEqual(ctypes.CDLL(None).prctl(pr_capbset_drop, cap_dac_override), 0)

        write_sphere(self.scan)
        self.out.mkdir(mode=0o555)
        self.refused("slice", self.scan, "-o", self.out, message=".*out/layers: the folder cannot be created: Permission",
                     preexec_fn=obey_permissions)

    def test_full_disk_leaves_nothing_behind(self):
        # A limit on file sizes makes write() fail as a full disk does.
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (700, 700))

        write_sphere(self.scan)
        arguments = ("slice", self.scan, "-o", self.out, "--printer", self.board, "--quiet")
        self.refused(*arguments, message=r".*out/layers/\d+\.png: cannot be written: File too large\. Make room", preexec_fn=limit)
        self.assertFalse(self.out.exists())

    def test_full_standard_output(self):
        write_sphere(self.scan)
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run(
                [PLUMBLINE, "slice", self.scan, "-o", self.out, "--printer", self.board, "--json"],
                stdout=full, stderr=subprocess.PIPE, text=True, timeout=120, check=False,
            )
        self.assertEqual(done.returncode, 1)
        self.assertIn("standard output: cannot be written: No space left", done.stderr)

    def test_board_file_that_is_missing_or_wrong(self):
        write_sphere(self.scan)
        self.refused("slice", self.scan, "-o", self.out, "--printer", self.dir / "no.toml", message=".*no.toml: no such board file. .* mono2k")
        self.refused("slice", self.scan, "-o", self.out, "--printer", self.dir, message=".*: a board file cannot be read: Is a directory")
        self.refused("inspect", self.scan, "--printer", "mono3k", message="no printer is called mono3k. Did you mean mono2k\\?.* in board, ")
        self.board.write_text("[printer]\nnaem = 'x'\n")
        self.refused("slice", self.scan, "-o", self.out, "--printer", self.board, message=".*small.toml:2: .*naem")

    def test_program_that_was_copied_alone_says_where_board_files_are(self):
        write_sphere(self.scan)
        alone = shutil.copy(PLUMBLINE, self.dir)
        for printer, message in (
            ("mono2k", "no printer is called mono2k: there is no .toml file in board. Give the path of one: plumbline's sources have them"),
            ("mono2k.toml", "mono2k.toml: no such board file. Check the path\n"),
        ):
            done = subprocess.run(
                [alone, "inspect", self.scan, "--printer", printer], cwd=self.dir, capture_output=True, text=True, timeout=60, check=False
            )
            self.assertEqual(done.returncode, 1)
            self.assertIn("plumbline: " + message, done.stderr)

    def test_printer_is_found_by_name_from_any_folder(self):
        write_sphere(self.scan)
        said = self.run_it("inspect", self.scan, "--printer", "mono2k", "--json", cwd=self.dir).stdout
        self.assertIn('"printer": "mono2k"', said)

    def test_board_file_must_be_named_after_its_printer(self):
        other = self.dir / "other.toml"
        self.board.rename(other)
        write_sphere(self.scan)
        self.refused("inspect", self.scan, "--printer", other, message=r'.*\[printer\] name is "small", but the file is called other')

    def test_sample_does_not_advise_options_that_it_lacks(self):
        done = self.run_it("sample", self.dir / "no/bust.ply", status=1)
        self.assertNotIn("-o", done.stderr.split("bust.ply: ")[1])

    def test_more_arena_than_there_is(self):
        write_sphere(self.scan)
        self.refused("slice", self.scan, "-o", self.out, "--arena-mib", 1048576, message="--arena-mib asks for an arena of 1048576 MiB")
        write_board(self.board, arena_mib=65536)
        self.refused("slice", self.scan, "-o", self.out, "--printer", self.board, message="the board file asks for an arena of 65536 MiB")

    def test_arena_too_small_for_any_job(self):
        write_sphere(self.scan)
        arguments = ("slice", self.scan, "-o", self.out, "--printer", SOURCE_DIR / "board/mono2k.toml", "--arena-mib", 8)
        self.refused(*arguments, message="the job does not fit into the arena of .* MiB: stage '.*' needs .* MiB")


class Usage(Program):
    def wrong(self, *arguments):
        done = self.run_it(*arguments, status=2)
        self.assertEqual(done.stdout, "")
        self.assertNotEqual(done.stderr, "")
        self.assertFalse(self.out.exists())

    def test_wrong_command_lines(self):
        base = ("slice", self.scan, "-o", self.out)
        self.wrong()
        self.wrong("print", self.scan)
        self.wrong("slice")
        self.wrong("slice", self.scan)
        self.wrong(*base, "--what")
        for option, values in {
            "--pixel-pitch": ("0", "-0.05", "0.001", "2", "nan", "inf", "small", "0.05mm", ""),
            "--layer-height": ("0", "nan", "1.5"),
            "--scale": ("0", "-1", "nan", "inf", "1e9"),
            "--rotate-x": ("nan", "361"),
            "--units": ("parsec", "", "MM"),
            "--height": ("80m", "0", "-8cm", "tall", ""),
            "--floor": ("wood", "3mm", "nan", ""),
            "--orient": ("up", ""),
            "--keep-clean": ("y", "face", ""),
            "--threads": ("0", "65", "-1", "two", "1.5"),
            "--arena-mib": ("0", "-1", "lots"),
        }.items():
            for value in values:
                with self.subTest(option=option, value=value):
                    self.wrong(*base, f"{option}={value}")
        self.wrong(*base, "--fit")
        self.wrong(*base, "--printer", self.board, "--fit", "--scale", 2)
        self.wrong(*base, "--height", "8cm", "--scale", 2)
        self.wrong(*base, "--height", "8cm", "--width", "8cm")
        self.wrong(*base, "--orient", "auto", "--rotate-x", 90)
        self.wrong("orient", self.scan, "--rotate-x", 90)
        self.wrong(*base, "--keep-clean", "-y")
        self.wrong(*base, "--printer", self.board, "--pixel-pitch", 0.1)
        self.wrong("sample", self.dir / "x.ply", "--points", 10)
        self.wrong("sample", self.dir / "x.ply", "--seed", "-1")

    def says(self, *arguments, message):
        self.assertIn(message, self.run_it(*arguments, status=2).stderr)

    def test_unknown_subcommand_is_named_with_all_subcommands(self):
        every = "Subcommands are slice, inspect, orient, print, check, sample, status, ctl, simulate, setup, profile, doctor"
        self.says("foo", message=f"plumbline: 'foo' is not a subcommand. {every}")
        self.says("prnt", message=f"plumbline: 'prnt' is not a subcommand; did you mean print? {every}")
        self.says(message=f"plumbline: no subcommand given. {every}")

    def test_misspelt_option_is_named_with_the_nearest_one(self):
        base = ("slice", self.scan, "-o", self.out)
        self.says(*base, "--suports", "auto", message="plumbline slice: '--suports' is not an option; did you mean --supports?")
        self.says(*base, "--layer-hight=0.1", message="'--layer-hight' is not an option; did you mean --layer-height?")
        self.says("slice", self.scan, "--outptu", self.out, message="'--outptu' is not an option; did you mean --output?")
        self.says(*base, "--frobnicate", message="'--frobnicate' is not an option. 'plumbline slice --help-all' lists them.")

    def test_one_argument_too_many_is_named(self):
        self.says("sample", "a.ply", "b.ply", message="plumbline sample: 'b.ply' is one argument too many.")
        self.says("slice", *[self.scan] * 33, "-o", self.out, message="plumbline slice: too many files. A scan may have up to 32.")

    def test_a_refused_value_is_named_with_what_is_accepted(self):
        base = ("slice", self.scan, "-o", self.out)
        for option, value, message in (
            ("--layer-height", "50um", "'50um' is not a number from 0.005 to 1 mm; write it in mm, without a unit."),
            ("--layer-height", "0,05", "'0,05' is not a number from 0.005 to 1 mm; write it with a decimal point: 0.05."),
            ("--layer-height", "5", "'5' is not a number from 0.005 to 1 mm. "),
            ("--layer-height", "nan", "'nan' is not a number from 0.005 to 1 mm. "),
            ("--rotate-x", "90deg", "'90deg' is not a number from -360 to 360 degrees; write it in degrees, without a unit."),
            ("--scale", "2x", "'2x' is not a number from 1e-06 to 1000000; write the number alone."),
            ("--threads", "0", "'0' is not a whole number from 1 to 64. "),
            ("--units", "km", "'km' is not one of mm, cm, m, in, auto. "),
            ("--supports", "aut", "'aut' is not one of none, auto; did you mean auto? '"),
        ):
            with self.subTest(option=option, value=value):
                self.says(*base, f"{option}={value}", message=f"plumbline slice: {option}: {message}")
        self.says("sample", "a.ply", "--seed=-1", message="--seed: '-1' is not a whole number of at least 0. ")
        self.says("simulate", "--port", 80, message="--port: '80' is not a whole number from 1024 to 65535. ")

    def test_all_that_is_missing_is_named(self):
        self.says("slice", message="plumbline slice: --output and SCAN are required. 'plumbline slice --help'")
        self.says("inspect", message="plumbline inspect: SCAN is required. ")
        self.says("ctl", message="plumbline ctl: no subcommand given. Subcommands are start, pause, ")
        self.says("ctl", "strat", message="plumbline ctl: 'strat' is not a subcommand. Subcommands are start, pause, ")
        self.says("ctl", "set", message="plumbline ctl set: KEY and VALUE are required. 'plumbline ctl set --help'")
        self.says("ctl", "start", "--soket", "x", message="'--soket' is not an option; did you mean --socket?")

    def test_help_and_version(self):
        version = self.run_it("--version").stdout
        self.assertRegex(version, r"^plumbline \d+\.\d+\.\d+\n$")
        self.assertIn("plumbline sample bust.ply", self.run_it("--help").stdout)
        commands = ("slice", "inspect", "orient", "check", "print", "sample", "simulate", "setup", "doctor", "status", "ctl")
        for command in commands:
            text = self.run_it(command, "--help").stdout
            self.assertIn("Examples:", text)
            self.assertNotIn("Excludes", text)
            self.assertNotIn("....", text)
            self.assertLessEqual(max(map(len, text.splitlines())), 120, command)
        for command, help in (("slice", "--help-all"), ("inspect", "--help"), ("print", "--help-all"), ("sample", "--help"), ("doctor", "--help")):
            self.assertRegex(self.run_it(command, help).stdout, "Output:|Exit status:")

    def test_help_shows_a_dozen_options_with_a_line_each_and_help_all_the_rest(self):
        for command in ("slice", "print", "check"):
            text = self.run_it(command, "--help").stdout
            options = text.split("Options:\n")[1].split("\n\n")[0].splitlines()
            self.assertEqual(options[-1].split()[0], "--help-all")
            self.assertTrue(12 <= len(options) - 2 <= 13, options)
            for line in options:
                self.assertRegex(line, r"^  -\S+( [A-Z=]+)?( \(required\))?  +\S.*[^.]$")
                self.assertLessEqual(len(line), 120)
            self.assertLess(len(text.splitlines()), 40)
            self.assertRegex(text, r"--layer-height MM +Height of a layer, 0.005 to 1 mm \[0.05, or the printer's\]\n")
            self.assertIn(f"\nExamples:\n  plumbline {command} ", text)
            self.assertRegex(text.splitlines()[-1], f"^'plumbline {command} --help-all' lists all options")
            whole = self.run_it(command, "--help-all").stdout
            self.assertLessEqual(max(map(len, whole.splitlines())), 120)
            for line in options:
                self.assertIn(line.split()[0], whole)
            for option in ("--support-head-width", "--floor", "--arena-mib", "Exit status:"):
                self.assertNotIn(option, text)
                self.assertIn(option, whole)
        # It lists the option that this is about.
        self.says("slice", self.scan, "-o", self.out, "--threads=0", message="'plumbline slice --help-all' lists the options.")

    def test_help_names_each_kind_of_file_and_each_kind_of_issue(self):
        text = " ".join(self.run_it("slice", "--help-all").stdout.split())
        endings = (SOURCE_DIR / "slicer/reader/formats/scan_endings.hpp").read_text()
        for ending in re.findall(r'"\.(\w+)"', endings.split("kArchiveEndings")[0]):
            self.assertRegex(text.split("Options:")[0], rf"\b{ending.upper()}\b")
        self.assertIn("KIND is all, or one of island, overhang,", text)
        self.assertNotIn("Without it the grid", self.run_it("print", "--help-all").stdout)


if __name__ == "__main__":
    main()
