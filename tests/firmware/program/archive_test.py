#!/usr/bin/env python3
"""Archives of sliced prints, .sl1: what `plumbline slice` writes."""

import configparser
import json
import re
import shutil
import subprocess
import unittest
import zipfile

from case import SIM2K, SOURCE_DIR, Program, grey_layer_hash, main, png_depth, png_rows, write_sphere


def settings(archive, name):
    parser = configparser.ConfigParser()
    parser.optionxform = str
    parser.read_string("[top]\n" + archive.read(name).decode())
    return dict(parser["top"])


def layers_of(archive):
    """
    The layers that PrusaSlicer 2.9 reads (ZipperArchiveImport.cpp: its names are compared in lower case): they hold "png" or "ini" and
    not "thumbnail", in the order of their names.
    """
    names = sorted(name.lower() for name in archive.namelist())
    read = [name for name in names if ("png" in name or "ini" in name) and "thumbnail" not in name]
    return [name for name in read if name not in ("config.ini", "prusaslicer.ini")]


def bits_of(line):
    """A line of bytes, 0 or 255, as bits of whole bytes."""
    bits = line.translate(bytes.maketrans(b"\0\xff", b"01")).ljust(-(-len(line) // 8) * 8, b"0")
    return int(bits, 2).to_bytes(len(bits) // 8, "big")


# What UVtools makes of a key (SL1File.cs): its words, each with a large first letter and without the underscores between them, are the name
# of a member of any of its four groups of settings; a value that is no number of the member's type ends the import. Other keys it passes
# over, and members of text take anything.
UVTOOLS_WHOLE = {"DisplayMirrorX": 255, "DisplayMirrorY": 255, "SupportsEnable": 255, "PadEnable": 255, "Hollow": 255, "FadedLayers": 65535,
                 "NumFade": 65535, "NumSlow": 65535, "NumFast": 2**32 - 1, "DisplayPixelsX": 2**32 - 1, "DisplayPixelsY": 2**32 - 1}  # fmt: skip
UVTOOLS_FLOAT = {"MaxPrintHeight", "DisplayWidth", "DisplayHeight", "BottleCost", "BottleVolume", "BottleWeight", "MaterialDensity",
                 "InitialLayerHeight", "ExposureTime", "InitialExposureTime", "LayerHeight", "ExpTime", "ExpTimeFirst", "ExpUserProfile", "PrintTime",
                 "UsedMaterial"}  # fmt: skip


def read_as_uvtools(archive):
    """Members and their values, the layers by number, and the thumbnails' sizes."""
    members, layers, thumbnails = {}, {}, []
    names = [name.rsplit("/", 1)[-1] for name in archive.namelist()]
    for path, name in zip(archive.namelist(), names):
        if name.endswith(".ini"):
            for line in archive.read(path).decode().splitlines():
                key, equals, value = (part.strip() for part in line.partition("="))
                if not equals:
                    continue
                member = "".join(word[:1].upper() + word[1:] for word in key.split("_"))
                if member in UVTOOLS_WHOLE:
                    if not re.fullmatch(r"\d+", value) or int(value) > UVTOOLS_WHOLE[member]:
                        raise ValueError(f"{name}: {line}: is no whole number up to {UVTOOLS_WHOLE[member]}")
                    value = int(value)
                elif member in UVTOOLS_FLOAT:
                    if not re.fullmatch(r"-?\d+(\.\d+)?([eE][-+]?\d+)?", value):
                        raise ValueError(f"{name}: {line}: is no number")
                    value = float(value)
                members[member] = value
        elif name.endswith(".png"):
            png = archive.read(path)
            size = int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")
            if name.startswith("thumbnail"):
                thumbnails.append(size)
            else:
                layers[int(name[-9:-4])] = size  # five digits
    for needed in ("config.ini", "prusaslicer.ini"):
        if needed not in names:
            raise ValueError(f"{needed} is missing")
    return members, layers, thumbnails


class WrittenArchive(Program):
    def slice_sphere(self, out, *options, **kwargs):
        if not self.scan.exists():
            write_sphere(self.scan, points=10_000, radius=6)
        same = ("--printer", SIM2K, "--layer-height", 0.2, "--threads", 2)
        return self.run_it("slice", self.scan, "-o", out, *same, *options, **kwargs)

    def test_masks_are_those_of_the_folder(self):
        part = self.dir / "part.sl1"
        self.slice_sphere(self.out, "--no-preview")
        done = self.slice_sphere(part)
        self.assertIn(f"written    {part}", done.stdout)
        self.assertFalse((self.dir / "part.sl1.part").exists())
        with zipfile.ZipFile(part) as archive:
            self.assertIsNone(archive.testzip())
            layers = layers_of(archive)
            self.assertGreater(len(layers), 50)
            self.assertEqual(layers, [f"layer{k:05}.png" for k in range(len(layers))])
            self.assertEqual(len(layers), len(self.layers()))
            for ours, theirs in list(zip(self.layers(), layers))[::8]:
                # PrusaSlicer takes nothing but 8-bit grey: PNGReadWrite.cpp, decode_png().
                columns, lines = png_rows(archive.read(theirs), bits=8)
                width, folder = png_rows((self.out / "layers" / ours).read_bytes())
                self.assertEqual((columns, [bits_of(line) for line in lines]), (width, folder), ours)
        subprocess.run(["unzip", "-tq", part], check=True, stdout=subprocess.DEVNULL)

    def test_has_the_settings_and_thumbnails_of_its_printer(self):
        part = self.dir / "part.SL1S"
        self.slice_sphere(part)
        with zipfile.ZipFile(part) as archive:
            config, prusa = settings(archive, "config.ini"), settings(archive, "prusaslicer.ini")
            count = len(layers_of(archive))
            for size in ("400x400", "800x480"):
                png = archive.read(f"thumbnail/thumbnail{size}.png")
                wide, tall = map(int, size.split("x"))
                self.assertEqual(png[16:24], wide.to_bytes(4, "big") + tall.to_bytes(4, "big"))
        self.assertEqual((config["action"], config["layerHeight"], config["jobDir"]), ("print", "0.2", "layer"))
        self.assertEqual((config["expTime"], config["expTimeFirst"], config["numFade"]), ("2.5", "30", "8"))
        self.assertEqual(int(config["numFast"]) + int(config["numSlow"]), count)
        self.assertAlmostEqual(float(config["usedMaterial"]), 4 / 3 * 3.14159 * 0.6**3, delta=0.3)  # and supports
        self.assertGreater(float(config["printTime"]), 600)
        # What PrusaSlicer's reader can't do without: SL1.cpp, get_raster_params(), and SLAArchiveReader.cpp, get_slice_params().
        self.assertEqual((prusa["display_pixels_x"], prusa["display_pixels_y"]), ("1440", "2560"))
        self.assertEqual((prusa["display_width"], prusa["display_height"]), ("68.04", "120.96"))
        self.assertEqual((prusa["display_mirror_x"], prusa["display_mirror_y"]), ("0", "1"))
        self.assertEqual((prusa["display_orientation"], prusa["printer_technology"]), ("landscape", "SLA"))
        self.assertEqual((prusa["layer_height"], prusa["initial_layer_height"]), ("0.2", "0.2"))

    @unittest.skipUnless(shutil.which("prusa-slicer"), "needs prusa-slicer")
    def test_prusaslicer_takes_its_settings(self):
        part, ini, saved = self.dir / "part.sl1", self.dir / "prusaslicer.ini", self.dir / "saved.ini"
        self.slice_sphere(part, "--no-preview")
        with zipfile.ZipFile(part) as archive:
            ini.write_bytes(archive.read("prusaslicer.ini"))
            ours = settings(archive, "prusaslicer.ini")
        subprocess.run(["prusa-slicer", "--loglevel", "1", "--load", ini, "--save", saved], check=True, capture_output=True)
        theirs = dict(re.findall(r"^(\S+) = (.*)$", saved.read_text(), re.MULTILINE))
        self.assertEqual({key: theirs.get(key) for key in ours}, ours)

    def test_uvtools_reads_it(self):
        part = self.dir / "part.sl1"
        self.slice_sphere(part)
        with zipfile.ZipFile(part) as archive:
            members, layers, thumbnails = read_as_uvtools(archive)
        # It makes as many layers as the settings say, and each must come: from 0 on, as large as the panel.
        panel = members["DisplayPixelsX"], members["DisplayPixelsY"]
        self.assertEqual(panel, (1440, 2560))
        self.assertEqual(layers, {k: panel for k in range(members["NumSlow"] + members["NumFast"])})
        self.assertEqual(thumbnails, [(400, 400), (800, 480)])  # any other size counts as the larger one
        # What it shows and takes over into other printers' files.
        self.assertEqual((members["DisplayWidth"], members["DisplayHeight"]), (68.04, 120.96))
        self.assertEqual((members["DisplayMirrorX"], members["DisplayMirrorY"]), (0, 1))
        self.assertEqual((members["LayerHeight"], members["ExpTime"], members["ExpTimeFirst"], members["NumFade"]), (0.2, 2.5, 30, 8))
        self.assertGreater(members["MaxPrintHeight"], len(layers) * 0.2)
        self.assertTrue(members["PrinterSettingsId"] and members["MaterialName"])
        self.assertGreater(min(members["PrintTime"], members["UsedMaterial"]), 0)

    def test_same_scan_makes_the_same_bytes(self):
        first, second = self.dir / "first.sl1", self.dir / "second.sl1"
        self.slice_sphere(first)
        self.slice_sphere(second)
        self.assertEqual(first.read_bytes(), second.read_bytes())

    def levels_of(self, png):
        """Depth, and lines of a byte a pixel."""
        if png_depth(png) == 8:
            return 8, png_rows(png, bits=8)[1]
        columns, rows = png_rows(png)
        bits = (f"{int.from_bytes(row, 'big'):0{8 * len(row)}b}"[:columns] for row in rows)
        return 1, [line.encode().translate(bytes.maketrans(b"01", b"\0\xff")) for line in bits]

    def hashes_of_print(self, *arguments):
        report = self.dir / "report.json"
        self.run_it("print", *arguments, "--printer", SIM2K, "--report", report)
        printed = json.loads(report.read_text())
        self.assertEqual(printed["objections"], [])
        return [line["mask_hash"] for line in printed["exposures"]]

    def test_grey_layers_are_printed_as_those_of_the_scan(self):
        write_sphere(self.scan, points=10_000, radius=2)
        shares = [self.grey_share_of_a_print(kind) for kind in ("vertical", "full")]
        self.assertLess(1.4 * shares[0], shares[1], "pixels on the wall")

    def grey_share_of_a_print(self, kind):
        """Of the layers' pixels that are not black."""
        part, same = self.dir / "part.sl1", ("--layer-height", 0.1, "--grey", kind)
        done = self.run_it("slice", self.scan, "-o", self.out, "--printer", SIM2K, "--no-preview", *same)
        self.assertIn("grey       where the object begins", done.stdout)
        self.run_it("slice", self.scan, "-o", part, "--printer", SIM2K, "--no-preview", *same)
        manifest = self.manifest()
        self.assertEqual(manifest["grey"], kind)
        hashes = manifest["hashes"]["layers"]
        with zipfile.ZipFile(part) as archive:
            packed = [archive.read(name) for name in layers_of(archive)]
        self.assertEqual(len(packed), len(self.layers()))
        found, depths, grey, lit = set(), [], 0, 0
        for k, name in enumerate(self.layers()):
            depth, lines = self.levels_of((self.out / "layers" / name).read_bytes())
            levels = set().union(*(line for line in lines if line.strip(b"\0"))) - {0, 255}
            self.assertEqual(depth, 8 if levels else 1, name)
            self.assertEqual(self.levels_of(packed[k]), (8, lines), name)
            if k % 4 == 0:
                self.assertEqual(f"{grey_layer_hash(1440, lines):016x}", hashes[k], name)
            found |= levels
            depths.append(depth)
            lit += sum(len(line) - line.count(0) for line in lines)
            grey += sum(len(line) - line.count(0) - line.count(255) for line in lines)
        self.assertGreater(len(found), 20)
        self.assertTrue(min(found) < 64 < 192 < max(found), found)
        self.assertEqual(set(depths), {1, 8})
        self.assertEqual(self.hashes_of_print(self.scan, *same), hashes)
        self.assertEqual(self.hashes_of_print(part), hashes)
        for masks in (part, self.out):
            self.assertIn("found      no issues", self.run_it("check", masks, "--printer", SIM2K).stdout)
        return grey / lit

    def test_grey_is_the_profile_s_unless_it_is_asked_for(self):
        write_sphere(self.scan, points=5_000, radius=3)
        (self.dir / "profiles").mkdir()
        board, profile = self.dir / "grey.toml", self.dir / "profiles" / "mine.toml"
        board.write_text(SIM2K.read_text().replace('"sim2k" ', '"grey" ').replace('"standard"', '"mine"'))
        standard = (SOURCE_DIR / "board/profiles/standard.toml").read_text().replace('name = "standard"', 'name = "mine"')
        profile.write_text(standard.replace('grey = "off"', 'grey = "vertical"'))

        def sliced(*arguments, printer=board):
            self.run_it("slice", self.scan, "-o", self.out, "--printer", printer, "--layer-height", 0.2, "--no-preview", *arguments)
            files = [(self.out / "layers" / name).read_bytes() for name in self.layers()]
            return self.manifest()["grey"], {png_depth(file) for file in files}, files

        self.assertEqual(sliced()[:2], ("vertical", {1, 8}))
        off = sliced("--grey", "off")
        self.assertEqual(off[:2], ("off", {1}))
        self.assertEqual(sliced(printer=SIM2K), off)
        black_and_white = self.dir / "bw.toml"
        lines = [line for line in board.read_text().splitlines() if not line.startswith("grey_")]
        black_and_white.write_text("\n".join(lines).replace('"grey" ', '"bw" ') + "\n")
        self.assertEqual(sliced(printer=black_and_white), off, "its panel can't show the profile's grey")

        def refused(*arguments):
            return [self.run_it(*command, *arguments, "--grey", kind, status=1).stderr for kind in ("vertical", "full") for command in (
                ("slice", self.scan, "-o", self.dir / "new"), ("print", self.scan))]  # fmt: skip

        for said in refused("--printer", black_and_white):
            self.assertIn("bw.toml shows black and white only. Leave it out, or give [panel] grey_exposures", said)
        profile.write_text(standard.replace("exchange = 0.0", ""))
        for said in refused("--printer", board):
            self.assertIn("the profile mine has no exchange in [resin], which says what light cures. Add it, or leave out --grey", said)
        done = self.run_it("slice", self.scan, "-o", self.dir / "new", "--grey", "vertical", status=1)
        self.assertIn("--grey vertical: grey is made for a printer's panel. Name the printer with --printer", done.stderr)
        self.assertFalse((self.dir / "new").exists())

    def test_a_job_that_fails_leaves_the_older_file(self):
        part = self.dir / "part.sl1"
        part.write_text("older")
        self.slice_sphere(part, "--check", "all=refuse", "--supports", "none", status=1)
        self.assertEqual(part.read_text(), "older")
        self.assertFalse((self.dir / "part.sl1.part").exists())

    def test_says_what_is_missing(self):
        write_sphere(self.scan)
        done = self.run_it("slice", self.scan, "-o", self.dir / "part.sl1", status=1)
        self.assertIn("part.sl1: an .sl1 archive is made for a printer's panel. Name the printer with --printer", done.stderr)
        done = self.slice_sphere(self.dir / "nowhere" / "part.sl1", status=1)
        self.assertIn("part.sl1: cannot be created: No such file or directory", done.stderr)
        folder = self.dir / "folder.sl1"
        folder.mkdir()
        done = self.slice_sphere(folder, status=1)
        self.assertIn("folder.sl1: exists and is not a file. Choose another name", done.stderr)


if __name__ == "__main__":
    main()
