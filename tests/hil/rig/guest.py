"""Makes what an emulated board boots: a kernel, and an initramfs with plumbline's programs and Debian packages."""

import os
import re
import shutil
import stat
import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE = HERE.parents[2]

# Root packages of the guest's system; apt-get adds what they depend on.
PACKAGES = (
    "busybox-static udev libgomp1 libstdc++6 libdrm2 libgpiod2 libusb-1.0-0 libexpat1 zlib1g libspng0 libminizip1 libfreetype6 libqrencode4 "
    "libseccomp2"
).split()
# Of the guest whose first process is systemd; dpkg installs plumbline's package there.
SYSTEMD_PACKAGES = (
    "busybox-static base-files base-passwd coreutils dash dbus dpkg grep libc-bin mount passwd sed systemd systemd-sysv tar udev util-linux "
    "libgomp1 libstdc++6 libdrm2 libgpiod2 libusb-1.0-0 libexpat1 zlib1g libspng0 libminizip1 libfreetype6 libqrencode4 "
    "libseccomp2"
).split()
KERNEL = {"arm64": "arm64", "armhf": "armmp"}
TRIPLET = {"arm64": "aarch64-linux-gnu", "armhf": "arm-linux-gnueabihf"}

# Watchdogs, the first of which the kernel has is used. Debian's kernel for armhf has no driver of QEMU's i6300esb, but one that counts
# in the kernel: it resets a board whose processes hang, though not one whose kernel does.
WATCHDOGS = ("i6300esb", "softdog")
# Modules that Debian's kernels don't have built in: the bus and its console, panel, sticks and their file systems, the board's own disk.
MODULES = (
    "virtio_pci virtio_mmio virtio_console virtio_blk virtio_gpu xhci_pci usb_storage uas sd_mod vfat exfat "
    "nls_cp437 nls_ascii nls_utf8 nls_iso8859_1 ext4 crc32c_generic"
).split()


def cache():
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "plumbline" / "rig"


def make_root(arch):
    """Fetches the guest's packages once. PLUMBLINE_RIG_KERNEL, such as 6.1.0-30, pins the kernel; else it is the newest."""
    pinned = os.environ.get("PLUMBLINE_RIG_KERNEL")
    kernel = f"linux-image-{pinned}-{KERNEL[arch]}" if pinned else f"linux-image-{KERNEL[arch]}"
    root = cache() / arch / "root"
    subprocess.run([SOURCE / "toolchains" / "make_sysroot", arch, root, kernel, *PACKAGES], check=True)
    return root


def make_systemd_root(arch):
    """Fetches the packages of the guest with systemd once."""
    root = cache() / arch / "systemd"
    subprocess.run([SOURCE / "toolchains" / "make_sysroot", arch, root, *SYSTEMD_PACKAGES], check=True)
    return root


def kernel_of(root):
    return next(root.glob("boot/vmlinuz-*"))


class Archive:
    """A cpio archive of the format that kernels unpack ("newc")."""

    def __init__(self):
        self.parts, self.count, self.folders = [], 0, set()

    def _entry(self, name, mode, data=b""):
        self.count += 1
        fields = (self.count, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(name) + 1, 0)
        head = b"070701" + b"".join(b"%08X" % field for field in fields) + name.encode() + b"\0"
        self.parts += [head, bytes(-len(head) % 4), data, bytes(-len(data) % 4)]

    def folder(self, name):
        for at in [*reversed(Path(name).parents), Path(name)]:
            if at.as_posix() not in (".", *self.folders):
                self.folders.add(at.as_posix())
                self._entry(at.as_posix(), stat.S_IFDIR | 0o755)

    def file(self, name, data, mode=0o644):
        self.folder(str(Path(name).parent))
        self._entry(name, stat.S_IFREG | mode, data)

    def link(self, name, target):
        self.folder(str(Path(name).parent))
        self._entry(name, stat.S_IFLNK | 0o777, target.encode())

    def write(self, path):
        self._entry("TRAILER!!!", 0)
        path.write_bytes(b"".join(self.parts))


def module_files(root):
    """The kernel's modules by name."""
    return {path.stem.replace("-", "_"): path for path in root.glob("usr/lib/modules/*/**/*.ko")}


