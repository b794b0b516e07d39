#!/usr/bin/env python3
"""Writes the glyphs of the screen's font as a table: make_outlines.py REGULAR.ttf BOLD.ttf > glyph_table.cpp

Debian: /usr/share/fonts/truetype/dejavu/DejaVuSansCondensed.ttf and DejaVuSansCondensed-Bold.ttf (fonts-dejavu-extra). The result is
committed, so a build needs neither the fonts nor this program.
"""

import struct
import sys

# ASCII, German, and what texts of plumbline and the buttons need.
CHARACTERS = [chr(code) for code in range(32, 127)] + list("ÄÖÜßäöü°²µ·×é–…„“”") + list("▶❚✓✖⚠") + ["\ufffd"]


class Font:
    def __init__(self, path):
        self.data = open(path, "rb").read()
        count = struct.unpack_from(">H", self.data, 4)[0]
        self.tables = {}
        for i in range(count):
            tag, _, offset, _ = struct.unpack_from(">4sIII", self.data, 12 + 16 * i)
            self.tables[tag.decode()] = offset
        self.long_loca = struct.unpack_from(">h", self.data, self.tables["head"] + 50)[0]
        self.metrics = struct.unpack_from(">H", self.data, self.tables["hhea"] + 34)[0]
        self.cmap = self.read_cmap()
        self.x_height, self.cap_height = (max(y for c in self.contours(self.cmap[ord(letter)]) for _, y, _ in c) for letter in "xH")

    def read_cmap(self):
        base = self.tables["cmap"]
        for i in range(struct.unpack_from(">H", self.data, base + 2)[0]):
            platform, encoding, offset = struct.unpack_from(">HHI", self.data, base + 4 + 8 * i)
            at = base + offset
            if (platform, encoding) != (3, 1) or struct.unpack_from(">H", self.data, at)[0] != 4:
                continue
            n = struct.unpack_from(">H", self.data, at + 6)[0] // 2
            ends = struct.unpack_from(f">{n}H", self.data, at + 14)
            starts = struct.unpack_from(f">{n}H", self.data, at + 16 + 2 * n)
            deltas = struct.unpack_from(f">{n}H", self.data, at + 16 + 4 * n)
            places = at + 16 + 6 * n
            offsets = struct.unpack_from(f">{n}H", self.data, places)
            cmap = {}
            for s in range(n):
                for code in range(starts[s], ends[s] + 1):
                    if offsets[s] == 0:
                        cmap[code] = (code + deltas[s]) & 0xFFFF
                    else:
                        place = places + 2 * s + offsets[s] + 2 * (code - starts[s])
                        glyph = struct.unpack_from(">H", self.data, place)[0]
                        cmap[code] = (glyph + deltas[s]) & 0xFFFF if glyph else 0
            return cmap
        raise SystemExit("no Unicode character map")

    def advance(self, glyph):
        return struct.unpack_from(">H", self.data, self.tables["hmtx"] + 4 * min(glyph, self.metrics - 1))[0]

    def contours(self, glyph):
        """[[(x, y, on the curve), ...], ...]"""
        loca = self.tables["loca"]
        if self.long_loca:
            start, end = struct.unpack_from(">II", self.data, loca + 4 * glyph)
        else:
            start, end = (2 * value for value in struct.unpack_from(">HH", self.data, loca + 2 * glyph))
        if start == end:
            return []
        at = self.tables["glyf"] + start
        count = struct.unpack_from(">h", self.data, at)[0]
        return self.simple(at + 10, count) if count >= 0 else self.composite(at + 10)

    def simple(self, at, count):
        ends = struct.unpack_from(f">{count}H", self.data, at)
        at += 2 * count
        at += 2 + struct.unpack_from(">H", self.data, at)[0]
        total, flags = ends[-1] + 1, []
        while len(flags) < total:
            flag = self.data[at]
            at += 1
            flags.append(flag)
            if flag & 8:
                flags += [flag] * self.data[at]
                at += 1
        axes = []
        for short, same in ((2, 16), (4, 32)):
            value, values = 0, []
            for flag in flags:
                if flag & short:
                    value += self.data[at] if flag & same else -self.data[at]
                    at += 1
                elif not flag & same:
                    value += struct.unpack_from(">h", self.data, at)[0]
                    at += 2
                values.append(value)
            axes.append(values)
        points = [(x, y, flag & 1) for x, y, flag in zip(*axes, flags)]
        return [points[first:last + 1] for first, last in zip((0,) + tuple(end + 1 for end in ends), ends)]

    def composite(self, at):
        contours, more = [], True
        while more:
            flags, glyph = struct.unpack_from(">HH", self.data, at)
            at += 4
            dx, dy = struct.unpack_from(">hh" if flags & 1 else ">bb", self.data, at)
            at += 4 if flags & 1 else 2
            if flags & 0xC8 or not flags & 2:
                raise SystemExit("a glyph has a part that is scaled or placed by points: not supported")
            contours += [[(x + dx, y + dy, on) for x, y, on in contour] for contour in self.contours(glyph)]
            more = bool(flags & 0x20)
        return contours


