"""What prints cure, beside the rules of other slicers: deviation from the true surface, um, in pixels and layers of 50 um.

    compare_cured.py BUILD_FOLDER [OBJECT...]

All is judged by the simulator: doses of the profile `standard`, blur of half a pixel. plumbline prints each object, raised on supports; points beside these
do not count. The others' rules are coded from their documentation, on exact coverage of pixels (8 x 8 samples each), hanging in the air:
  PrusaSlicer  gamma 1: a pixel's grey is its coverage; zcorrection_layers 4: it stays only if the 4 layers below have it, too
  UVtools      light bleed compensation, DimBy 25, 15, 10, 5, least 200 of 255, on masks of one bit
"""

import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import cured_objects

SOURCE = Path(__file__).resolve().parents[2]
PIXEL_MM, SAMPLES = 0.05, 8
RAISED = 24  # layers of air below an object whose layers come from elsewhere
FIGURES = ("rms", "down_mean", "down_rms", "wall_mean", "wall_rms", "top_rms")


def write_png(path, grey):
    rows, columns = grey.shape
    raw = np.hstack([np.zeros((rows, 1), np.uint8), grey]).tobytes()
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b""))


def read_png(path):
    """A PNG of plumbline: one bit a pixel."""
    data, at, packed, size = path.read_bytes(), 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"IHDR":
            size = struct.unpack(">II", data[at + 8 : at + 16])
        elif kind == b"IDAT":
            packed += data[at + 8 : at + 8 + length]
        at += 12 + length
    columns, rows = size
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(rows, -1)
    out, above = np.zeros((rows, lines.shape[1] - 1), np.uint8), np.zeros(lines.shape[1] - 1, np.uint8)
    for r in range(rows):
        if lines[r, 0] not in (0, 2):
            raise ValueError(f"{path}: an unexpected filter")
        above = out[r] = lines[r, 1:] + above if lines[r, 0] == 2 else lines[r, 1:]
    return np.unpackbits(out, axis=1)[:, :columns]


