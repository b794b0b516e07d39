#!/usr/bin/env python3
"""Makes tables from changed texts: a new language needs nothing but its file, and what is wrong with a file is named."""

import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
MESSAGES = "firmware/messages"


class MakeTables(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        shutil.copytree(ROOT / MESSAGES, self.root / MESSAGES)
        for path in (Path("slicer/core/words/told.hpp"), Path("firmware/canvas/face.cpp")):
            (self.root / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / path, self.root / path)
        self.out = self.root / "out"
        self.out.mkdir()

    def add(self, name, change):
        text = (self.root / MESSAGES / "de.toml").read_text(encoding="utf-8").replace('"German"', '"French"')
        (self.root / MESSAGES / name).write_text(change(text), encoding="utf-8")

    def make(self):
        return subprocess.run([sys.executable, "-B", self.root / MESSAGES / "make_tables.py", self.root / MESSAGES, self.out], capture_output=True, text=True)

    def test_a_third_language_is_a_file(self):
        self.add("fr.toml", lambda text: text.replace("Bereit", "Prêt"))
        made = self.make()
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        header = (self.out / "message_tables.hpp").read_text(encoding="utf-8")
        self.assertIn("enum class Language : std::uint8_t { kEnglish, kGerman, kFrench };", header)
        self.assertIn('kLanguageCodes = {"en", "de", "fr"};', header)
        self.assertIn('"fr":{"told":{"too_wide"', (self.out / "words.js").read_text(encoding="utf-8"))

    def test_what_is_missing_or_unknown_is_named(self):
        for change, said in ((("island = {", "iland = {"), "[messages] has no 'island': add it"),
                             (('ready = "Bereit"\n', ""), "[screen] has no 'ready': add it"),
                             (("Bereit", "Žalud"), "[screen] has a 'Ž', which the screen's font is made without: add it to kFurther"),
                             (("{area_mm2}", "{area_mm2"), ": a bracket has no other end"),
                             (("{area_mm2}", "{area}"), ": there is no fact 'area': correct it"),
                             (("[fields]\n", '[fields]\ncolour = "Farbe"\n'), "nothing asks for 'colour' of [fields]: correct or remove it")):
            self.add("fr.toml", lambda text, change=change: text.replace(*change, 1))
            made = self.make()
            self.assertNotEqual(made.returncode, 0)
            self.assertRegex(made.stderr, f"fr.toml: .*{re.escape(said)}")


if __name__ == "__main__":
    unittest.main()
