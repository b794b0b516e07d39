"""Shared by the tests of the programs: a scan, a printer, and readers of PNG files and hashes. The readers share no code with
plumbline, so a mistake would have to be made twice to go unnoticed.

A test file is run as: FILE PROGRAMS SOURCE_DIR [unittest options], PROGRAMS the folder that holds plumbline and plumblined.
"""

import itertools
import json
import math
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

PROGRAMS, SOURCE_DIR = Path(sys.argv[1]), Path(sys.argv[2])
PLUMBLINE, PLUMBLINED = PROGRAMS / "plumbline", PROGRAMS / "plumblined"
SIM2K = SOURCE_DIR / "board" / "sim2k.toml"
U64 = 2**64 - 1
STEP = 0x9E3779B97F4A7C15


def box(low, high, hollow=False):
    """The triangles of a box as STL; of a hollow, they face inwards."""
    corner = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    text = ""
    for a, b, c, d in faces:
        for triangle in ((a, b, c), (a, c, d)):
            points = [corner[i] for i in (triangle[::-1] if hollow else triangle)]
            text += "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in points) + "endloop\nendfacet\n"
    return text


def write_sphere(path, points=20_000, radius=12.0, normals=True):
    """Writes a clean sphere about the origin: Fibonacci lattice, binary PLY."""
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {points}"]
    head += [f"property float {name}" for name in ("x", "y", "z") + (("nx", "ny", "nz") if normals else ())]
    with open(path, "wb") as file:
        file.write(("\n".join(head + ["end_header"]) + "\n").encode())
        for i in range(points):
            z = 1 - 2 * (i + 0.5) / points
            r, angle = math.sqrt(1 - z * z), 2.39996322972865332 * i
            x, y = r * math.cos(angle), r * math.sin(angle)
            file.write(struct.pack("<3f", radius * x, radius * y, radius * z))
            if normals:
                file.write(struct.pack("<3f", x, y, z))


def write_lying_cone(path, radius=10.0, height=25.0, spacing=0.3):
    """Writes an open cone whose axis is x, so that it lies on its side, and would stand if it were turned about y."""
    points, levels = [], round(height / spacing)
    for level in range(levels):
        along = height * level / levels
        r = radius * (1 - along / height)
        count = int(2 * math.pi * r / spacing) + 1
        for i in range(count):
            angle = 2 * math.pi * (i + 0.3 * level) / count
            around = (math.cos(angle), math.sin(angle))
            slope = math.hypot(radius, height)
            points.append((along, r * around[0], r * around[1]))
            points.append((radius / slope, height / slope * around[0], height / slope * around[1]))
    write_oriented(path, points)


def write_ball_on_plinth(path, radius=8.0, plinth=20.0, height=3.0, spacing=0.4):
    """Writes a ball on a round plinth that was never seen from below: its upper side, at z = 0, and its wall."""
    points = []
    count = round(4 * math.pi * (radius / spacing) ** 2)
    for i in range(count):
        z = 1 - 2 * (i + 0.5) / count
        r, angle = math.sqrt(1 - z * z), 2.39996322972865332 * i
        normal = (r * math.cos(angle), r * math.sin(angle), z)
        points += [(radius * normal[0], radius * normal[1], radius * (1 + z)), normal]
    count = round(math.pi * (plinth / spacing) ** 2)
    for i in range(count):
        r, angle = plinth * math.sqrt((i + 0.5) / count), 2.39996322972865332 * i
        points += [(r * math.cos(angle), r * math.sin(angle), 0.0), (0.0, 0.0, 1.0)]
    around = round(2 * math.pi * plinth / spacing)
    for level in range(round(height / spacing) + 1):
        for i in range(around):
            angle = 2 * math.pi * (i + 0.3 * level) / around
            normal = (math.cos(angle), math.sin(angle), 0.0)
            points += [(plinth * normal[0], plinth * normal[1], -spacing * level), normal]
    write_oriented(path, points)


def write_oriented(path, points):
    """@param points  positions, each with its normal after it"""
    with open(path, "wb") as file:
        head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points) // 2}"]
        head += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")]
        file.write(("\n".join(head + ["end_header"]) + "\n").encode())
        for values in points:
            file.write(struct.pack("<3f", *values))