def spelled_out(contour):
    """The contour from a corner on, with the corners that TrueType leaves out between two control points."""
    points = []
    for (x, y, on), (next_x, next_y, next_on) in zip(contour, contour[1:] + contour[:1]):
        points.append((x, y, on))
        if not on and not next_on:
            points.append(((x + next_x) // 2, (y + next_y) // 2, 1))
    first = next(i for i, point in enumerate(points) if point[2])
    return points[first:] + points[:first]


def wrapped(words, width=118):
    line = " "
    for word in words:
        if len(line) + 1 + len(word) > width:
            yield line
            line = " "
        line += " " + word
    yield line


def main(paths):
    print("""/// Made by make_outlines.py from DejaVu Sans Condensed 2.37. Copyright (c) 2003 by Bitstream, Inc. All Rights Reserved. Bitstream Vera is a
/// trademark of Bitstream, Inc. DejaVu changes are in public domain. LICENSE.font has the permission.

#include "firmware/canvas/glyph_table.hpp"

namespace plumbline {
namespace {

// clang-format off""")
    fonts = {name: Font(path) for name, path in zip(("Regular", "Bold"), paths)}
    for name, font in fonts.items():
        words, places = [], []
        for character in CHARACTERS:
            glyph = font.cmap[ord(character)]
            places.append((ord(character), font.advance(glyph), len(words)))
            for contour in map(spelled_out, font.contours(glyph)):
                for i, (x, y, on) in enumerate(contour):
                    words.append(f"{{{x},{y},{on + 2 * (i + 1 == len(contour))}}},")
        print(f"constexpr std::array<OutlinePoint, {len(words)}> k{name}Points{{{{")
        print("\n".join(wrapped(words)))
        print("}};")
        places.sort()
        print(f"constexpr std::array<GlyphOutline, {len(places)}> k{name}Glyphs{{{{")
        starts = sorted(start for _, _, start in places) + [len(words)]
        entries = []
        for code, advance, start in places:
            end = next((other for other in starts if other > start), len(words)) if font.contours(font.cmap[code]) else start
            entries.append(f"{{0x{code:X},{advance},{start},{end - start}}},")
        print("\n".join(wrapped(entries)))
        print("}};")
    print("// clang-format on\n\n}  // namespace\n")
    print("const FontOutlines& font_outlines(FontWeight weight) {")
    for name, font in fonts.items():
        print(f"  static constexpr FontOutlines k{name}{{k{name}Points, k{name}Glyphs, {font.x_height}, {font.cap_height}}};")
    print("  return weight == FontWeight::kBold ? kBold : kRegular;\n}\n\n}  // namespace plumbline")


if __name__ == "__main__":
    main(sys.argv[1:])
