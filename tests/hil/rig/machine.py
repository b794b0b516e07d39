"""An emulated ARM board under QEMU: its shell, its lines, its panel's picture, its sticks."""

import json
import re
import select
import socket
import struct
import subprocess
import threading
import time
import zlib

# Lines of the PL061 of QEMU's machine "virt", as board/rig.toml has them.
STEP, LAMP, DIRECTION, END_STOP, COVER, START, ENABLE = 0, 1, 2, 4, 5, 6, 7

STEP_MM = 0.02
END_STOP_MM = 32.0


class Channel:
    """Lines of text over a socket of QEMU's."""

    def __init__(self, path, seconds=20):
        self.socket, self.rest = socket.socket(socket.AF_UNIX), b""
        until = time.monotonic() + seconds
        while True:
            try:
                self.socket.connect(str(path))
                return
            except OSError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.02)

    def send(self, text):
        self.socket.sendall(text.encode() + b"\n")

    def line(self, seconds):
        until = time.monotonic() + seconds
        while b"\n" not in self.rest:
            ready = select.select([self.socket], [], [], max(0, until - time.monotonic()))[0]
            if not ready:
                raise TimeoutError(f"nothing more came after {self.rest[-200:]!r}")
            data = self.socket.recv(65536)
            if not data:
                raise EOFError("QEMU has ended")
            self.rest += data
        line, self.rest = self.rest.split(b"\n", 1)
        return line.decode(errors="replace").rstrip("\r")


class Machine:
    def __init__(self, folder, kernel, initramfs, arch="arm64", memory_mb=256, disk=None):
        self.folder, self.events, self.edges = folder, [], []
        self.answers, self.answered = [], threading.Condition()
        self.level = {}
        program, cpu, board = {
            "arm64": ("qemu-system-aarch64", "cortex-a53", "virt"),
            "armhf": ("qemu-system-arm", "cortex-a7", "virt,highmem=off"),
        }[arch]
        command = [program, "-M", board, "-cpu", cpu, "-smp", "2", "-m", str(memory_mb), "-accel", "tcg,thread=multi"]
        command += ["-display", "none", "-nic", "none", "-nodefaults", "-kernel", kernel, "-initrd", initramfs]
        command += ["-append", "console=ttyAMA0 rdinit=/init quiet panic=-1", "-serial", f"file:{folder}/console"]
        for name in ("qmp", "qtest"):
            command += [f"-{name}", f"unix:{folder}/{name},server=on,wait=off"]
        command += ["-qtest-log", "/dev/null", "-device", "virtio-serial-pci"]
        command += ["-chardev", f"socket,id=shell,path={folder}/shell,server=on,wait=off"]
        command += ["-device", "virtserialport,chardev=shell", "-device", "qemu-xhci,id=xhci"]
        command += ["-device", "virtio-gpu-pci,id=panel,xres=640,yres=480"]
        if disk:
            command += ["-drive", f"if=virtio,format=raw,file={disk},cache=writethrough"]
        self.out = open(folder / "qemu", "w", encoding="utf-8")
        self.process = subprocess.Popen(list(map(str, command)), stdin=subprocess.DEVNULL, stdout=self.out, stderr=self.out)
        self.shell, self.monitor = Channel(folder / "shell"), Channel(folder / "qmp")
        self.pins = Channel(folder / "qtest")
        self.monitor.line(20)
        self.ask("qmp_capabilities")
        # QEMU stands still while nobody takes what it says of the lines, so a thread does nothing else.
        threading.Thread(target=self._follow_pins, daemon=True).start()
        self.gpio = self._find("pl061")
        assert self.pin(f"irq_intercept_out {self.gpio}") == "OK"

    def until_booted(self, seconds=180):
        while self.shell.line(seconds) != "ready":
            pass

    def run(self, command, seconds=60):
        """@returns (status, what the command said)"""
        self.shell.send(command)
        said = []
        while True:
            line = self.shell.line(seconds)
            if line.startswith("@status "):
                return int(line.split()[1]), "\n".join(said)
            said.append(line)

    def ask(self, what, **arguments):
        self.monitor.send(json.dumps({"execute": what, "arguments": arguments}))
        while True:
            answer = json.loads(self.monitor.line(60))
            if "event" in answer:
                self.events.append(answer)
            elif "error" in answer:
                raise RuntimeError(f"{what}: {answer['error']}")
            else:
                return answer["return"]

    def pin(self, command):
        with self.answered:
            self.pins.send(command)
            assert self.answered.wait_for(lambda: self.answers, 30), command
            return self.answers.pop(0)

    def set_line(self, line, level):
        self.pin(f"set_irq_in {self.gpio} unnamed-gpio-in {line} {int(level)}")

    def _follow_pins(self):
        try:
            while True:
                line = self.pins.line(1e6)
                if line.startswith("IRQ "):
                    _, kind, number = line.split()
                    self.level[int(number)] = kind == "raise"
                    self.edges.append((time.monotonic(), int(number), kind == "raise"))
                else:
                    with self.answered:
                        self.answers.append(line)
                        self.answered.notify()
        except (OSError, EOFError):
            pass

    def _find(self, kind, path="/machine", depth=0):
        for child in self.ask("qom-list", path=path):
            at = f"{path}/{child['name']}"
            if child["type"] == f"child<{kind}>":
                return at
            found = self._find(kind, at, depth + 1) if child["type"].startswith("child<") and depth < 2 else None
            if found:
                return found
        return None

    def picture(self):
        """What the panel shows, a byte a pixel."""
        path = self.folder / "panel.ppm"
        self.ask("screendump", filename=str(path), device="panel")
        data = path.read_bytes().split(b"\n", 3)
        assert data[0] == b"P6" and data[1] == b"640 480", data[:2]
        red = data[3][0::3]
        assert red == data[3][1::3] == data[3][2::3], "a colour on a panel without colours"
        return red

    def plug(self, name, image, bytes_per_second=None, bad_sector=None):
        file = {"driver": "file", "filename": str(image), "read-only": True}
        if bad_sector is not None:
            error = {"event": "none", "iotype": "read", "sector": bad_sector, "errno": 5, "once": False}
            file = {"driver": "blkdebug", "inject-error": [error], "image": file}
        top = f"raw-{name}"
        self.ask("blockdev-add", **{"driver": "raw", "node-name": top, "read-only": True, "file": file})
        if bytes_per_second:
            group = {"qom-type": "throttle-group", "id": f"limit-{name}", "limits": {"bps-total": bytes_per_second}}
            self.ask("object-add", **group)
            slow = {"driver": "throttle", "node-name": f"slow-{name}", "throttle-group": f"limit-{name}", "file": top}
            self.ask("blockdev-add", **slow, **{"read-only": True})
            top = f"slow-{name}"
        self.ask("device_add", driver="usb-storage", id=name, bus="xhci.0", drive=top, serial=name, removable=True)

    def pull(self, name):
        self.ask("device_del", id=name)
        until = time.monotonic() + 20
        while not any(e["event"] == "DEVICE_DELETED" and e["data"].get("device") == name for e in self.events):
            assert time.monotonic() < until, "the stick does not leave"
            self.ask("query-status")
            time.sleep(0.01)
        self.events.clear()

    def end(self):
        self.process.kill()
        self.process.wait()
        self.out.close()
        for channel in (self.shell, self.monitor, self.pins):
            channel.socket.close()


