#!/usr/bin/env python3
"""Checks the rule of one definition across the whole program: check_one_definition.py BUILD

Compiles what the programs are made of once more, without optimizing, and lets the linker compare all types and functions (gcc's -flto, -Wodr,
-Wlto-type-mismatch).

Prints what gcc says. Exit status: 0 nothing, 1 something, 2 nothing to check.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# What holds no code: comments, texts, characters, and lines of the preprocessor.
NO_CODE = re.compile(
    r"//[^\n]*|/\*.*?\*/|R\"\(.*?\)\"|\"(?:\\.|[^\"\\\n])*\"|(?<!\w)'(?:\\.|[^'\\\n])+'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.S | re.M
)
NAMESPACE = re.compile(r"\bnamespace\s*((?:\w|::|\binline )*)\s*$")
NAMES = (
    re.compile(
        r"(?:^|[>\s])(?:class|struct|union|enum(?:\s+(?:class|struct))?)\s+(?:\[\[[^\]]*\]\]\s*|alignas\([^)]*\)\s*)*(\w+)(?:\s+final)?\s*(?::(?!:)[^;]*)?$", re.S
    ),
    re.compile(r"^(?:template\s*<[^;]*>\s*)?using\s+(\w+)\s*=", re.S),
    re.compile(r"^(?:inline|static|extern|const|constexpr|constinit)\b[^=(){]*?\b(k[A-Z]\w*)\s*(?:\[[^\]]*\]\s*)*(?:$|[={])", re.S),
    re.compile(r"(\w+)\s*\("),
)
OURS = re.compile(r"(slicer|hal|hal/linux|hal/sim|firmware)/CMakeFiles/plumbline_\w+\.dir/")
MOST_JOINED = 8
FLAGS = ["-O0", "-g0", "-flto", "-fno-fat-lto-objects"]


def commands(build):
    """(words of the command, folder, output) of each object and each precompiled header of our libraries"""
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        words = shlex.split(entry["command"])
        output = words[words.index("-o") + 1]
        if OURS.match(output):
            yield words, entry["directory"], output


def own_names(source):
    """What a source file has in unnamed namespaces: two files that share one of these names can't be compiled as one."""
    text = NO_CODE.sub("", source.read_text(encoding="utf-8"))
    names, scopes, begin = set(), [], 0
    for match in re.finditer(r"[{};]", text):
        statement = text[begin : match.start()].strip()
        space = NAMESPACE.search(statement)
        if "" in scopes and None not in scopes and not space:
            for pattern in NAMES:
                found = pattern.search(statement)
                if found:
                    names.add(found.group(1))
        if match.group() == "{":
            scopes.append(space.group(1) if space else None)
        elif match.group() == "}" and scopes:
            scopes.pop()
        begin = match.end()
    return names


def joined(jobs):
    """[(words, folder, [sources])]: sources of one folder and target that can be compiled as one, which takes a third of the time."""
    groups = {}  # target and folder of sources -> [(words, folder, sources, names)]
    for words, where, output in jobs:
        source = Path(words[-1])
        names = own_names(source)
        places = groups.setdefault((output.split(".dir/")[0], source.parent), [])
        place = next((group for group in places if len(group[2]) < MOST_JOINED and not names & group[3]), None)
        if place is None:
            places.append((words, where, [source], set(names)))
        else:
            place[2].append(source)
            place[3].update(names)
    return [group[:3] for places in groups.values() for group in places]


def compile_one(words, folder, target, headers):
    """
    @param headers  path without .gch of a precompiled header -> that of ours, which has our flags
    @returns what the compiler said, if it failed
    """
    out = words.index("-o")
    kept = [headers.get(word, word) for word in words[:out] + words[out + 2 :] if not word.startswith(("-W", "-O", "-g"))]
    done = subprocess.run([*kept, *FLAGS, "-w", "-o", target], cwd=folder, capture_output=True, text=True, check=False)
    return done.stderr if done.returncode != 0 else ""


def compared(compiler, objects, target):
    """What gcc says about the objects' types and functions. Objects are joined to one that is not compiled further, which takes no time."""
    link = [compiler, *FLAGS, "-Wodr", "-Wlto-type-mismatch", "-r", "-flinker-output=rel", "-o", target]
    linked = subprocess.run([*link, *objects], capture_output=True, text=True, check=False)
    return linked.stderr or ("the linker failed" if linked.returncode != 0 else "")


def main():
    build = Path(sys.argv[1])
    ours = list(commands(build))
    if not ours:
        print(f"{build}: no objects of ours in compile_commands.json")
        return 2
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        headers, made, sources = {}, [], []
        for number, (words, where, output) in enumerate(ours):
            if output.endswith(".gch"):
                header = str(Path(where, output).with_suffix(""))
                headers[header] = shutil.copy(header, Path(folder, f"{number}.hxx"))
                made.append((words, where, f"{headers[header]}.gch"))
            else:
                sources.append((words, where, output))
        said = "".join(pool.map(lambda job: compile_one(*job, {}), made))

        def compile_group(job):
            number, (words, where, files) = job
            source, target = Path(folder, f"{number}.cpp"), str(Path(folder, f"{number}.o"))
            source.write_text("".join(f'#include "{file}"\n' for file in files), encoding="utf-8")
            failed = compile_one([*words[:-1], str(source)], where, target, headers)
            if not failed or len(files) == 1:
                return [target], failed
            # Files that don't go together: one by one.
            targets = [f"{target}{i}.o" for i in range(len(files))]
            return targets, "".join(compile_one([*words[:-1], str(file)], where, to, headers) for file, to in zip(files, targets))

        objects = []
        for targets, failed in pool.map(compile_group, enumerate(joined(sources))):
            objects += targets
            said += failed
        said = said or compared(ours[0][0][0], objects, str(Path(folder, "all.o")))
        print(f"{len(sources)} sources in {len(objects)} objects\n{said}")
        return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main())
