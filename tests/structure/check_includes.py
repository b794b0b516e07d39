#!/usr/bin/env python3
"""Checks that no file includes what its folder may not: usage check_includes.py REPOSITORY

Prints file:line and the reason for each violation. Exit status: 0 none, 1 some, 2 nothing was looked at.
"""

import re
import sys
from pathlib import Path

# Folder -> folders that it may include from, besides itself. The deepest folder that holds a file is the one that counts,
# so that "hal" as a target does not mean "hal/linux".
MAY_INCLUDE = {
    "slicer/core": set(),
    "slicer": {"slicer/core"},
    "hal": {"slicer/core"},
    "hal/linux": {"slicer/core", "hal"},
    "hal/sim": {"slicer/core", "hal"},
    # One file for each back end of the HAL may include it: see COMPOSITION.
    "firmware": {"slicer/core", "slicer", "hal"},
    "tests": {"slicer/core", "slicer", "hal", "hal/linux", "hal/sim", "firmware"},
}

# The one source file of the product that opens each back end of the HAL. firmware/machine/back_end.cpp chooses between them.
COMPOSITION = {
    "firmware/machine/linux_back_end.cpp": {"hal/linux"},
    "firmware/machine/simulated_back_end.cpp": {"hal/sim"},
}

# Header of somebody else -> how many source files outside of tests include it. Each has one file that arranges it: its
# memory, its exceptions, its types stay there. "exactly" also notices that a dependency is no longer used.
ONE_SOURCE_FILE = {
    "nanoflann.hpp": "exactly",
    "lodepng.h": "at most",
    "libdeflate.h": "at most",
    "toml++/toml.h": "at most",
    "gpiod.h": "at most",
    "libusb.h": "at most",
}

# The slicer has no threads but OpenMP's, no files, no devices and no clock.
NOT_IN_SLICER = re.compile(
    r"thread|jthread|mutex|shared_mutex|condition_variable|future|pthread\.h|"
    r"fstream|filesystem|iostream|fcntl\.h|unistd\.h|sys/.*|linux/.*|"
    r"chrono|ctime|time\.h"
)

SOURCES = {".cpp", ".cc", ".c"}
HEADERS = {".hpp", ".h", ".hh", ".inl"}
INCLUDE = re.compile(r"^\s*#\s*include\s*(?:\"([^\"]*)\"|<([^>]*)>|(\S.*))")


def folder_of(path):
    """The deepest folder of MAY_INCLUDE that holds `path`, or None."""
    parents = [parent.as_posix() for parent in Path(path).parents]
    return next((parent for parent in parents if parent in MAY_INCLUDE), None)


def includes(file):
    """(line number, quoted name, name in angle brackets, anything else) of each include; one of the three is not None."""
    text = file.read_text(encoding="utf-8", errors="replace")
    for number, line in enumerate(text.splitlines(), start=1):
        match = INCLUDE.match(line)
        if match:
            yield number, *match.groups()


def our_files(root):
    tops = sorted({folder.split("/")[0] for folder in MAY_INCLUDE})
    for top in tops:
        for file in sorted((root / top).rglob("*")):
            if file.suffix in SOURCES | HEADERS:
                yield file


def check(root):
    """(files looked at, ["path:line: reason", ...])"""
    root = Path(root)
    violations = []
    users = {header: [] for header in ONE_SOURCE_FILE}
    looked_at = 0
    for file in our_files(root):
        looked_at += 1
        path = file.relative_to(root).as_posix()
        here = folder_of(path)
        for number, quoted, angled, other in includes(file):
            at = f"{path}:{number}"
            if other is not None:
                violations.append(f"{at}: include {other}: write the name, a macro can't be checked")
            elif quoted is not None:
                there = folder_of(quoted)
                if there is None or ".." in quoted.split("/"):
                    violations.append(f'{at}: "{quoted}": write our headers from the top, as in "slicer/core/arena.hpp"')
                elif there != here and there not in MAY_INCLUDE[here] | COMPOSITION.get(path, set()):
                    allowed = ", ".join(sorted(MAY_INCLUDE[here])) or "nothing else of ours"
                    violations.append(f'{at}: "{quoted}": {here} may not include {there}; it may include {allowed}')
            else:
                if folder_of(angled) is not None and (root / angled).exists():
                    violations.append(f'{at}: <{angled}>: our headers go in quotes')
                if here in ("slicer", "slicer/core") and NOT_IN_SLICER.fullmatch(angled):
                    violations.append(f"{at}: <{angled}>: the slicer has no threads but OpenMP's, no files, no devices, no clock")
                if angled in users and here != "tests":
                    users[angled].append(at)
                    if file.suffix in HEADERS:
                        violations.append(f"{at}: <{angled}>: in a source file only, so that it goes no further")
    for header, places in users.items():
        if len(places) > 1:
            violations += [f"{at}: <{header}>: one source file includes it, here are {len(places)}" for at in places]
        if not places and ONE_SOURCE_FILE[header] == "exactly":
            violations.append(f"slicer:0: <{header}>: exactly one source file includes it, here is none")
    return looked_at, violations


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    looked_at, violations = check(arguments[0])
    for violation in violations:
        print(violation)
    print(f"{looked_at} files, {len(violations)} violations")
    if looked_at == 0:
        return 2
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
