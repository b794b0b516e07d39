#!/usr/bin/env python3
"""Makes C++ tables and the page's words.js from the texts, a file a language: make_tables.py SOURCE_FOLDER OUTPUT_FOLDER

The build runs it. A text that is missing, or that nothing asks for, ends it with the file and the key.
"""

import json
import pathlib
import re
import sys
import tomllib

CODES = ("slicer/core/words/told.hpp", "ToldCode"), ("firmware/messages/printer_code.hpp", "PrinterCode")
SECTIONS = "screen", "fields", "sources", "faults", "remedies", "page"  # with the same keys in each language
PLACE = r"\{\w+(?:\?[^|{}]*\|[^|{}]*)?\}"
PLACES = re.compile(rf"(?:[^][{{}}]|{PLACE}|\[(?:[^][{{}}]|{PLACE})*\])*")


def snake(name):
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def camel(key):
    return "k" + "".join(word.capitalize() for word in key.split("_"))


def code_keys(root):
    """The keys of all codes but kNone, in their order."""
    for path, enum in CODES:
        text = (root / path).read_text(encoding="utf-8")
        body = re.search(r"enum class " + enum + r"\b[^{]*\{(.*?)\n\};", text, re.DOTALL).group(1)
        yield from (snake(name) for name in re.findall(r"^ *k(\w+)", body, re.MULTILINE) if name != "None")


def keys_of(table, prefix=""):
    for key, value in table.items():
        nested = isinstance(value, dict)
        yield from keys_of(value, f"{prefix}{key}.") if nested else [prefix + key]


def same_keys(path, section, found, wanted):
    for key in sorted(wanted - found):
        sys.exit(f"{path}: [{section}] has no '{key}': add it")
    for key in sorted(found - wanted):
        sys.exit(f"{path}: nothing asks for '{key}' of [{section}]: correct or remove it")


def texts_of(table):
    for value in table.values():
        yield from texts_of(value) if isinstance(value, dict) else [value]


def check_places(path, text, facts):
    for key, said in text["messages"].items():
        for words in said.values():
            if not PLACES.fullmatch(words):
                sys.exit(f"{path}: [messages] {key}: a bracket has no other end, or stands in another one: correct it")
            for name in set(re.findall(r"\{(\w+)", words)) - facts:
                sys.exit(f"{path}: [messages] {key}: there is no fact '{name}': correct it")


def check_characters(path, text, face):
    """What the screen shows must be in its font."""
    further = re.search(r'kFurther = u"(.*?)"', face).group(1)
    for section in SECTIONS[:-1] + ("messages",):
        for words in texts_of(text[section]):
            for letter in words:
                if not (" " <= letter <= "~" or "\xa1" <= letter <= "\xff" or letter in further):
                    sys.exit(f"{path}: [{section}] has a '{letter}', which the screen's font is made without: add it to kFurther of firmware/canvas/face.cpp")


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def rows(values):
    return "".join(f"    {value},\n" for value in values)


def write(path, text):
    """Leaves an unchanged file alone, so that nothing is rebuilt."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def main():
    source, output = (pathlib.Path(name).resolve() for name in sys.argv[1:])
    files = sorted(source.glob("*.toml"), key=lambda path: (path.stem != "en", path.stem))
    texts = {path: tomllib.loads(path.read_text(encoding="utf-8")) for path in files}
    english = texts[files[0]]
    root = source.parent.parent
    codes = list(code_keys(root))
    formats = (source / "printer_code.cpp").read_text(encoding="utf-8")
    facts = {"name", *re.findall(r'^ *\{"(\w+)"', formats, re.MULTILINE)}
    face = (root / "firmware/canvas/face.cpp").read_text(encoding="utf-8")
    for path, text in texts.items():
        for section in SECTIONS:
            same_keys(path, section, set(keys_of(text[section])), set(keys_of(english[section])))
        said = set(text["messages"])
        same_keys(path, "messages", said, said & set(codes) if text is english else set(codes))
        check_places(path, text, facts)
        check_characters(path, text, face)

    languages = list(texts.values())
    write(output / "message_tables.hpp", f"""#pragma once
// Made by make_tables.py from the texts beside it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace plumbline::firmware {{

enum class Language : std::uint8_t {{ {", ".join("k" + text["name"] for text in languages)} }};
inline constexpr std::size_t kLanguageCount = {len(languages)};
/// "en", "de", ...: by Language
inline constexpr std::array<std::string_view, kLanguageCount> kLanguageCodes = {{{", ".join(quoted(path.stem) for path in files)}}};

/// The texts of the printer's screen.
enum class Words : std::uint8_t {{
{"".join(f"  {camel(key)},{chr(10)}" for key in english["screen"])}}};
inline constexpr std::size_t kWordsCount = {len(english["screen"])};

}}  // namespace plumbline::firmware
""")

    def table(kind, name, row, keys, section):
        """By language, then by key."""
        per_language = (f"  {{{{\n{rows(row(key, text[section].get(key, {})) for key in keys)}  }}}},\n" for text in languages)
        return f"constexpr std::array<std::array<{kind}, {len(keys)}>, kLanguageCount> {name} = {{{{\n{''.join(per_language)}}}}};\n\n"

    def parts(value, *names):
        return ", ".join(quoted(value.get(name, "")) for name in names)

    write(output / "message_tables.inc", f"""// Made by make_tables.py from the texts beside it.

constexpr std::array<char, kLanguageCount> kDecimals = {{{", ".join(f"'{text['decimal']}'" for text in languages)}}};

/// By code.
constexpr std::array<std::string_view, {len(codes) + 1}> kCodeKeys = {{
{rows(map(quoted, ["none", *codes]))}}};

""" + table("std::string_view", "kScreen", lambda key, value: quoted(value), list(english["screen"]), "screen")
        + table("KeyedText", "kFields", lambda key, value: f"{{{quoted(key)}, {quoted(value)}}}", list(english["fields"]), "fields")
        + table("KeyedText", "kSources", lambda key, value: f"{{{quoted(key)}, {quoted(value)}}}", list(english["sources"]), "sources")
        + table("KeyedText", "kRemedies", lambda key, value: f"{{{quoted(key)}, {quoted(value)}}}", list(english["remedies"]), "remedies")
        + table("FaultWords", "kFaults", lambda key, value: f"{{{key[3:]}, {parts(value, 'title', 'meaning', 'remedy')}}}", sorted(english["faults"]), "faults")
        + table("ToldWords", "kTold", lambda key, value: f"{{{parts(value, 'text', 'remedy', 'terminal')}}}", ["none", *codes], "messages"))

    page = {path.stem: text["page"] | {f"mend_{key}": value for key, value in text["remedies"].items()} for path, text in texts.items()}
    printer = {path.stem: {"told": {key: [value["text"], value.get("remedy", "")] for key, value in text["messages"].items() if "text" in value},
                           "faults": text["faults"], "fields": text["fields"], "sources": text["sources"]} for path, text in texts.items()}
    digits = {name: int(count) for name, count in re.findall(r'\{"(\w+)", (-?\d+)\}', formats)}
    constants = {"texts": page, "printerTexts": printer, "factDigits": digits}
    write(output / "words.js", '"use strict";\n' + "".join(f"const {name} = {json.dumps(value, ensure_ascii=False, separators=(',', ':'))};\n"
                                                          for name, value in constants.items()))


main()