def watchdog_of(root):
    """Name of the guest's watchdog"""
    return next(name for name in WATCHDOGS if name in module_files(root))


def modules_in_order(root):
    """(name, file) of the watchdog, of MODULES and their dependencies, dependencies first."""
    tree = next(root.glob("usr/lib/modules/*"))
    files = module_files(root)
    built_in = {Path(line).stem.replace("-", "_") for line in (tree / "modules.builtin").read_text().split()}
    order = []

    def add(name):
        if name in built_in or name in order:
            return
        info = files[name].read_bytes()
        depends = re.search(rb"\0depends=([^\0]*)\0", info)
        # Soft dependencies; not every kernel has each as a module.
        softly = re.findall(rb"\0softdep=pre: ([^\0]*)\0", info)
        for other in depends.group(1).decode().split(",") if depends and depends.group(1) else []:
            add(other.replace("-", "_"))
        for other in b" ".join(softly).decode().split():
            if other.replace("-", "_") in files:
                add(other.replace("-", "_"))
        order.append(name)

    for name in (watchdog_of(root), *MODULES):
        add(name)
    return [(name, files[name]) for name in order]


def libraries_of(arch, root, programs):
    """The libraries that the programs are linked with, and those that these need."""
    folders = [root / "usr" / "lib" / TRIPLET[arch], root / "usr" / "lib"]
    found, todo = {}, list(programs)
    while todo:
        command = [f"{TRIPLET[arch]}-readelf", "-d", "-l", todo.pop()]
        text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        names = re.findall(r"\(NEEDED\).*\[(.*?)\]", text)
        names += [Path(path).name for path in re.findall(r"interpreter: (.*?)\]", text)]
        for name in names:
            if name in found:
                continue
            found[name] = next(folder / name for folder in folders if (folder / name).exists())
            todo.append(found[name])
    return found


def board_text(changes):
    """board/rig.toml with the rig's short profile. @param changes  other values of its keys"""
    text = (SOURCE / "board" / "rig.toml").read_text()
    for key, value in {"profile": '"quick"', **changes}.items():
        text, times = re.subn(rf"^{key} = [^ ]+", f"{key} = {value}", text, flags=re.MULTILINE)
        assert times == 1, key
    return text


def make_initramfs(arch, root, build, out, board, programs):
    """
    @param build     folder of a cross build of plumbline
    @param board     text of the board file
    @param programs  more programs of `build`
    """
    archive = Archive()
    for folder in ("dev", "proc", "sys", "tmp", "run", "mnt", "state", "var/lib"):
        archive.folder(folder)
    ours = ("plumblined", "plumbline-keeper", "plumbline-mount")
    programs = [*(build / "firmware" / program for program in ours), *programs]
    udev = root / "usr" / "bin" / "udevadm"
    archive.file("bin/busybox", (root / "usr/bin/busybox").resolve().read_bytes(), 0o755)
    archive.file("bin/udevadm", udev.resolve().read_bytes(), 0o755)
    archive.link("sbin/udevd", "/bin/udevadm")
    for program in programs:
        stripped = out.parent / program.name
        subprocess.run([f"{TRIPLET[arch]}-strip", "-o", stripped, program], check=True)
        archive.file(f"bin/{program.name}", stripped.read_bytes(), 0o755)
        stripped.unlink()
    for name, path in libraries_of(arch, root, [*programs, udev]).items():
        archive.file(f"lib/{name}" if name.startswith("ld-linux") else f"lib/{TRIPLET[arch]}/{name}", path.read_bytes(), 0o755)
    for number, (name, path) in enumerate(modules_in_order(root)):
        archive.file(f"lib/modules/{number:02}_{name}.ko", path.read_bytes())
    archive.file("board/rig.toml", board.encode())
    archive.file("board/profiles/quick.toml", (HERE / "quick.toml").read_bytes())
    archive.file("init", (HERE / "init").read_bytes(), 0o755)
    archive.file("shell", (HERE / "shell").read_bytes())
    archive.write(out)