class Stage:
    """The host's part of the printer: the plate that the steps move, and the end stop that it presses."""

    def __init__(self, machine, height_mm=30.5):
        self.machine, self.steps = machine, round(height_mm / STEP_MM)
        self.travelled, self.lights, self.trouble = 0, [], []
        self.on_light = None
        # What the lines did before is another stage's.
        self.seen, self.pressed, self.ended = len(machine.edges), None, False
        self.thread = threading.Thread(target=self._follow, daemon=True)
        self.thread.start()

    def height(self):
        return self.steps * STEP_MM

    def lit(self):
        return bool(self.lights) and self.lights[-1][1] is None

    def _follow(self):
        machine, level = self.machine, dict(self.machine.level)
        while not self.ended:
            while self.seen < len(machine.edges):
                at, line, up = machine.edges[self.seen]
                self.seen += 1
                level[line] = up
                if line == STEP and up:
                    self.steps += 1 if level.get(DIRECTION) else -1
                    self.travelled += 1
                    if level.get(LAMP):
                        self.trouble.append("a step under light")
                if line == LAMP and up:
                    self.lights.append([at, None, self.steps])
                    if self.on_light:
                        self.on_light(len(self.lights) - 1)
                if line == LAMP and not up and self.lit():
                    self.lights[-1][1] = at
            pressed = self.height() >= END_STOP_MM - STEP_MM / 2
            if pressed != self.pressed:
                self.pressed = pressed
                machine.set_line(END_STOP, pressed)
            time.sleep(0.0005)

    def end(self):
        self.ended = True
        self.thread.join()


def mask_pixels(path):
    """A mask's PNG, 1 bit and unfiltered, as a byte a pixel."""
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
    assert not any(raw[::width]), "a filter"
    pixels = bytearray()
    for row in range(rows):
        bits = bin(int.from_bytes(b"\1" + raw[row * width + 1 : (row + 1) * width], "big"))[3:]
        pixels += bits[:columns].encode()
    return bytes(pixels).translate(bytes.maketrans(b"01", b"\0\xff"))


def trace_times(text, gpio):
    """(s in the guest's time, level) of one line, from the kernel's own trace of its lines."""
    found = re.findall(rf"([0-9]+\.[0-9]+): gpio_value: {gpio} set ([01])", text)
    return [(float(at), level == "1") for at, level in found]
