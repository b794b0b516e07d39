"""The host's part of the printer: the stage that the steps move, its end stop, and what each light showed."""

import re
import struct
import threading
import time
import zlib
from dataclasses import dataclass

# Lines of the PL061 of QEMU's machine "virt", as board/rig.toml has them.
STEP, LAMP, DIRECTION, END_STOP, COVER, START, ENABLE = 0, 1, 2, 4, 5, 6, 7

STEP_MM = 0.02


@dataclass
class Light:
    """One period in which the lamp was on."""

    steps: int  # height of the stage above the film
    travelled: int  # steps in both directions since the stage was followed
    before: bytes | None  # the panel's picture when the lamp went on; None: the host was too late
    after: bytes | None = None  # and when it went off, on an exact machine
    over: bool = False


class Stage:
    """Follows the lines of a Machine: at each change if the machine is exact, else from a thread, as fast as it can."""

    def __init__(self, machine, steps, end_stop):
        """@param steps, end_stop  where the stage is, and where it meets its end stop: steps from the film"""
        self.machine, self.steps, self.end_stop = machine, steps, end_stop
        self.travelled, self.lights, self.trouble = 0, [], []
        self.on_light = None  # called with the light's number, on an exact machine at that instant
        # Drop earlier changes: they belong to another stage.
        self.seen, self.level, self.pressed, self.ended = len(machine.edges), dict(machine.level), None, False
        if machine.gate:
            self._press()
            machine.gate.at_change = self._see_exactly
        else:
            self.thread = threading.Thread(target=self._follow, daemon=True)
            self.thread.start()

    def lit(self):
        return bool(self.lights) and not self.lights[-1].over

    def end(self):
        self.ended = True
        if self.machine.gate:
            self.machine.gate.at_change = None
        else:
            self.thread.join()

    def _see_exactly(self):
        self.machine.read_edges()
        self._see()

    def _follow(self):
        while not self.ended:
            self._see()
            time.sleep(0.0005)

    def _see(self):
        while self.seen < len(self.machine.edges):
            line, up = self.machine.edges[self.seen]
            self.seen += 1
            if self.level.get(line, False) == up:
                continue
            self.level[line] = up
            if line == STEP and up:
                self._step()
            elif line == LAMP and up:
                light = Light(self.steps, self.travelled, self.machine.picture())
                self.machine.read_edges()
                if (LAMP, False) in self.machine.edges[self.seen :]:
                    light.before = None
                self.lights.append(light)
                if self.on_light:
                    self.on_light(len(self.lights) - 1)
            elif line == LAMP and self.lights:
                self.lights[-1].after = self.machine.picture() if self.machine.gate else None
                self.lights[-1].over = True
        self._press()

    def _step(self):
        self.steps += 1 if self.level.get(DIRECTION) else -1
        self.travelled += 1
        if self.level.get(LAMP):
            self.trouble.append(f"light {len(self.lights) - 1}: a step under it")
        if not self.level.get(ENABLE):
            self.trouble.append(f"light {len(self.lights)}: a step before it, of a motor that is off")

    def _press(self):
        pressed = self.steps >= self.end_stop
        if pressed != self.pressed:
            self.pressed = pressed
            self.machine.set_line(END_STOP, pressed)


def objections(lights, masks, layer_steps, lift_steps, first=0):
    """What is wrong with a print's lights, a sentence each; lights count from 0. Missing pictures are skipped.

    @param masks        the expected pictures, a byte a pixel, one for each light
    @param layer_steps  of one layer
    @param lift_steps   of the lift between two layers
    @param first        layer of the first light
    """
    found = [] if len(lights) == len(masks) else [f"{len(lights)} lights for {len(masks)} layers"]
    for number, (light, mask) in enumerate(zip(lights, masks)):
        off = light.steps - (first + number + 1) * layer_steps
        if off:
            found.append(f"light {number}: {abs(off)} steps too {'high' if off > 0 else 'low'}")
        travel = light.travelled - lights[number - 1].travelled
        if number and travel != 2 * lift_steps - layer_steps:
            found.append(f"light {number}: {travel} steps before it and not {2 * lift_steps - layer_steps}")
        for picture, when in ((light.before, "at its beginning"), (light.after, "at its end")):
            if picture not in (None, mask):
                wrong = sum(a != b for a, b in zip(picture, mask, strict=True))
                found.append(f"light {number}: {wrong} pixels wrong {when}")
    return found


def mask_pixels(path):
    """A mask's PNG, 1 bit, whose lines have no filter or the one above, as a byte a pixel."""
    data, at, stream = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            columns, rows = struct.unpack(">II", body[:8])
        if kind == b"IDAT":
            stream += body
        at += 12 + length
    raw, width = zlib.decompress(stream), 1 + (columns + 7) // 8
    assert not set(raw[::width]) - {0, 2}, "another filter"
    pixels, line = bytearray(), bytes(width - 1)
    for row in range(rows):
        above, line = line, raw[row * width + 1 : (row + 1) * width]
        if raw[row * width] == 2:
            line = bytes((a + b) & 255 for a, b in zip(line, above, strict=True))
        bits = bin(int.from_bytes(b"\1" + line, "big"))[3:]
        pixels += bits[:columns].encode()
    return bytes(pixels).translate(bytes.maketrans(b"01", b"\0\xff"))


def trace_times(text, gpio):
    """(guest seconds, level) of one line, from the kernel's trace."""
    found = re.findall(rf"([0-9]+\.[0-9]+): gpio_value: {gpio} set ([01])", text)
    return [(float(at), level == "1") for at, level in found]


def intervals(times):
    """Seconds of each period in which a line was on, from trace_times()."""
    on, found = None, []
    for at, level in times:
        if level and on is None:
            on = at
        elif not level and on is not None:
            found.append(at - on)
            on = None
    return found