def make_boot_initramfs(root, out):
    """Loads the modules and goes on with the first process of the disk."""
    archive = Archive()
    for folder in ("dev", "proc", "sys", "disk"):
        archive.folder(folder)
    archive.file("bin/busybox", (root / "usr/bin/busybox").resolve().read_bytes(), 0o755)
    for number, (name, path) in enumerate(modules_in_order(root)):
        archive.file(f"lib/modules/{number:02}_{name}.ko", path.read_bytes())
    archive.file("init", (HERE / "init_disk").read_bytes(), 0o755)
    archive.write(out)


def make_systemd_disk(arch, folder, files):
    """
    A bootable disk with Debian's systemd, which starts a shell for the host. Needs root, for the owners of its files.
    @param folder  for the disk and what it is made of
    @param files   path in the guest: a file's bytes
    @returns the disk's path
    """
    root, disk = folder / "disk", folder / "disk.img"
    subprocess.run(["cp", "-a", make_systemd_root(arch), root], check=True)
    files = {
        "etc/passwd": (root / "usr/share/base-passwd/passwd.master").read_bytes() + b"messagebus:x:100:102::/nonexistent:/usr/sbin/nologin\n",
        "etc/group": (root / "usr/share/base-passwd/group.master").read_bytes() + b"messagebus:x:102:\n",
        "etc/machine-id": b"",
        "etc/hostname": b"rig\n",
        "var/lib/dpkg/status": b"",
        "etc/systemd/system/rig-shell.service": b"[Service]\nExecStart=/usr/bin/dash /rig/start\n",
        "rig/start": b"busybox --install -s /rig/bin; export PATH=/usr/sbin:/usr/bin:/rig/bin; . /rig/shell\n",
        "rig/shell": (HERE / "shell").read_bytes(),
        **files,
    }
    for name, data in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(data)
    wanted = root / "etc/systemd/system/multi-user.target.wants"
    wanted.mkdir(exist_ok=True)
    (wanted / "rig-shell.service").symlink_to("../rig-shell.service")
    default = root / "etc/systemd/system/default.target"
    default.symlink_to("/lib/systemd/system/multi-user.target")
    for name in ("dev", "proc", "sys", "run", "tmp", "root", "home", "mnt", "rig/bin", "var/lib/dpkg/info", "var/lib/dpkg/updates"):
        (root / name).mkdir(parents=True, exist_ok=True)
    with open(disk, "wb") as image:
        image.truncate(512 << 20)
    subprocess.run([shutil.which("mkfs.ext4") or "/usr/sbin/mkfs.ext4", "-q", "-F", "-d", root, disk], check=True)
    shutil.rmtree(root)
    return disk


def stick_file(path, name):
    """The bytes of a file on a stick."""
    return subprocess.run(["mtype", "-i", f"{path}@@1M", f"::/{name}"], check=True, capture_output=True).stdout


def stick_folder(path, name):
    """The names in a folder on a stick."""
    listed = subprocess.run(["mdir", "-b", "-i", f"{path}@@1M", f"::/{name}"], check=True, capture_output=True, text=True)
    return [line.rsplit("/", 1)[1] for line in listed.stdout.split()]


def make_stick(path, files, damaged=False, folders=()):
    """A stick of 48 MB with one FAT32 partition. @param damaged  overwrites its file allocation table"""
    sectors, first = 48 * 2048, 2048
    entry = b"\0" + bytes(3) + b"\x0c" + bytes(3) + first.to_bytes(4, "little") + (sectors - first).to_bytes(4, "little")
    with open(path, "wb") as image:
        image.truncate(sectors * 512)
        image.seek(446)
        image.write(entry)
        image.seek(510)
        image.write(b"\x55\xaa")
    mkfs = shutil.which("mkfs.vfat", path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")
    command = [mkfs, "-F", "32", "-n", "STICK", "--offset", str(first), str(path), str((sectors - first) // 2)]
    subprocess.run(command, check=True, capture_output=True)
    for file in files:
        os.utime(file, (1.7e9, 1.7e9))  # all equally old, so that they are listed by name
        subprocess.run(["mcopy", "-m", "-i", f"{path}@@1M", file, "::/"], check=True)
    for folder in folders:
        subprocess.run(["mmd", "-i", f"{path}@@1M", f"::/{folder}"], check=True)
    if damaged:
        with open(path, "r+b") as image:
            image.seek(first * 512)
            image.write(b"\xa5" * 512)
