#!/usr/bin/env python3
"""
Archives of every slicer with settings from a generator that knows what they say: plumbline reads each value, or refuses the archive.

PLUMBLINE_PRINT_ALL=1 prints all that are complete; otherwise a few are printed, and all are inspected.
"""

import json
import os
import random
import subprocess
import unittest
import zipfile

from case import PLUMBLINE, SIM2K, Program, main
from sliced_test import png

ARCHIVES, COLUMNS, ROWS = 200, 64, 96
WIDTH, DEPTH = COLUMNS * 0.1, ROWS * 0.1


def square_mask():
    row = b"\0" + bytes(20) + b"\xff" * 24 + bytes(20)
    return png(COLUMNS, ROWS, bytes(COLUMNS + 1) * 30 + row * 30 + bytes(COLUMNS + 1) * 36)


MASK = square_mask()


class Style:
    """How a slicer, a country or an editor writes text."""

    def __init__(self, rng):
        self.rng = rng
        self.separator = rng.choice(("=", " = ", ":", ": "))
        self.case = rng.choice((str, str, str.upper, str.lower))
        self.comma = rng.random() < 0.25
        self.units = rng.random() < 0.3
        self.encoding = rng.choice(("utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"))
        self.line_end = rng.choice(("\n", "\r\n"))

    def number(self, value, unit=""):
        text = f"{value:.6g}"
        if self.comma:
            text = text.replace(".", ",")
        return text + (self.rng.choice((unit, " " + unit)) if self.units and unit else "")

    def lines(self, pairs, before="", after=""):
        pairs = list(pairs)
        self.rng.shuffle(pairs)
        return [f"{before}{self.case(key)}{self.separator}{value}{after}" for key, value in pairs]

    def encode(self, text):
        if self.encoding == "utf-16-be" and self.rng.random() < 0.5:
            return b"\xfe\xff" + text.encode("utf-16-be")
        return text.encode(self.encoding)

    def text(self, lines):
        return self.encode(self.line_end.join(lines) + self.line_end)

    def json(self, value):
        return self.encode(json.dumps(value, indent=self.rng.choice((None, 2))))


UNITS = {"layer_height": "mm", "initial_layer_height": "mm", "exposure_time": "s", "initial_exposure_time": "s", "lift_height": "mm",
         "lift_speed": "mm/min", "retract_speed": "mm/min"}  # fmt: skip


