#!/usr/bin/env python3
"""Checks that each file includes only what its folder may, and has its folder's namespace: check_includes.py REPOSITORY

Prints file:line and the reason for each violation. Exit status: 0 none, 1 some, 2 no files found.
"""

import re
import sys
from pathlib import Path

# Target -> targets it may include, besides itself. A file belongs to the deepest target that holds it: "hal" excludes "hal/linux".
MAY_INCLUDE = {
    "slicer/core": set(),
    "slicer": {"slicer/core"},
    "slicer/example": {"slicer/core", "slicer"},  # a program as a user of the library would write it
    "hal": {"slicer/core"},
    "hal/linux": {"slicer/core", "hal"},
    "hal/sim": {"slicer/core", "hal"},
    # One file for each back end of the HAL may include it: see COMPOSITION.
    "firmware": {"slicer/core", "slicer", "hal", "firmware/pictures", "firmware/canvas"},
    "firmware/canvas": {"slicer/core"},
    "firmware/pictures": {"slicer/core", "slicer", "firmware/canvas"},
    "tests": {"slicer/core", "slicer", "hal", "hal/linux", "hal/sim", "firmware", "firmware/canvas", "firmware/pictures"},
}

# Folder -> its subfolders in the data's order. Each may include those before it. The files directly in the folder come last, unless "." has
# their place.
ORDER = {
    "slicer": ["core", "reader", "cloud", "placement", "orientation", "implicit", "normals", "views", "surface", "rrep", "mesh", "rays",
               "layers", "dose", "supports", "checks", "plan"],
    "slicer/core": ["numbers", "words", "resin", ".", "regions"],
    "slicer/reader/formats": ["e57", "pcd", "splats", "tables"],
    "slicer/reader": ["stream", "records", "formats", "triangles"],
    "slicer/supports": ["drawing"],
    "hal/linux": ["gpio", "events", "keeper", "lamp", "stage", "display", "screen", "stick", "thermals"],
    "firmware/print": ["truth", "status", "job", "loop"],
    "firmware/daemon": ["stick", "upload", "service"],
    "firmware/page": ["clients"],
    "firmware/cli": ["options", "reports"],
    "firmware": ["io", "messages", "settings", "canvas", "pictures", "archive", "sample", "machine", "slice", "print", "child", "state", "screen",
                 "daemon", "page", "setup", "cli"],
}

# The source file that opens each back end of the HAL. firmware/machine/back_end.cpp chooses between them.
COMPOSITION = {
    "firmware/machine/linux_back_end.cpp": {"hal/linux"},
    "firmware/machine/simulated_back_end.cpp": {"hal/sim"},
}

# External header -> how many source files outside tests include it. One file wraps each library and keeps its memory, exceptions
# and types to itself. "exactly" also reports a dependency that is no longer used.
ONE_SOURCE_FILE = {
    "nanoflann.hpp": "exactly",
    "expat.h": "at most",
    "zlib.h": "at most",
    "spng.h": "at most",
    "freetype/freetype.h": "at most",
    "qrencode.h": "at most",
    "seccomp.h": "at most",
    "minizip/zip.h": "at most",
    "minizip/unzip.h": "at most",
    "toml++/toml.h": "at most",
    "gpiod.h": "at most",
    "microhttpd.h": "at most",
    "libusb.h": "at most",
}

# Folder -> namespace of its files, which may have another inside.
NAMESPACES = {
    "slicer": "plumbline::inline slicer",
    "hal": "plumbline::inline hal",
    "hal/linux": "plumbline::inline hal::inline linux_board",
    "hal/sim": "plumbline::inline hal::inline sim",
    "firmware": "plumbline::firmware",
    **{f"firmware/{part}": f"plumbline::firmware::inline {part}" for part in ("archive", "canvas", "page", "pictures", "screen", "settings", "state")},
}

# The slicer uses no threads except OpenMP's, and no files, devices or clock.
NOT_IN_SLICER = re.compile(
    r"thread|jthread|mutex|shared_mutex|condition_variable|future|pthread\.h|"
    r"fstream|filesystem|iostream|fcntl\.h|unistd\.h|sys/.*|linux/.*|"
    r"chrono|ctime|time\.h"
)

