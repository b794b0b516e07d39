#!/usr/bin/env python3
"""The program plumbline as its users meet it: usage program_test.py PLUMBLINE SOURCE_DIR [unittest options]

Files, standard output, standard error, exit status, signals, memory. PNG files, hashes and JSON are read here with nothing of
plumbline's, so that a mistake on both sides would have to be made twice.
"""

import json
import math
import os
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

PLUMBLINE = ""
SOURCE_DIR = Path()
U64 = 2**64 - 1
STEP = 0x9E3779B97F4A7C15


def write_sphere(path, points=20_000, radius=12.0, normals=True):
    """A clean sphere round the origin: Fibonacci lattice, PLY, binary."""
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {points}"]
    head += [f"property float {name}" for name in ("x", "y", "z") + (("nx", "ny", "nz") if normals else ())]
    with open(path, "wb") as file:
        file.write(("\n".join(head + ["end_header"]) + "\n").encode())
        for i in range(points):
            z = 1 - 2 * (i + 0.5) / points
            r, angle = math.sqrt(1 - z * z), 2.39996322972865332 * i
            x, y = r * math.cos(angle), r * math.sin(angle)
            file.write(struct.pack("<3f", radius * x, radius * y, radius * z))
            if normals:
                file.write(struct.pack("<3f", x, y, z))


def write_board(path, arena_mib=64):
    """403 x 300 pixels of 0.1 mm, 50 mm high."""
    path.write_text(
        f'[printer]\nname = "small"\n[panel]\ncolumns = 403\nrows = 300\npixel_pitch_x_mm = 0.1\npixel_pitch_y_mm = 0.1\n'
        f"[z_stage]\ntravel_mm = 50.0\n[print]\nlayer_height_mm = 0.1\n[memory]\narena_mib = {arena_mib}\n"
    )


def png_rows(path):
    """Columns, and each row's bytes, of a 1-bit greyscale PNG without filters."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, stream, header = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            stream += body
        at += 12 + length
    columns, rows, depth, colour, _, _, interlace = header
    assert (depth, colour, interlace) == (1, 0, 0)
    raw, width = zlib.decompress(stream), (columns + 7) // 8
    assert len(raw) == rows * (width + 1) and not any(raw[:: width + 1])
    return columns, [raw[r * (width + 1) + 1 : (r + 1) * (width + 1)] for r in range(rows)]


def mix(z):
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & U64
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & U64
    return z ^ (z >> 31)


def layer_hash(columns, rows):
    """As the manifest's definition has it."""
    total, place = mix((columns << 32) + len(rows)), 0
    for row in rows:
        row += bytes(-len(row) % 8)
        for (word,) in struct.iter_unpack(">Q", row):
            place += STEP
            if word:
                total += mix((word + place) & U64)
    return mix(total & U64)


def job_hash(layers):
    h = mix(len(layers))
    for layer in layers:
        h = mix((h + STEP + layer) & U64)
    return h


