"""An emulated ARM board under QEMU: its shell, its lines, its panel's picture, its sticks."""

import json
import select
import socket
import subprocess
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent


class Channel:
    """Lines of text over one of QEMU's sockets."""

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


class Gate:
    """The host's end of line_gate.c: the emulated processor stops at every change of a line until at_change() returns."""

    def __init__(self, folder):
        self.library, path = folder / "line_gate.so", folder / "gate"
        command = ["gcc", "-std=c11", "-D_GNU_SOURCE", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]
        subprocess.run([*command, "-fvisibility=hidden", "-o", self.library, HERE / "line_gate.c"], check=True)
        self.option = f"{self.library},socket={path}"
        self.at_change, self.failed = None, None
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(path))
        self.listener.listen(1)
        # Serve the gate from the first change on, since drivers set lines while the guest boots.
        threading.Thread(target=self._answer, daemon=True).start()

    def _answer(self):
        questions = self.listener.accept()[0]
        self.listener.close()
        with questions:
            while not self.failed and questions.recv(16):
                if self.at_change:
                    try:
                        self.at_change()
                    except Exception as problem:  # reported by whoever waits for the guest, which ends now
                        self.failed = problem
                        break
                questions.sendall(b".")


class Machine:
    """
    The usual kind has two processors and runs in real time, when the host gives it time. With a gate the machine is exact: its one
    processor's clock counts instructions, 2 ns each, and the processor stands still while the host looks at a line.
    """

    def __init__(self, folder, kernel, initramfs, arch="arm64", memory_mb=256, disk=None, panel=(640, 480), gate=None, screen=None):
        self.folder, self.panel, self.gate = folder, panel, gate
        self.events, self.edges, self.level = [], [], {}
        self.kernel_resets = 0
        self.answers, self.answered, self.asking = [], threading.Condition(), threading.Lock()
        program, cpu, board = {
            "arm64": ("qemu-system-aarch64", "cortex-a53", "virt"),
            "armhf": ("qemu-system-arm", "cortex-a7", "virt,highmem=off"),
        }[arch]
        command = [program, "-M", board, "-cpu", cpu, "-m", str(memory_mb)]
        if gate:
            command += ["-smp", "1", "-accel", "tcg,thread=single", "-icount", "shift=1,sleep=off", "-plugin", gate.option]
        else:
            command += ["-smp", "2", "-accel", "tcg,thread=multi"]
        command += ["-display", "none", "-nic", "none", "-nodefaults", "-kernel", kernel, "-initrd", initramfs]
        command += ["-append", "console=ttyAMA0 rdinit=/init quiet panic=-1", "-serial", f"file:{folder}/console"]
        for name in ("qmp", "qtest"):
            command += [f"-{name}", f"unix:{folder}/{name},server=on,wait=off"]
        command += ["-qtest-log", "/dev/null", "-device", "virtio-serial-pci"]
        command += ["-chardev", f"socket,id=shell,path={folder}/shell,server=on,wait=off"]
        command += ["-device", "virtserialport,chardev=shell", "-device", "qemu-xhci,id=xhci"]
        command += ["-device", "i6300esb", "-action", "watchdog=reset"]
        command += ["-device", f"virtio-gpu-pci,id=panel,xres={panel[0]},yres={panel[1]}"]
        if screen:
            command += ["-device", f"virtio-gpu-pci,id=screen,xres={screen[0]},yres={screen[1]}"]
        if disk:
            command += ["-drive", f"if=virtio,format=raw,file={disk},cache=writethrough"]
        self.out = open(folder / "qemu", "w", encoding="utf-8")
        self.process = subprocess.Popen(list(map(str, command)), stdin=subprocess.DEVNULL, stdout=self.out, stderr=self.out)
        self.shell, self.monitor = Channel(folder / "shell"), Channel(folder / "qmp")
        self.pins = Channel(folder / "qtest")
        self.monitor.line(20)
        self.ask("qmp_capabilities")
        # QEMU stops while its messages about the lines are not read, so a thread reads them.
        threading.Thread(target=self._follow_pins, daemon=True).start()
        self.gpio = self._find("pl061")
        assert self.pin(f"irq_intercept_out {self.gpio}") == "OK"

    def until_booted(self, seconds=180):
        while self.shell.line(seconds) != "ready":
            pass

    def run(self, command, seconds=180):
        """@returns (status, output)"""
        self.shell.send(command)
        said = []
        while True:
            try:
                line = self.shell.line(seconds)
            except EOFError:
                if self.gate and self.gate.failed:
                    raise self.gate.failed
                raise
            if line.startswith("@status "):
                return int(line.split()[1]), "\n".join(said)
            said.append(line)

    def ask(self, what, **arguments):
        with self.asking:
            self.monitor.send(json.dumps({"execute": what, "arguments": arguments}))
            while True:
                answer = json.loads(self.monitor.line(60))
                if "event" in answer:
                    self.events.append(answer)
                elif "error" in answer:
                    raise RuntimeError(f"{what}: {answer['error']}")
                else:
                    return answer["return"]

    def reset_by_watchdog(self):
        """Whether a watchdog has reset the guest since this was last asked: QEMU's, or the kernel's, which says so on the console."""
        self.ask("query-status")
        by_qemu = any(event["event"] == "WATCHDOG" for event in self.events)
        before = self.kernel_resets
        self.kernel_resets = (self.folder / "console").read_bytes().count(b"softdog: Initiating system reboot")
        if not by_qemu and self.kernel_resets == before:
            return False
        self.events.clear()
        return True

    def pin(self, command):
        """@returns QEMU's answer; all edges before it are in `edges` by then"""
        with self.answered:
            self.pins.send(command)
            assert self.answered.wait_for(lambda: self.answers, 30), command
            return self.answers.pop(0)

    def read_edges(self):
        self.pin("readl 0x090303fc")  # the levels of all lines; only the answer matters

    def set_line(self, line, level):
        self.pin(f"set_irq_in {self.gpio} unnamed-gpio-in {line} {int(level)}")

    def _follow_pins(self):
        try:
            while True:
                line = self.pins.line(1e6)
                if line.startswith("IRQ "):
                    _, kind, number = line.split()
                    self.level[int(number)] = kind == "raise"
                    self.edges.append((int(number), kind == "raise"))
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
        """The panel's picture, a byte a pixel."""
        columns, rows, pixels = self.colours("panel")
        assert (columns, rows) == self.panel, (columns, rows)
        red = pixels[0::3]
        assert red == pixels[1::3] == pixels[2::3], "a colour on a panel without colours"
        return red

    def colours(self, display):
        """(columns, rows, RGB) of what "panel" or "screen" shows."""
        path = self.folder / f"{display}.ppm"
        self.ask("screendump", filename=str(path), device=display)
        data = path.read_bytes().split(b"\n", 3)
        assert data[0] == b"P6", data[0]
        columns, rows = map(int, data[1].split())
        return columns, rows, data[3]

    def plug(self, name, image, bytes_per_second=None, bad_sector=None, writable=False):
        file = {"driver": "file", "filename": str(image), "read-only": not writable}
        if bad_sector is not None:
            error = {"event": "none", "iotype": "read", "sector": bad_sector, "errno": 5, "once": False}
            file = {"driver": "blkdebug", "inject-error": [error], "image": file}
        top = f"raw-{name}"
        self.ask("blockdev-add", **{"driver": "raw", "node-name": top, "read-only": not writable, "file": file})
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