class Archive:
    """Settings, and the files that say them."""

    def __init__(self, seed):
        self.rng = rng = random.Random(seed)
        self.layers = rng.randint(6, 14)
        exposure = round(rng.uniform(6, 12), 2)
        self.values = {
            "layer_height": rng.randint(3, 10) / 100,
            "exposure_time": exposure,
            "initial_exposure_time": round(rng.uniform(exposure, 16), 1),
            "bottom_layer_count": rng.randint(1, 6),
            "faded_layers": rng.randint(0, 5),
            "lift_height": rng.randint(4, 16) / 2,
            "lift_speed": rng.randint(40, 240),
            "retract_speed": rng.randint(40, 240),
        }
        self.said = {}  # what plumbline must find
        self.files, self.style = {}, Style(rng)
        self.fault = rng.choice((None,) * 8 + ("count", "range", "twice", "regions"))
        self.declared = self.layers + (rng.choice((-1, 1, 5)) if self.fault == "count" else 0)
        if self.fault == "range":
            self.values["exposure_time"] = rng.choice((0, 121, 4000))
        self.maker = rng.choice((self.sl1, self.chitubox, self.cws, self.slicing, self.klipper, self.nanodlp, self.uvj))
        # A third leave something out.
        self.silent = set(rng.sample(sorted(self.values), rng.randint(1, 3))) if rng.random() < 0.33 and not self.fault else set()
        self.ending = rng.choice(("zip", "cws", "uvj", "nanodlp", "sl1", "SL1S"))
        self.maker()

    def say(self, *keys):
        """The values of some keys that are not left out; they must be found."""
        kept = {key: self.values[key] for key in keys if key not in self.silent}
        self.said.update(kept)
        return kept

    def pairs(self, names, units=UNITS, factors=None):
        factors = factors or {}
        return [(names[key], self.style.number(value * factors.get(key, 1), units.get(key, "")))
                for key, value in self.say(*names).items()]

    def without_ramp(self):
        if "bottom_layer_count" in self.said or "initial_exposure_time" in self.said:
            self.said.setdefault("faded_layers", 0)

    def lifts_once(self):
        """A slicer that knows only one lift says that there is no second."""
        if "lift_height" in self.said:
            self.said["lift_height2"] = 0
        if "retract_speed" in self.said:
            self.said["retract_height2"] = 0

    def layer_exposures(self):
        """The exposure of each layer, with a ramp that only they say; none: the slicer writes none."""
        if not self.is_complete() or self.fault or self.rng.random() < 0.4:
            return []
        if self.values["initial_exposure_time"] < self.values["exposure_time"] + 1:
            return []
        self.said["faded_layers"] = self.values["faded_layers"]
        if self.said["bottom_layer_count"] + self.said["faded_layers"] >= self.layers:
            self.said["faded_layers"] = 0
        return [round(seconds, 3) for seconds in self.exposures()]

    def add_layers(self, pattern, first):
        for k in range(self.layers):
            self.files[pattern.format(k + first)] = MASK

    def twice(self, lines, key, name):
        if self.fault == "twice":
            lines.append(f"{name}={self.values[key] / 2:g}")
        return lines

    def sl1(self):
        names = {"layer_height": "layerHeight", "exposure_time": "expTime", "initial_exposure_time": "expTimeFirst", "faded_layers": "numFade"}
        slow = self.rng.randint(0, self.layers - 1)
        pairs = self.pairs(names) + [("numFast", self.declared - slow), ("numSlow", slow), ("jobDir", "a:b=c")]
        if self.fault == "regions":
            pairs.append(("calibrateRegions", 4))
        self.files["config.ini"] = self.style.text(self.twice(self.style.lines(pairs), "layer_height", "layerHeight"))
        self.said["bottom_layer_count"] = 3
        if self.rng.random() < 0.8:
            initial = self.rng.randint(3, 10) / 100
            self.said["initial_layer_height"] = initial
            other = [("exposure_time", 3), ("layer_height", 0.2), ("faded_layers", 17), ("initial_layer_height", self.style.number(initial))]
            other += [("display_width", WIDTH), ("display_height", DEPTH), ("display_mirror_x", 1), ("display_orientation", "landscape")]
            self.files["prusaslicer.ini"] = self.style.text(f"{key} = {value}" for key, value in other)
            self.files["thumbnail/thumbnail400x400.png"] = MASK
        self.add_layers("part{:05}.png", 0)

    def chitubox(self):
        bottom = self.rng.choice(("bottomLayExposureTime", "bottomLayerExposureTime"))
        names = {"layer_height": "layerHeight", "exposure_time": "normalExposureTime", "initial_exposure_time": bottom,
                 "bottom_layer_count": "bottomLayerCount", "lift_height": "normalLayerLiftHeight",
                 "lift_speed": "normalLayerLiftSpeed", "retract_speed": "normalDropSpeed"}  # fmt: skip
        pairs = self.pairs(names) + [("totalLayer", self.declared), ("machineX", WIDTH), ("resolutionX", COLUMNS), ("volume", 3)]
        if self.fault == "regions":
            pairs.append(("PWMLight", 100))
        lines = self.twice(self.style.lines(pairs, ";"), "layer_height", ";layerHeight")
        lines += [";START_GCODE_BEGIN", "G21", "M106 S0", "G4 P300;"]
        self.without_ramp()
        for k, seconds in enumerate(self.layer_exposures()):
            lines += [f";LAYER_START:{k}", "G0 Z5 F60;lift", "M106 S255;light on", f"G4 P{1000 * seconds:.0f};", "M106 S0", "G4 P500"]
        self.files["run.gcode"] = self.style.text(lines)
        self.lifts_once()
        self.files["preview.png"] = self.files["preview_cropping.png"] = MASK
        self.add_layers("{}.png", 1)

    CWS = {"layer_height": "Layer Thickness", "exposure_time": "Layer Time", "initial_exposure_time": "Bottom Layers Time",
           "bottom_layer_count": "Number of Bottom Layers", "lift_height": "Lift Distance", "lift_speed": "Z Lift Feed Rate",
           "retract_speed": "Z Lift Retract Rate"}  # fmt: skip
    MS = {"exposure_time": 1000, "initial_exposure_time": 1000}

    def cws(self):
        units = {**UNITS, "exposure_time": "ms", "initial_exposure_time": "ms", "lift_speed": "mm/s", "retract_speed": "mm/s"}
        lines = self.style.lines(self.pairs(self.CWS, units, self.MS), ";(", " )")
        lines += self.style.lines([("Number of Slices", self.declared), ("Pix per mm X", "10 px/mm"), ("X Resolution", COLUMNS)], ";")
        if self.fault == "regions":
            lines.append(";(Layer Light PWM = 100)")
        self.twice(lines, "layer_height", ";Layer Thickness")
        self.files["part.gcode"] = self.style.text(lines + ["G28", ";<Slice> 0", ";<Delay> 9000"])
        self.files["slice.conf"] = b"thickness = 0.033\n" if "layer_height" not in self.silent else b""
        self.without_ramp()
        self.lifts_once()
        self.add_layers("part{:04}.png", 0)

    def slicing(self):
        names = {"layer_height": "SliceHeight", "exposure_time": "LayerTime", "initial_exposure_time": "FirstLayerTime",
                 "bottom_layer_count": "NumberofBottomLayers", "lift_height": "LiftDistance", "lift_speed": "LiftFeedRate",
                 "retract_speed": "LiftRetractRate"}  # fmt: skip
        self.style.units = False
        tags = "\n".join(f"  <{key}>{value}</{key}>" for key, value in self.pairs(names, factors=self.MS))
        self.files["part.gcode"] = f"G28\n;Number of Slices = {self.declared}\n".encode()
        if self.fault in ("twice", "regions"):  # a list of resins does not say which is meant: it is asked
            self.fault = None
            tags += "<SliceHeight>0.123</SliceHeight>"
            if not self.said.pop("layer_height", None):
                self.said["layer_height"] = 0.123
        self.files["part.slicing"] = self.style.encode(f'<?xml version="1.0"?><SliceBuildConfig a="b">{tags}<Ink/></SliceBuildConfig>')
        self.without_ramp()
        self.lifts_once()
        self.add_layers("part{:04}.png", 0)

    def klipper(self):
        names = {"layer_height": "LayerHeight", "exposure_time": "ExposureTime", "initial_exposure_time": "BottomExposureTime",
                 "bottom_layer_count": "BottomLayerCount", "faded_layers": "TransitionLayerCount", "lift_height": "LiftHeight",
                 "lift_speed": "LiftSpeed", "retract_speed": "RetractSpeed"}  # fmt: skip
        pairs = self.pairs(names) + [("LiftSpeed2", 0), ("RetractSpeed2", 0), ("Mirror", 1), ("LayerCount", self.declared)]
        if self.fault == "regions":
            pairs.append(("LightPWM", 100))
        lines = self.twice(self.style.lines(pairs, ";"), "layer_height", ";LayerHeight")
        lines += [f"SET_PRINT_STATS_INFO TOTAL_LAYER={self.declared} LAYER=1", f"PRINT_START LAYERS={self.declared} HEIGHT=1"]
        self.files["part.gcode"], self.files[".klipper"] = self.style.text(lines), b""
        self.without_ramp()
        self.lifts_once()
        self.add_layers("{}.png", 1)

    def nanodlp(self):
        names = {"exposure_time": "CureTime", "initial_exposure_time": "SupportCureTime", "bottom_layer_count": "SupportLayerNumber",
                 "faded_layers": "TransitionalLayer", "lift_height": "WaitHeight"}  # fmt: skip
        profile = {names[key]: value for key, value in self.say(*names).items()}
        if self.say("layer_height"):
            depth = round(1000 * self.values["layer_height"])
            profile["Depth"] = profile["SupportDepth"] = depth
        if self.fault == "regions":  # bottom layers of another height
            profile["SupportDepth"] = 2 * profile["Depth"]
            profile["SupportLayerNumber"] = 4
        profile["CustomValues"] = {"CureTime": "77"}
        text = self.style.json(profile)
        if self.fault == "twice":
            text = self.style.encode(json.dumps(profile)[:-1] + ', "CureTime": 77}')
        self.files["profile.json"] = text
        self.files["slicer.json"] = self.style.json({"PWidth": COLUMNS, "XPixelSize": 0.1, "Running": False, "LayerStatus": []})
        self.files["plate.json"] = self.style.json({"PlateID": 1, "LayersCount": self.declared, "MC": {"Count": 9}, "Path": 'a "b" {['})
        self.files["info.json"] = self.style.json([{"TotalSolidArea": 1}] * self.layers)
        self.files["3d.png"] = MASK
        self.without_ramp()
        self.lifts_once()
        self.add_layers("{}.png", 1)

    def uvj(self):
        exposure = {"exposure_time": "LightOnTime", "lift_height": "LiftHeight", "lift_speed": "LiftSpeed", "retract_speed": "RetractSpeed"}
        bottom = {"initial_exposure_time": "LightOnTime", "bottom_layer_count": "Count"}
        size = {"X": COLUMNS, "Y": ROWS, "Millimeter": {"X": WIDTH, "Y": DEPTH}, "Layers": self.declared}
        if self.say("layer_height"):
            size["LayerHeight"] = self.values["layer_height"]
        properties = {"Size": size, "Exposure": {exposure[k]: v for k, v in self.say(*exposure).items()},
                      "Bottom": {bottom[k]: v for k, v in self.say(*bottom).items()}, "AntiAliasLevel": 1}  # fmt: skip
        if self.fault == "regions":
            properties["Exposure"]["LightPWM"] = 100
        document = {"Properties": properties}
        self.without_ramp()
        document["Layers"] = [{"Z": k, "Exposure": {"LightOnTime": seconds, "LiftHeight": 3}}
                              for k, seconds in enumerate(self.layer_exposures())]  # fmt: skip
        text = self.style.json(document)
        if self.fault == "twice":
            text = self.style.encode(json.dumps(document)[:-1] + ', "Properties": {"Size": {"LayerHeight": 0.2}}}')
        self.files["config.json"] = text
        self.lifts_once()
        self.files["preview/huge.png"] = self.files["preview/tiny.png"] = MASK
        self.add_layers("slice/{:08}.png", 0)

    def write(self, folder, number):
        path = folder / f"{number}_{self.maker.__name__}.{self.ending}"
        prefix = self.rng.choice(("", "", "job/"))
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, body in self.files.items():
                archive.writestr(prefix + name, body)
        return path

    def is_complete(self):
        """Whether it says all that a print is asked about."""
        return {"layer_height", "exposure_time", "initial_exposure_time", "bottom_layer_count", "faded_layers"} <= set(self.said)

    def exposures(self):
        first, last = self.said["initial_exposure_time"], self.said["exposure_time"]
        bottom, faded = self.said["bottom_layer_count"], self.said["faded_layers"]
        steps = [min(max(k + 1 - bottom, 0), faded + 1) / (faded + 1) for k in range(self.layers)]
        return [first + (last - first) * step for step in steps]