def split(scan, first, top, bottom):
    """Splits a PLY of write_sphere() in two: its first points and the rest."""
    data = scan.read_bytes()
    start = data.index(b"end_header\n") + 11
    head, points, size = data[:start], data[start:], 24
    count = len(points) // size
    for path, part in ((top, points[: first * size]), (bottom, points[first * size :])):
        declared = head.replace(b"vertex %d\n" % count, b"vertex %d\n" % (len(part) // size))
        path.write_bytes(declared + part)


def turn_normals(path, which):
    """Turns over the normals of a file of write_sphere(): those of points i where which(i) is true."""
    data = bytearray(path.read_bytes())
    for i, at in enumerate(range(data.index(b"end_header\n") + 11, len(data), 24)):
        if which(i):
            struct.pack_into("<3f", data, at + 12, *(-n for n in struct.unpack_from("<3f", data, at + 12)))
    path.write_bytes(data)


def add_ball(path, points, radius, centre):
    """Appends another sphere to a file of write_sphere()."""
    data = path.read_bytes()
    start = data.index(b"end_header\n") + 11
    count = (len(data) - start) // 24
    more = path.with_suffix(".more.ply")
    write_sphere(more, points, radius)
    ball = more.read_bytes()
    more.unlink()
    values = [list(v) for v in struct.iter_unpack("<6f", ball[ball.index(b"end_header\n") + 11 :])]
    for v in values:
        for axis in range(3):
            v[axis] += centre[axis]
    head = data[:start].replace(b"vertex %d\n" % count, b"vertex %d\n" % (count + points))
    path.write_bytes(head + data[start:] + b"".join(struct.pack("<6f", *v) for v in values))


def write_board(path, arena_mib=64):
    """403 x 300 pixels of 0.1 mm, 50 mm high."""
    path.write_text(
        f'[printer]\nname = "small"\n[panel]\ncolumns = 403\nrows = 300\npixel_pitch_x_mm = 0.1\npixel_pitch_y_mm = 0.1\n'
        f"[z_stage]\ntravel_mm = 50.0\n[print]\nlayer_height_mm = 0.1\n[memory]\narena_mib = {arena_mib}\n"
    )


def on_stick_printer(folder):
    """Board file of the simulated printer as a rig's: a stick starts its print."""
    path = folder / "sim2k.toml"
    path.write_text(SIM2K.read_text().replace('"on_request"', '"on_stick"'))
    return path


def confirm_plate(state):
    state.mkdir(exist_ok=True)
    (state / "plate-is-empty").touch()


def png_rows(data, bits=1):
    """Columns and row bytes of a greyscale PNG with that many bits a pixel, whose lines have no filter or the one above."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, stream, header = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            stream += body
        at += 12 + length
    columns, rows, depth, colour, _, _, interlace = header
    assert (depth, colour, interlace) == (bits, 0, 0)
    raw, width = zlib.decompress(stream), (columns * bits + 7) // 8
    assert len(raw) == rows * (width + 1) and not set(raw[:: width + 1]) - {0, 2}
    lines, above = [], bytes(width)
    for start in range(0, len(raw), width + 1):
        line = raw[start + 1 : start + 1 + width]
        above = bytes((a + b) & 255 for a, b in zip(line, above)) if raw[start] == 2 else line
        lines.append(above)
    return columns, lines


def mix(z):
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & U64
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & U64
    return z ^ (z >> 31)


def png_depth(data):
    """Bits a pixel of a greyscale PNG."""
    return data[24]


def grey_layer_hash(columns, lines):
    """The hash of a layer, from lines of a byte a pixel."""
    rows, runs = [bytes(-(-columns // 8))] * len(lines), 0
    for r, line in enumerate(lines):
        if not line.strip(b"\0"):
            continue
        bits = "".join("1" if level >= 128 else "0" for level in line).ljust(8 * len(rows[r]), "0")
        rows[r], at = int(bits, 2).to_bytes(len(rows[r]), "big"), 0
        for level, run in itertools.groupby(line):
            count = len(list(run))
            if 0 < level < 255:
                runs += mix(mix(((r * columns + at) << 32) + (count << 16) + level))
            at += count
    return layer_hash(columns, rows, runs)


def layer_hash(columns, rows, runs=0):
    """The hash of a layer as the manifest defines it. @param runs  the sum of its grey ones"""
    total, place = mix((columns << 32) + len(rows)) + runs, 0
    for row in rows:
        row += bytes(-len(row) % 8)
        for (word,) in struct.iter_unpack(">Q", row):
            place += STEP
            if word:
                total += mix((word + place) & U64)
    return mix(total & U64)


def job_hash(layers):
    h = mix(len(layers))
    for layer in layers:
        h = mix((h + STEP + layer) & U64)
    return h


class Program(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="plumbline-")
        self.addCleanup(folder.cleanup)
        self.dir = Path(folder.name)
        self.scan, self.board, self.out = self.dir / "sphere.ply", self.dir / "small.toml", self.dir / "out"
        write_board(self.board)

    def start_daemon(self, *arguments):
        """@returns plumblined, which is killed at the test's end"""
        daemon = subprocess.Popen([PLUMBLINED, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for end in (daemon.stderr.close, daemon.stdout.close, daemon.wait, daemon.kill):  # the last one first
            self.addCleanup(end)
        return daemon

    def until(self, daemon, words):
        """Reads the daemon's log until a line has the words. @returns what it read"""
        said = ""
        for line in daemon.stderr:
            said += line
            if words in line:
                return said
        return self.fail(said)

    def run_it(self, *arguments, status=0, **options):
        done = subprocess.run(
            [PLUMBLINE, *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False, **options
        )
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def cut_below(self, height):
        data = self.scan.read_bytes()
        start = data.index(b"end_header\n") + 11
        points = [data[at : at + 24] for at in range(start, len(data), 24)]
        kept = [point for point in points if struct.unpack("<3f", point[:12])[2] > height]
        head = data[:start].replace(b"vertex %d\n" % len(points), b"vertex %d\n" % len(kept))
        self.scan.write_bytes(head + b"".join(kept))

    def slice_it(self, *arguments, **options):
        """Without supports, unless the arguments have an option of theirs."""
        if not self.scan.exists():
            write_sphere(self.scan)
        if not any(str(argument).startswith("--support") for argument in arguments):
            arguments += ("--supports", "none")
        return self.run_it("slice", self.scan, "-o", self.out, "--printer", self.board, *arguments, **options)

    def layers(self):
        return sorted(path.name for path in (self.out / "layers").iterdir())

    def manifest(self):
        return json.loads((self.out / "manifest.json").read_text())


def main():
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
