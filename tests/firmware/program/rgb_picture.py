"""Reads a PNG of a picture. It shares no code with plumbline."""

import struct
import zlib


def rgb_rows(path, most=None):
    """(columns, the first rows of pixels) of a PNG file."""
    return rows_of(path.read_bytes(), most)


def rows_of(data, most=None):
    """(columns, the first rows of pixels) of a PNG: 3 bytes a pixel, or 4 with its opacity."""
    at, stream, palette = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            columns, rows, depth, colour = struct.unpack(">IIBB", body[:10])
        elif kind == b"PLTE":
            palette = [body[i : i + 3] for i in range(0, length, 3)]
        elif kind == b"IDAT":
            stream += body
        at += 12 + length
    bits = depth * {2: 3, 6: 4}.get(colour, 1)  # grey and palette: 1
    width, step = (columns * bits + 7) // 8, max(1, bits // 8)
    raw, before, lines = zlib.decompress(stream), bytearray(width), []
    for r in range(min(rows, most or rows)):
        kind, line = raw[r * (width + 1)], bytearray(raw[r * (width + 1) + 1 : (r + 1) * (width + 1)])
        for i in range(width):
            left = line[i - step] if i >= step else 0
            up, corner = before[i], before[i - step] if i >= step else 0
            nearest = min((left, up, corner), key=lambda value, guess=left + up - corner: abs(guess - value))
            line[i] = (line[i] + (0, left, up, (left + up) // 2, nearest)[kind]) & 255
        before = line
        if palette:
            pixels = (line[c * depth // 8] >> (8 - depth - c * depth % 8) & ((1 << depth) - 1) for c in range(columns))
            lines.append(b"".join(palette[pixel] for pixel in pixels))
        else:
            lines.append(bytes(line))
    return columns, lines