SOURCES = {".cpp", ".cc", ".c"}
HEADERS = {".hpp", ".h", ".hh", ".inl"}
NAMESPACE = re.compile(r"^namespace (plumbline[^{]*?) *\{", re.M)
INCLUDE = re.compile(r"^\s*#\s*include\s*(?:\"([^\"]*)\"|<([^>]*)>|(\S.*))")


def folder_of(path, folders=MAY_INCLUDE):
    """The deepest of `folders` that holds `path`, or None."""
    parents = [parent.as_posix() for parent in Path(path).parents]
    return next((parent for parent in parents if parent in folders), None)


def position(parent, path):
    """
    The place of `path` in the order of `parent`.
    @returns (rank, folder), the higher the later; rank None for a subfolder that has no place in the order
    """
    rest = path[len(parent) + 1 :].split("/")
    own = len(rest) == 1
    name = "." if own else rest[0]
    rank = ORDER[parent].index(name) if name in ORDER[parent] else len(ORDER[parent]) if own else None
    return rank, parent if own else f"{parent}/{name}"


def wrong_way(path, included):
    """Why `path` may not include `included` by ORDER, or None."""
    for parent, order in ORDER.items():
        if folder_of(path) == "slicer/example":
            continue
        if not (path.startswith(parent + "/") and included.startswith(parent + "/")):
            continue
        (from_rank, here), (to_rank, there) = position(parent, path), position(parent, included)
        for rank, folder in ((from_rank, here), (to_rank, there)):
            if rank is None:
                return f"{folder} has no place in the order of {parent}: give it one in ORDER ({', '.join(order)})"
        if to_rank > from_rank:
            names = ", ".join(order) + ("" if "." in order else f", then {parent}'s own files")
            return f"{here} -> {there} is the wrong way: the order in {parent} is {names}"
    return None


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
    """(number of files, ["path:line: reason", ...])"""
    root = Path(root)
    violations = []
    users = {header: [] for header in ONE_SOURCE_FILE}
    files = 0
    for file in our_files(root):
        files += 1
        path = file.relative_to(root).as_posix()
        here = folder_of(path)
        own = NAMESPACES.get(folder_of(path, NAMESPACES))
        for found in NAMESPACE.finditer(file.read_text(encoding="utf-8", errors="replace")):
            if own and found.group(1) != own and not found.group(1).startswith(own + "::"):
                violations.append(f"{path}:0: namespace {found.group(1)}: its folder's is {own}")
        for number, quoted, angled, other in includes(file):
            at = f"{path}:{number}"
            if other is not None:
                violations.append(f"{at}: include {other}: write the name, a macro can't be checked")
            elif quoted is not None:
                there = folder_of(quoted)
                if there is None or ".." in quoted.split("/"):
                    violations.append(f'{at}: "{quoted}": write our headers from the top, as in "slicer/core/arena.hpp"')
                    continue
                if there != here and there not in MAY_INCLUDE[here] | COMPOSITION.get(path, set()):
                    allowed = ", ".join(sorted(MAY_INCLUDE[here])) or "nothing else of ours"
                    violations.append(f'{at}: "{quoted}": {here} may not include {there}; it may include {allowed}')
                elif reason := wrong_way(path, quoted):
                    violations.append(f'{at}: "{quoted}": {reason}')
            else:
                if folder_of(angled) is not None and (root / angled).exists():
                    violations.append(f'{at}: <{angled}>: our headers go in quotes')
                if here in ("slicer", "slicer/core") and NOT_IN_SLICER.fullmatch(angled):
                    violations.append(f"{at}: <{angled}>: the slicer uses no threads except OpenMP's, no files, devices or clock")
                if angled in users and here != "tests":
                    users[angled].append(at)
                    if file.suffix in HEADERS:
                        violations.append(f"{at}: <{angled}>: include it in a source file only, so that it goes no further")
    for header, places in users.items():
        if len(places) > 1:
            violations += [f"{at}: <{header}>: one source file may include it, and {len(places)} do" for at in places]
        if not places and ONE_SOURCE_FILE[header] == "exactly":
            violations.append(f"slicer:0: <{header}>: one source file should include it, and none does")
    return files, violations


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    files, violations = check(arguments[0])
    for violation in violations:
        print(violation)
    print(f"{files} files, {len(violations)} violations")
    if files == 0:
        return 2
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
