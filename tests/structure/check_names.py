#!/usr/bin/env python3
"""Checks that each name of a type, alias or constant stands once in the program: check_names.py REPOSITORY

Two types of one name in one namespace break the rule of one definition. Neither compiler nor linker must say so, and the program then runs
the functions of one with the data of the other. Names in unnamed namespaces may stand in several files, but must not hide one of these.

Prints the places of each name that stands twice. Exit status: 0 none, 1 some, 2 no files found.
"""

import re
import sys
from collections import defaultdict
from pathlib import Path

TOPS = ("slicer", "hal", "firmware")
UNNAMED = "(unnamed)"

# What holds no code: comments, texts, characters, and lines of the preprocessor.
NO_CODE = re.compile(
    r"//[^\n]*|/\*.*?\*/|R\"\(.*?\)\"|\"(?:\\.|[^\"\\\n])*\"|(?<!\w)'(?:\\.|[^'\\\n])+'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.S | re.M
)
NAMESPACE = re.compile(r"\bnamespace\s*([\w:]*)\s*$")
TYPE = re.compile(
    r"(?:^|[>\s])(?:class|struct|union|enum(?:\s+(?:class|struct))?)\s+(?:\[\[[^\]]*\]\]\s*|alignas\([^)]*\)\s*)*(\w+)(?:\s+final)?\s*(?::(?!:)[^;]*)?$", re.S
)
ALIAS = re.compile(r"^(?:template\s*<[^;]*>\s*)?using\s+(\w+)\s*=", re.S)
CONSTANT = re.compile(r"^(?:inline|static|extern|const|constexpr|constinit)\b[^=(){]*?\b(k[A-Z]\w*)\s*(?:\[[^\]]*\]\s*)*(?:$|[={])", re.S)


def names_in(text):
    """(namespaces, name, line, whether it has linkage) of each type, alias and constant that is defined in a namespace"""
    text = NO_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)
    scopes = []
    begin = 0
    for match in re.finditer(r"[{};]", text):
        statement = text[begin : match.start()].strip()
        line = text.count("\n", 0, begin + len(text[begin : match.start()]) - len(text[begin : match.start()].lstrip())) + 1
        in_namespace = all(scope is not None for scope in scopes)
        space = NAMESPACE.search(statement)
        opens = match.group() == "{"
        if in_namespace and scopes and not space:
            a_type = TYPE.search(statement) if opens else None
            found = a_type or ALIAS.match(statement) or CONSTANT.match(statement)
            if found and not (statement.startswith("extern") and "=" not in statement):
                yield "::".join(scopes), found.group(1), line, bool(a_type)
        if opens:
            scopes.append((space.group(1) or UNNAMED) if space else None)
        elif match.group() == "}" and scopes:
            scopes.pop()
        begin = match.end()


def several_files(places):
    """Within one file the preprocessor chooses."""
    return len({place.rsplit(":", 1)[0] for place in places}) > 1


def check(root):
    """(number of files, [what is wrong])"""
    shared = defaultdict(list)  # name with its namespaces -> places
    hidden = []
    files = 0
    for top in TOPS:
        for file in sorted((Path(root) / top).rglob("*")):
            if file.suffix not in (".cpp", ".hpp"):
                continue
            files += 1
            for scope, name, line, linked in names_in(file.read_text(encoding="utf-8", errors="replace")):
                place = f"{file.relative_to(root).as_posix()}:{line}"
                if UNNAMED in scope or not (linked or file.suffix == ".hpp"):
                    hidden.append((scope.split("::" + UNNAMED)[0] + "::" + name, place))
                else:
                    shared[f"{scope}::{name}"].append(place)
    wrong = [f"{name} stands {len(places)} times: {', '.join(places)}" for name, places in sorted(shared.items()) if several_files(places)]
    definition = {name: {place.rsplit(".", 1)[0] for place in places} for name, places in shared.items()}
    wrong += [
        f"{place}: hides {name} of {shared[name][0]}"
        for name, place in hidden
        if name in shared and place.rsplit(".", 1)[0] not in definition[name]  # a constant that its own header declares
    ]
    return files, wrong


def main():
    files, wrong = check(sys.argv[1])
    print("\n".join(wrong))
    if files == 0:
        print("no files found")
        return 2
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
