#!/usr/bin/env python3
"""Tests the Debian package of a build: deb_test.py CPACK BUILD_DIR SOURCE_DIR ARCHITECTURE READELF

Makes the package with cpack and checks that it has exactly the files that an installed printer needs, that its programs are of its
architecture, and that it depends on exactly the libraries that they load, in versions new enough for them.
"""

import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CPACK, BUILD_DIR, SOURCE_DIR, ARCHITECTURE, READELF = sys.argv[1:]
PROGRAMS = ("plumbline", "plumblined", "plumbline-keeper", "plumbline-mount", "plumbline-page")
MACHINE = {"amd64": "X86-64", "arm64": "AArch64", "armhf": "ARM"}
# Libraries in the C library's package; ld-linux is the loader.
C_LIBRARY = re.compile(r"lib(c|m|pthread|dl|rt)\.so\.|ld-linux")
# Needed but not loaded by the programs: udev reports sticks, passwd creates the daemon's user.
NOT_LIBRARIES = {"udev", "passwd"}


def run(*command):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stdout


def package_of(library):
    """Debian's name for the package of a shared library: libusb-1.0.so.0 is in libusb-1.0-0, libgcc_s.so.1 in libgcc-s1."""
    if C_LIBRARY.match(library):
        return "libc6"
    if library == "libz.so.1":
        return "zlib1g"
    name, number = library.replace("_", "-").split(".so.")
    return name + ("-" if name[-1].isdigit() else "") + number


class Deb(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="plumbline-deb-")
        cls.addClassCleanup(cls.folder.cleanup)
        made = Path(cls.folder.name) / "made"
        run(CPACK, "--config", f"{BUILD_DIR}/CPackConfig.cmake", "-B", made)
        (cls.deb,) = made.glob("*.deb")
        cls.root = Path(cls.folder.name) / "root"
        run("dpkg-deb", "--raw-extract", cls.deb, cls.root)
        cls.control = dict(re.findall(r"^(\S+): (.*)$", (cls.root / "DEBIAN/control").read_text(), re.MULTILINE))
        cls.depends = {}
        for one in cls.control["Depends"].split(", "):
            name, _, version = one.partition(" ")
            cls.depends[name] = version.strip("(>= )")

    def dynamic(self, program):
        text = run(READELF, "--dynamic", "--version-info", "--wide", self.root / "usr/bin" / program)
        return re.findall(r"\(NEEDED\).*\[(.*)\]", text), text

    def test_has_exactly_the_files_that_a_printer_needs(self):
        files = {path.relative_to(self.root).as_posix() for path in self.root.rglob("*") if path.is_file()}
        files = {name for name in files if not name.startswith("DEBIAN/")}
        board = Path(SOURCE_DIR) / "board"
        expected = {f"usr/bin/{program}" for program in PROGRAMS}
        expected |= {f"usr/lib/systemd/system/{unit}.service" for unit in ("plumblined", "plumbline-mount", "plumbline-awake", "plumbline-page")}
        expected |= {"usr/lib/udev/rules.d/60-plumbline.rules"}
        expected |= {f"usr/share/doc/plumbline/{name}" for name in ("copyright", "LICENSE.font")} | {"usr/share/plumbline/board/README.md"}
        expected |= {f"usr/share/plumbline/board/{path.relative_to(board)}" for path in board.rglob("*.toml")}
        self.assertEqual(files, expected)

    def test_programs_match_the_architecture(self):
        self.assertEqual(self.control["Architecture"], ARCHITECTURE)
        self.assertRegex(self.deb.name, rf"^plumbline_\d+\.\d+\.\d+_{ARCHITECTURE}\.deb$")
        for program in PROGRAMS:
            self.assertRegex(run(READELF, "--file-header", self.root / "usr/bin" / program), rf"Machine: .*{MACHINE[ARCHITECTURE]}")

    def test_depends_on_exactly_the_libraries_that_its_programs_load(self):
        needed = {package_of(library) for program in PROGRAMS for library in self.dynamic(program)[0]}
        self.assertGreater(len(needed), 5)
        self.assertEqual(set(self.depends) - NOT_LIBRARIES, needed)

    def test_requires_c_and_cpp_libraries_that_are_new_enough(self):
        for name, symbol in (("libc6", r"GLIBC_(\d+)\.(\d+)"), ("libstdc++6", r"GLIBCXX_(\d+)\.(\d+)\.(\d+)")):
            used = max(
                tuple(map(int, match)) for program in PROGRAMS for match in re.findall(symbol, self.dynamic(program)[1])
            )
            stated = self.depends[name]
            if name == "libc6":
                self.assertGreaterEqual(tuple(map(int, stated.split("."))), used)
            else:
                # gcc 12 added GLIBCXX_3.4.30, and Debian's package is versioned by gcc.
                self.assertEqual((stated, used <= (3, 4, 30)), ("12", True), used)

    def test_only_scripts_and_programs_are_executable(self):
        for path in self.root.rglob("*"):
            if path.is_file():
                is_run = path.parent.name == "bin" or path.name in ("postinst", "prerm")
                self.assertEqual(path.stat().st_mode & 0o777, 0o755 if is_run else 0o644, path)
        for script in ("postinst", "prerm"):
            run("sh", "-n", self.root / "DEBIAN" / script)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