class Program(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="plumbline-")
        self.addCleanup(folder.cleanup)
        self.dir = Path(folder.name)
        self.scan, self.board, self.out = self.dir / "sphere.ply", self.dir / "small.toml", self.dir / "out"
        write_board(self.board)

    def run_it(self, *arguments, status=0, **options):
        done = subprocess.run(
            [PLUMBLINE, *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False, **options
        )
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def slice_it(self, *arguments, **options):
        if not self.scan.exists():
            write_sphere(self.scan)
        return self.run_it("slice", self.scan, "-o", self.out, "--printer", self.board, *arguments, **options)

    def layers(self):
        return sorted(path.name for path in (self.out / "layers").iterdir())

    def manifest(self):
        return json.loads((self.out / "manifest.json").read_text())


class Slice(Program):
    def test_manifest_tells_what_the_files_are(self):
        self.slice_it("--threads", 2)
        manifest = self.manifest()
        grid = manifest["grid"]
        self.assertEqual((grid["columns"], grid["rows"]), (403, 300))
        self.assertEqual(grid["pixel_pitch_mm"], [0.1, 0.1])
        self.assertEqual(self.layers(), [f"{k:05}.png" for k in range(grid["layers"])])
        hashes, white = [], 0
        for name in self.layers():
            columns, rows = png_rows(self.out / "layers" / name)
            self.assertEqual((columns, len(rows)), (403, 300))
            hashes.append(layer_hash(columns, rows))
            white += sum(bin(byte).count("1") for row in rows for byte in row)
        self.assertEqual(manifest["hashes"]["layers"], [f"{h:016x}" for h in hashes])
        self.assertEqual(manifest["hashes"]["job"], f"{job_hash(hashes):016x}")
        self.assertAlmostEqual(manifest["volume_mm3"], white * 0.1**3, places=3)
        self.assertAlmostEqual(manifest["volume_mm3"] / (4 / 3 * math.pi * 12**3), 1, delta=0.005)
        self.assertEqual(sum(manifest["points"].values()), manifest["thinning"]["points_left"])
        decided = ("outside", "perfect", "repaired", "winding_number", "base_plane")
        self.assertEqual(sum(manifest["rays"][key] for key in decided), manifest["rays"]["interested"])

    def test_transform_and_origin_agree_with_each_other_and_with_the_object(self):
        self.slice_it("--rotate-x", 30, "--rotate-z", 250, "--scale", 0.75, "--no-preview")
        manifest = self.manifest()
        matrix, origin = manifest["transform"], manifest["grid"]["origin_mm"]
        printed = [sum(matrix[r][c] * origin[c] for c in range(3)) + matrix[r][3] for r in range(4)]
        for coordinate in printed[:3]:
            self.assertAlmostEqual(coordinate, 0, places=9)
        self.assertEqual(matrix[3], [0, 0, 0, 1])
        # The middle of the sphere stands over the middle of the panel, its radius above the plate.
        for found, wanted in zip([row[3] for row in matrix[:3]], (20.15, 15, 9)):
            self.assertAlmostEqual(found, wanted, delta=0.02)

    def test_masks_do_not_depend_on_the_number_of_threads(self):
        jobs = set()
        for threads in (1, 2, 3, 8):
            self.slice_it("--threads", threads, "--no-preview")
            jobs.add(json.dumps(self.manifest()["hashes"]))
        self.assertEqual(len(jobs), 1)

    def test_threads_come_from_openmp_where_nothing_is_said(self):
        self.slice_it("--no-preview", env={**os.environ, "OMP_NUM_THREADS": "3"})
        self.assertEqual(self.manifest()["threads"], 3)

    def test_supports_hold_the_sphere_and_are_told(self):
        self.slice_it("--no-preview")
        without = self.manifest()
        self.assertIsNone(without["supports"])
        done = self.slice_it("--supports", "auto", "--support-pillar-diameter", 1.5)
        manifest = self.manifest()
        supports = manifest["supports"]
        self.assertGreater(supports["count"], 4)  # the lower 45 degrees of a sphere of 12 mm
        self.assertEqual(supports["count"], supports["below_islands"] + supports["below_overhangs"])
        ends = ("on_plate", "on_object", "on_supports")
        self.assertEqual(supports["count"], sum(supports[key] for key in ends))
        self.assertAlmostEqual(manifest["volume_mm3"] - supports["volume_mm3"], without["volume_mm3"], places=3)
        self.assertEqual(supports["settings"]["support_pillar_diameter"], 1.5)
        self.assertEqual(supports["settings"]["support_critical_angle"], 45)
        self.assertIn(f"supports   {supports['count']}: ", done.stdout)
        self.assertEqual([line.split()[0] for line in done.stderr.splitlines()].count("supports"), 1)
        # Every pillar stands beside the sphere's foot: the lowest layer has more than the sphere's own.
        _, rows = png_rows(self.out / "layers" / "00000.png")
        white = sum(bin(byte).count("1") for row in rows for byte in row)
        self.assertGreater(white, supports["on_plate"] * 100)

    def test_print_cures_the_masks_that_slice_writes_supports_included(self):
        write_sphere(self.scan)
        same = ("--supports", "auto", "--printer", SOURCE_DIR / "board" / "sim2k.toml", "--scale", 0.5)
        self.run_it("slice", self.scan, "-o", self.out, "--no-preview", *same)
        sliced = self.manifest()
        self.assertGreater(sliced["supports"]["count"], 4)
        part, report, state = self.dir / "part", self.dir / "report.json", self.dir / "state"
        done = self.run_it("print", self.scan, *same, "--keep-part", part, "--report", report)
        self.assertIn(f"supports   {sliced['supports']['count']}\n", done.stdout)
        printed = json.loads(report.read_text())
        self.assertEqual((printed["state"], printed["objections"]), ("finished", []))
        self.assertEqual([line["mask_hash"] for line in printed["exposures"]], sliced["hashes"]["layers"])
        cured = json.loads((part / "manifest.json").read_text())
        self.assertEqual(cured["hashes"], sliced["hashes"])
        self.assertEqual(cured["supports"], sliced["supports"])
        # Without power, and without the scan: what is stored has the supports, too.
        cut = self.run_it("print", self.scan, *same, "--state", state, "--fault", "power.cut@layer=20", status=1)
        self.assertIn("PL-901", cut.stdout)
        self.run_it("print", "--resume", "--state", state, *same[2:4], "--report", report)
        resumed = json.loads(report.read_text())
        self.assertEqual((resumed["state"], resumed["supports"]), ("finished", sliced["supports"]["count"]))
        self.assertLessEqual(resumed["first_layer"], 20)
        hashes = [line["mask_hash"] for line in resumed["exposures"]]
        self.assertEqual(hashes, sliced["hashes"]["layers"][resumed["first_layer"] :])

    def test_support_settings_that_make_no_sense_are_refused(self):
        for arguments, message in (
            (("--support-base-diameter", 3), "--support-base-diameter is for --supports auto"),
            (("--supports", "auto", "--support-critical-angle", 81), "not a number from 10 to 80"),
            (("--supports", "auto", "--support-pillar-diameter", 5), "more than support_base_diameter"),
            (("--supports", "yes"), "yes"),
        ):
            done = self.slice_it(*arguments, status=2)
            self.assertIn(message, done.stderr)
            self.assertFalse(self.out.exists())

    def test_json_is_the_manifest_without_the_layers_and_nothing_else(self):
        done = self.slice_it("--json")
        told, manifest = json.loads(done.stdout), self.manifest()
        self.assertEqual(done.stderr, "")
        del manifest["hashes"]["layers"]
        self.assertEqual(told, manifest)

    def test_quiet_says_nothing(self):
        done = self.slice_it("--quiet")
        self.assertEqual((done.stdout, done.stderr), ("", ""))

    def test_report_goes_to_standard_output_and_a_line_for_each_stage_to_standard_error(self):
        done = self.slice_it()
        for word in ("sphere.ply: 20000 points", " mm", "403 x 300 px", "crossings", "MiB", "manifest.json"):
            self.assertIn(word, done.stdout)
        lines = done.stderr.splitlines()
        stages = [line.split()[0] for line in lines if "MiB" in line]
        for stage in ("read", "trees", "clustering", "rays", "layers"):
            self.assertEqual(stages.count(stage), 1)
        self.assertNotIn("\033", done.stderr)

    def test_older_job_is_replaced_whole(self):
        self.slice_it()
        before = len(self.layers())
        self.slice_it("--scale", 0.5)
        after = self.manifest()["grid"]["layers"]
        self.assertLess(after, before)
        self.assertEqual(len(self.layers()), after)

    def test_directory_with_something_else_is_left_alone(self):
        self.out.mkdir()
        (self.out / "thesis.doc").write_text("years of work")
        done = self.slice_it(status=1)
        self.assertIn("holds 'thesis.doc'", done.stderr)
        self.assertEqual([path.name for path in self.out.iterdir()], ["thesis.doc"])

    def test_fit_makes_it_as_large_as_the_printer_takes(self):
        self.slice_it("--fit", "--no-preview")
        self.assertAlmostEqual(max(self.manifest()["size_mm"][:2]), 29.8, delta=0.1)

    def test_what_does_not_fit_is_told_with_the_scale_that_does(self):
        done = self.slice_it("--scale", 2, status=1)
        self.assertRegex(done.stderr, r"sphere\.ply: the object is 4\d\.\d+ mm .* Use --scale 1\.2")

    def test_units_are_guessed_on_request_and_said_so(self):
        write_sphere(self.scan, radius=0.012)
        done = self.slice_it("--units", "auto")
        self.assertIn("warning: units guessed", done.stderr)
        manifest = self.manifest()
        self.assertEqual(manifest["units"], {"used": "m", "guessed": True})
        self.assertAlmostEqual(manifest["size_mm"][2], 24, delta=0.1)

    def test_small_object_gets_a_hint(self):
        write_sphere(self.scan, radius=1)
        self.assertIn("warning: the object is only 2 mm long", self.slice_it().stderr)

    @unittest.skipIf("PLUMBLINE_SANITIZED" in os.environ, "a sanitizer's memory is not the program's")
    def test_peak_memory_is_the_arena_and_16_mib(self):
        write_sphere(self.scan, points=100_000)
        arena_mib = 16
        child = subprocess.Popen(
            [PLUMBLINE, "slice", self.scan, "-o", self.out, "--printer", self.board, "--quiet", "--arena-mib", str(arena_mib)]
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(child.returncode, 0)
        manifest = self.manifest()
        self.assertEqual(manifest["arena"]["bytes"], arena_mib << 20)
        self.assertLessEqual(manifest["arena"]["peak_bytes"], arena_mib << 20)
        print(f"peak resident {usage.ru_maxrss / 1024:.1f} MiB with an arena of {arena_mib} MiB")
        self.assertLessEqual(usage.ru_maxrss / 1024, arena_mib + 16)


class Interrupted(Program):
    def interrupt(self, number):
        write_sphere(self.scan, points=100_000)
        arguments = ["slice", self.scan, "-o", self.out, "--pixel-pitch", "0.01", "--layer-height", "0.01"]
        child = subprocess.Popen([PLUMBLINE, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in child.stderr:  # not before the signal is caught: a stage has ended
            if line.split()[0] == "read":
                break
        child.send_signal(number)
        _, rest = child.communicate(timeout=120)
        self.assertEqual(child.returncode, 130, rest)
        self.assertIn("interrupted; nothing of this job was left in", rest)
        self.assertFalse(self.out.exists())

    def test_by_the_user(self):
        self.interrupt(signal.SIGINT)

    def test_by_the_system(self):
        self.interrupt(signal.SIGTERM)


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
        self.refused("slice", self.dir, "-o", self.out, message=".*: is a directory. Name the scan in it")

    def test_file_that_is_no_scan(self):
        self.scan.write_bytes(bytes(range(256)) * 10)
        self.refused("slice", self.scan, "-o", self.out, message="sphere.ply: ")
        self.assertFalse(self.out.exists())

    def test_empty_file(self):
        self.scan.write_bytes(b"")
        self.refused("slice", self.scan, "-o", self.out, message="sphere.ply: ")

    def test_output_that_cannot_be_made(self):
        write_sphere(self.scan)
        self.refused("slice", self.scan, "-o", "/proc/plumbline", message="/proc/plumbline: the directory cannot be created")
        self.refused("slice", self.scan, "-o", self.scan, message=".*sphere.ply: is a file, the output needs a directory")

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_output_that_may_not_be_written(self):
        write_sphere(self.scan)
        self.out.mkdir(mode=0o555)
        self.refused("slice", self.scan, "-o", self.out, message=".*out/layers: the directory cannot be created: Permission")

    def test_medium_that_fills_up_leaves_nothing_behind(self):
        # No file may grow beyond a limit: for write() that is a full disk, and it can be had without one.
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
        self.refused("slice", self.scan, "-o", self.out, "--printer", self.dir / "no.toml", message=".*no.toml: No such file")
        self.board.write_text("[printer]\nnaem = 'x'\n")
        self.refused("slice", self.scan, "-o", self.out, "--printer", self.board, message=".*small.toml:2: .*naem")

    def test_more_arena_than_was_built_in(self):
        write_sphere(self.scan)
        self.refused("slice", self.scan, "-o", self.out, "--arena-mib", 1048576, message="an arena of 1048576 MiB is asked for")
        write_board(self.board, arena_mib=65536)
        self.refused("slice", self.scan, "-o", self.out, "--printer", self.board, message="an arena of 65536 MiB .* board file")

    def test_arena_that_no_job_fits_in(self):
        write_sphere(self.scan)
        arguments = ("slice", self.scan, "-o", self.out, "--printer", SOURCE_DIR / "board/mono2k.toml", "--arena-mib", 8)
        self.refused(*arguments, message="the job cannot fit: the stage '.*' needs .* MiB")


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
            "--threads": ("0", "65", "-1", "two", "1.5"),
            "--arena-mib": ("0", "-1", "lots"),
        }.items():
            for value in values:
                with self.subTest(option=option, value=value):
                    self.wrong(*base, f"{option}={value}")
        self.wrong(*base, "--fit")
        self.wrong(*base, "--printer", self.board, "--fit", "--scale", 2)
        self.wrong(*base, "--printer", self.board, "--pixel-pitch", 0.1)
        self.wrong("sample", self.dir / "x.ply", "--points", 10)
        self.wrong("sample", self.dir / "x.ply", "--seed", "-1")

    def test_help_and_version(self):
        version = self.run_it("--version").stdout
        self.assertRegex(version, r"^plumbline \d+\.\d+\.\d+\n$")
        self.assertIn("plumbline sample bust.ply", self.run_it("--help").stdout)
        for command in ("slice", "inspect", "sample"):
            text = self.run_it(command, "--help").stdout
            self.assertIn("Examples:", text)
            self.assertIn("What comes out:", text)


class Inspect(Program):
    def test_measures_what_was_put_in(self):
        write_sphere(self.scan, points=20_000, radius=12)
        done = self.run_it("inspect", self.scan, "--printer", self.board, "--json")
        self.assertEqual(done.stderr, "")
        told = json.loads(done.stdout)
        self.assertEqual(told["scan"]["points"], 20_000)
        self.assertEqual(told["scan"]["normals"], {"have": 20_000, "missing": 0, "zero_length": 0})
        for side in told["size_mm"]:
            self.assertAlmostEqual(side, 24, delta=0.05)
        # On a Fibonacci lattice the nearest point is 0.9 to 1 times the root of a point's area away.
        self.assertAlmostEqual(told["spacing_mm"] / math.sqrt(4 * math.pi * 12**2 / 20_000), 0.95, delta=0.1)
        self.assertLess(told["noise_mm"], 0.02)
        self.assertEqual(told["units"], {"used": "mm", "guess": "mm"})
        self.assertTrue(told["fits"])
        self.assertAlmostEqual(told["largest_scale"], 29.8 / 24, delta=0.01)
        self.assertFalse(self.out.exists())

    def test_tells_noise_from_surface(self):
        write_sphere(self.scan, points=20_000, radius=12)
        data = bytearray(self.scan.read_bytes())
        start = data.index(b"end_header\n") + 11
        state = 1
        for i in range(20_000):  # moves each point along its normal by a triangular noise of standard deviation 0.1 mm
            total = 0.0
            for _ in range(2):
                state = (state * 6364136223846793005 + 1442695040888963407) & U64
                total += (state >> 11) / 2**53 - 0.5
            shift = total * 0.1 * math.sqrt(6)
            at = start + 24 * i
            values = struct.unpack("<6f", data[at : at + 24])
            struct.pack_into("<3f", data, at, *(values[a] + shift * values[3 + a] for a in range(3)))
        self.scan.write_bytes(data)
        told = json.loads(self.run_it("inspect", self.scan, "--json").stdout)
        # Of a triangular distribution the median distance from its middle is sqrt(6) (1 - sqrt(1/2)) = 0.717 of its deviation.
        self.assertAlmostEqual(told["noise_mm"], 0.0717, delta=0.015)

    def test_speaks_to_people_too(self):
        write_sphere(self.scan)
        done = self.run_it("inspect", self.scan, "--printer", self.board, "--scale", 3)
        for word in ("20000 points", "normals", "spacing", "noise", "MiB", "fits       no", "up to scale 1.2"):
            self.assertIn(word, done.stdout)

    def test_says_that_normals_are_missing(self):
        write_sphere(self.scan, normals=False)
        told = json.loads(self.run_it("inspect", self.scan, "--json").stdout)
        self.assertEqual(told["scan"]["normals"], {"have": 0, "missing": 20_000, "zero_length": 0})

    def test_thins_a_scan_to_the_arena(self):
        write_sphere(self.scan, points=100_000)
        told = json.loads(self.run_it("inspect", self.scan, "--json", "--arena-mib", 4, "--threads", 1).stdout)
        self.assertLess(told["thinning"]["points_left"], 100_000)
        self.assertGreater(told["thinning"]["cell_mm"], 0)
        self.assertLessEqual(told["thinning"]["points_left"], told["thinning"]["room_for_points"])


class Sample(Program):
    def test_is_a_scan_that_can_be_inspected(self):
        path = self.dir / "bust.ply"
        self.run_it("sample", path, "--points", 5000, "--seed", 3)
        told = json.loads(self.run_it("inspect", path, "--json").stdout)
        self.assertEqual(told["scan"]["points"], 5000)

    def test_cannot_be_written_where_no_folder_is(self):
        done = self.run_it("sample", self.dir / "no/bust.ply", status=1)
        self.assertIn("no/bust.ply", done.stderr)


if __name__ == "__main__":
    PLUMBLINE, SOURCE_DIR = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