def coverage_of(plumbline, mesh, folder):
    """Coverage of each pixel and layer, 0 to 1, and where the mesh stands."""
    run = [plumbline, "slice", mesh, "-o", folder, "--pixel-pitch", str(PIXEL_MM / SAMPLES), "--layer-height", str(PIXEL_MM), "--no-preview", "--quiet", "--supports", "none", "--accept"]
    subprocess.run(run, check=True)
    layers = []
    for path in sorted((folder / "layers").glob("*.png")):
        fine = read_png(path)
        fine = np.pad(fine, [(0, -n % SAMPLES) for n in fine.shape])
        layers.append(fine.reshape(fine.shape[0] // SAMPLES, SAMPLES, -1, SAMPLES).mean(axis=(1, 3)))
    manifest = json.loads((folder / "manifest.json").read_text())
    transform = np.array(manifest["placement"]["transform"] if "placement" in manifest else manifest["transform"], float).reshape(4, 4)
    return np.concatenate([np.zeros((RAISED, *layers[0].shape)), layers, np.zeros((1, *layers[0].shape))]), transform[:3, 3]


def one_bit(coverage):
    return (coverage >= 0.5) * 255.0


def prusaslicer(coverage, layers=4):
    kept = coverage.copy()
    for n in range(1, layers + 1):
        kept[n:] = np.minimum(kept[n:], coverage[:-n])
    return kept * 255


def uvtools(coverage, dim_by=(25, 15, 10, 5), least=200):
    lit = coverage >= 0.5
    grey = lit * 255.0
    for n, dim in enumerate(dim_by, 1):
        grey[:-n] -= dim * (lit[:-n] & lit[n:])
    return np.where(lit, np.maximum(grey, least), 0)


def judge_layers(build, grey, shift, mesh, folder, exchange):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for k, layer in enumerate(np.rint(grey).astype(np.uint8)):
        write_png(folder / f"{k:05}.png", layer)
    x, y, z = shift
    values = {"x": x, "y": y, "z": z + RAISED * PIXEL_MM, "exchange": exchange}
    run = [build / "tests/cured_layers", folder, mesh, *(f"{key}={value}" for key, value in values.items())]
    return json.loads(subprocess.run(run, check=True, capture_output=True, text=True).stdout)


def board_of(folder, exchange, corrects):
    (folder / "profiles").mkdir(parents=True, exist_ok=True)
    board = (SOURCE / "board/sim2k.toml").read_text()
    (folder / "sim2k.toml").write_text(board.replace("= 0.04725 ", f"= {PIXEL_MM} "))
    profile = (SOURCE / "board/profiles/standard.toml").read_text()
    (folder / "profiles/standard.toml").write_text(profile.replace("exchange = 0.0", f"exchange = {exchange}" if corrects else ""))
    return folder / "sim2k.toml"


def print_it(build, mesh, board, folder, *more):
    report = folder / "report.json"
    run = [build / "firmware/plumbline", "print", mesh, "--printer", board, "--supports", "auto", "--support-stand", "raised", "--accept", "--truth", mesh, "--report", report, "--quiet", *more]
    subprocess.run(run, check=True)
    return json.loads(report.read_text())["part"]["deviation_um"]


def show(name, row, found):
    cells = [f"{found[key]:+.1f}" if key.endswith("mean") and found.get(key) is not None else "" if found.get(key) is None else f"{found[key]:.1f}" for key in FIGURES]
    print(f"| {name} | {row} | " + " | ".join(cells) + f" | {100 * found['missing'] / found['points']:.1f} |", flush=True)


def main():
    build, only = Path(sys.argv[1]).resolve(), sys.argv[2:]
    print("| object | print | " + " | ".join(FIGURES) + " | missing, % |\n|" + "---|" * (len(FIGURES) + 3))
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        boards = {key: board_of(folder / str(i), *key) for i, key in enumerate(((0, False), (0, True), (1, True)))}
        for name, triangles in cured_objects.objects():
            if only and not any(word in name for word in only):
                continue
            mesh = folder / "object.stl"
            cured_objects.write_stl(mesh, triangles)
            shutil.rmtree(folder / "fine", ignore_errors=True)
            coverage, shift = coverage_of(build / "firmware/plumbline", mesh, folder / "fine")
            for row, rule in (("1 bit", one_bit), ("PrusaSlicer", prusaslicer), ("UVtools", uvtools)):
                show(name, row, judge_layers(build, rule(coverage), shift, mesh, folder / "layers", 0))
            show(name, "ours, not corrected", print_it(build, mesh, boards[0, False], folder))
            show(name, "ours", print_it(build, mesh, boards[0, True], folder))
            show(name, "ours, grey", print_it(build, mesh, boards[0, True], folder, "--grey", "vertical"))
            show(name, "ours, grey, outlines -.02 mm", print_it(build, mesh, boards[0, True], folder, "--grey", "vertical", "--absolute-correction", "-0.02"))
            show(name, "ours, grey, exchange 1", print_it(build, mesh, boards[1, True], folder, "--grey", "vertical"))
            show(name, "ours, full grey", print_it(build, mesh, boards[0, True], folder, "--grey", "full"))
            show(name, "ours, full grey, outlines -.02 mm", print_it(build, mesh, boards[0, True], folder, "--grey", "full", "--absolute-correction", "-0.02"))
            show(name, "ours, full grey, exchange 1", print_it(build, mesh, boards[1, True], folder, "--grey", "full"))
            show(name, "ours, adaptive layers", print_it(build, mesh, boards[0, True], folder, "--layer-height", "adaptive"))
            show(name, "ours, adaptive layers, full grey, outlines -.02 mm", print_it(build, mesh, boards[0, True], folder, "--layer-height", "adaptive", "--grey", "full", "--absolute-correction", "-0.02"))


if __name__ == "__main__":
    main()