class Dialects(Program):
    def setUp(self):
        super().setUp()
        self.printer = self.dir / "tiny.toml"
        text = SIM2K.read_text().replace('"sim2k"', '"tiny"').replace("= 0.04725 ", "= 0.1 ")
        text = text.replace("columns = 1440", f"columns = {COLUMNS}").replace("rows = 2560", f"rows = {ROWS}")
        profile = (SIM2K.parent / "profiles/standard.toml").read_text()
        (self.dir / "profiles").mkdir()
        (self.dir / "profiles/standard.toml").write_text(profile)
        self.printer.write_text(text)

    def test_200_archives_say_what_their_generator_said_or_are_refused(self):
        seen, read, refused, printed = set(), 0, 0, 0
        print_all = os.environ.get("PLUMBLINE_PRINT_ALL")
        for number in range(ARCHIVES):
            made = Archive(number)
            path = made.write(self.dir, number)
            with self.subTest(path.name, silent=sorted(made.silent), fault=made.fault):
                done = subprocess.run([PLUMBLINE, "inspect", path, "--printer", self.printer, "--json"], capture_output=True, text=True, timeout=60)
                if made.fault:
                    self.assertEqual(done.returncode, 1, done.stdout)
                    self.assertIn(path.name, done.stderr)
                    refused += 1
                    continue
                self.assertEqual(done.returncode, 0, done.stderr)
                told = json.loads(done.stdout)
                self.assertTrue(told["fits"], told)
                found = {key: value for key, value in told["archive"].items() if key not in ("name", "layers", "columns", "rows")}
                self.assertEqual(set(found), set(made.said))
                for key, value in made.said.items():
                    self.assertAlmostEqual(found[key], value, delta=1e-9, msg=key)
                read += 1
                if made.is_complete() and (print_all or made.maker.__name__ not in seen):
                    seen.add(made.maker.__name__)
                    self.print_and_compare(made, path)
                    printed += 1
            path.unlink()
        self.assertGreater(min(read, refused), 30, (read, refused, printed))
        self.assertGreaterEqual(printed, 50 if print_all else 7, seen)

    def print_and_compare(self, made, path):
        report = self.dir / "report.json"
        self.run_it("print", path, "--printer", self.printer, "--report", report, "--quiet")
        told = json.loads(report.read_text())
        self.assertEqual(told["state"], "finished")
        self.assertAlmostEqual(told["layer_height_mm"], made.said["layer_height"], delta=1e-6)
        asked = [line["asked_s"] for line in told["exposures"]]
        self.assertEqual(len(asked), made.layers)
        for layer, (one, other) in enumerate(zip(asked, made.exposures())):
            self.assertAlmostEqual(one, other, delta=2e-3, msg=f"layer {layer}")


if __name__ == "__main__":
    main()
