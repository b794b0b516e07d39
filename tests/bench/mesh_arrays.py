"""Meshes of a folder as arrays of triangles, scaled, damaged and written as STL."""

import re
import struct

import numpy as np


def fan(faces):
    return [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]


def from_indices(corners, faces):
    return np.array(corners, np.float64)[:, :3][np.array(fan(faces), np.int64)]


def read_stl(data):
    if len(data) >= 84 and len(data) == 84 + 50 * struct.unpack_from("<I", data, 80)[0]:
        return np.frombuffer(data, np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]), offset=84)["v"].astype(np.float64)
    numbers = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data)
    return np.array(numbers, np.float64).reshape(-1, 3, 3)


def read_obj(data):
    corners, faces = [], []
    for words in (line.split() for line in data.decode("latin-1").splitlines()):
        if words[:1] == ["v"]:
            corners.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            faces.append([n - 1 if n > 0 else len(corners) + n for n in numbers])
    return from_indices(corners, faces)


def read_off(data):
    lines = [line for line in (line.split("#")[0].split() for line in data.decode("latin-1").splitlines()) if line]
    if lines[0] == ["OFF"]:
        lines = lines[1:]
    vertices, faces = int(lines[0][0]), int(lines[0][1])
    return from_indices([[float(word) for word in line[:3]] for line in lines[1 : vertices + 1]],
                        [[int(word) for word in line[1 : int(line[0]) + 1]] for line in lines[vertices + 1 : vertices + 1 + faces]])  # fmt: skip


def read_ply(data):
    head, body = data.split(b"end_header", 1)
    body = body.split(b"\n", 1)[1]
    codes = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H", "int": "i",
             "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d"}  # fmt: skip
    elements, text, order = [], False, "<"
    for words in (line.split() for line in head.decode("latin-1").splitlines()):
        if words[:1] == ["format"]:
            text, order = words[1] == "ascii", ">" if "big" in words[1] else "<"
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    tokens, at = iter(body.split()) if text else None, 0

    def take(kind, count):
        nonlocal at
        if text:
            return [float(next(tokens)) for _ in range(count)]
        values = struct.unpack_from(f"{order}{count}{codes[kind]}", body, at)
        at += struct.calcsize(f"{order}{count}{codes[kind]}")
        return values

    corners, faces = [], []
    for element, count, properties in elements:
        for _ in range(count):
            row = {}
            for kind, *rest in properties:
                row[rest[-1]] = take(kind, 1)[0] if kind != "list" else [int(n) for n in take(rest[1], int(take(rest[0], 1)[0]))]
            if element == "vertex":
                corners.append([row["x"], row["y"], row["z"]])
            elif element == "face":
                faces.append(row["vertex_indices"] if "vertex_indices" in row else row["vertex_index"])
    return from_indices(corners, faces)


READERS = {".stl": read_stl, ".obj": read_obj, ".off": read_off, ".ply": read_ply}


class UnfitMesh(Exception):
    """A file that is left out, and why."""


def scaled(triangles, longest):
    """Onto the plate, its longest side as given, in the numbers of an STL."""
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    return ((triangles - low) * (longest / (high - low).max())).astype(np.float32)


def damaged(triangles, kind, one_in):
    chosen = np.random.default_rng(1).permutation(len(triangles))[: max(1, len(triangles) // one_in)]
    if kind == "missing":
        return np.delete(triangles, chosen, axis=0)
    if kind == "doubled":
        return np.concatenate([triangles, triangles[chosen]])
    turned = triangles.copy()
    turned[chosen] = turned[chosen][:, ::-1]
    return turned


def write_stl(path, triangles):
    records = np.zeros(len(triangles), np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]))
    records["v"] = triangles
    path.write_bytes(bytes(80) + struct.pack("<I", len(triangles)) + records.tobytes())


def prepare(path, longest, thinnest, most, kind, one_in, whole, copy):
    """Writes a mesh, and a damaged copy.

    Raises UnfitMesh."""
    try:
        triangles = READERS[path.suffix.lower()](path.read_bytes())
        if not 4 <= len(triangles) <= most:
            raise UnfitMesh(f"{len(triangles)} triangles")
        triangles = scaled(triangles, longest)
    except (ValueError, IndexError, KeyError, StopIteration, struct.error) as error:
        raise UnfitMesh(f"{type(error).__name__}: {error}") from error
    if not np.isfinite(triangles).all() or (np.ptp(triangles, axis=(0, 1)) < thinnest).any():
        raise UnfitMesh("flat, or not finite")
    write_stl(whole, triangles)
    write_stl(copy, damaged(triangles, kind, one_in))
