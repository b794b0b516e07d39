#!/usr/bin/env python3
"""Meshes: plumbline slice, inspect, check and print on files that the test writes, and what decides between points and faces."""

import json
import struct
import subprocess

from case import PLUMBLINED, SIM2K, Program, confirm_plate, main, on_stick_printer, write_sphere


def box(low, high):
    """Corners and faces, the first two of which are the underside."""
    corners = [tuple((high if i >> axis & 1 else low)[axis] for axis in range(3)) for i in range(8)]
    faces = [(0, 2, 3), (0, 3, 1), (0, 1, 5), (0, 5, 4), (1, 3, 7), (1, 7, 5), (3, 2, 6), (3, 6, 7), (2, 0, 4), (2, 4, 6), (4, 5, 7), (4, 7, 6)]
    return corners, faces


def write_stl(path, corners, faces):
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(faces)))
        for face in faces:
            file.write(struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in corners[i]), 0))


def write_obj(path, corners, faces):
    lines = ["v %g %g %g" % corner for corner in corners] + ["f %d %d %d" % tuple(i + 1 for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


class Meshes(Program):
    def setUp(self):
        super().setUp()
        self.mesh = self.dir / "box.stl"
        write_stl(self.mesh, *box((0, 0, 0), (20, 10, 5)))

    def slice_mesh(self, *arguments, status=0):
        return self.run_it("slice", *arguments, "-o", self.out, "--pixel-pitch", 0.1, "--layer-height", 0.1, status=status)

    def test_a_box_has_exactly_its_pixels_in_every_layer(self):
        done = self.slice_mesh(self.mesh, "--supports", "none", "-v")
        manifest = self.manifest()
        self.assertEqual(manifest["grid"]["layers"], 50)
        self.assertAlmostEqual(manifest["volume_mm3"], 1000, places=3)
        self.assertEqual(manifest["mesh"]["triangles"], 12)
        self.assertTrue(manifest["mesh"]["closed"])
        self.assertEqual(manifest["mesh"]["rays_broken"], 0)
        self.assertIsNone(manifest["evidence"])
        self.assertEqual(manifest["scan"]["format"], "STL")
        self.assertIn("12 triangles, closed", done.stdout)
        self.assertNotIn("scanned ", done.stdout)
        self.assertTrue((self.out / "preview.png").exists())
        self.assertFalse((self.out / "coverage.png").exists())
        for stage in manifest["stages"]:
            if stage["name"] in ("read", "ray grid", "rays", "r-rep"):
                self.assertLessEqual(stage["peak_bytes"], stage["planned_bytes"], stage["name"])

    def test_a_size_that_is_not_delivered_is_told_with_its_reason(self):
        self.assertNotIn("that matters", self.slice_mesh(self.mesh, "--height", "12mm", "--supports", "none", "--no-preview").stderr)
        self.assertAlmostEqual(self.manifest()["size_delivered_mm"][2], 12, places=5)
        # The tip of a spire is thinner than a pixel: along its last 0.4 mm or so no pixel's middle is inside.
        spire = self.dir / "spire.stl"
        write_stl(spire, [(0, 0, 0), (3, 0, 0), (3, 3, 0), (0, 3, 0), (1.5, 1.5, 12)], [(0, 2, 1), (0, 3, 2), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)])
        done = self.slice_mesh(spire, "--height", "12mm", "--supports", "none", "--no-preview")
        delivered = self.manifest()["size_delivered_mm"][2]
        self.assertTrue(11 < delivered < 11.9, delivered)
        self.assertIn(f"the object is {delivered:.2f} mm high, not 12: what reaches beyond that is too thin to print. If that matters, ask for 12.", done.stderr)
        self.assertNotIn("not 12", self.slice_mesh(spire, "--supports", "none", "--no-preview").stderr)
        for command in (("check",), ("print", "--printer", SIM2K, "--accept")):
            done = self.run_it(command[0], spire, *command[1:], "--height", "12mm", "--supports", "none")
            self.assertIn("  checking the layers", done.stderr)
            self.assertRegex(done.stderr, r"the object is 11\.\d\d mm high, not 12: what reaches beyond that is too thin to print\. If that matters, ask for 12\.")

    def test_what_lies_at_one_place_is_refused(self):
        corners, faces = box((5, 6, 7), (5, 6, 7))
        point = self.dir / "point.stl"
        write_stl(point, corners, faces)
        ptx = self.dir / "point.ptx"
        ptx.write_text("3\n1\n" + 4 * "0 0 0\n" + "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n" + 3 * "1 2 3 0.5\n")
        for arguments in (("inspect", point), ("inspect", point, "--printer", SIM2K), ("slice", point, "-o", self.out, "--height", "80mm")):
            self.assertIn("point.stl: all of it lies at one place, 5 6 7. Export it again", self.run_it(*arguments, status=1).stderr)
        done = self.run_it("slice", ptx, "-o", self.out, status=1)
        self.assertIn("point.ptx: all of it lies at one place, 1 2 3. Export it again", done.stderr)

    def test_formats_threads_and_options_give_the_same_layers(self):
        self.slice_mesh(self.mesh, "--rotate-x", 20, "--rotate-y", 35, "--threads", 1, "--no-preview")
        hashes = self.manifest()["hashes"]
        obj = self.dir / "box.obj"
        write_obj(obj, *box((0, 0, 0), (20, 10, 5)))
        self.slice_mesh(obj, "--rotate-x", 20, "--rotate-y", 35, "--threads", 4, "--no-preview")
        self.assertEqual(self.manifest()["hashes"], hashes)

    def test_a_mesh_with_a_hole_is_closed_and_told(self):
        corners, faces = box((0, 0, 0), (20, 10, 5))
        write_stl(self.mesh, corners, faces[:-1])
        done = self.slice_mesh(self.mesh, "--no-preview", "--supports", "none")
        self.assertIn("the mesh had 1 small gap", done.stderr)
        self.assertFalse(self.manifest()["mesh"]["closed"])
        self.assertEqual(self.manifest()["mesh"]["small_holes_closed"], 1)
        self.assertAlmostEqual(self.manifest()["volume_mm3"], 1000, delta=0.1)

    def test_inspect_says_what_it_is_and_that_it_fits(self):
        done = self.run_it("inspect", self.mesh, "--printer", self.board, "-v")
        self.assertRegex(done.stdout, r"mesh       box.stl: 12 triangles, closed\n")
        self.assertRegex(done.stdout, r"print      20.00 x 10.00 x 5.00 mm, 50 layers")
        self.assertIn("ray grid", done.stdout)
        told = json.loads(self.run_it("inspect", self.mesh, "--json").stdout)
        self.assertTrue(told["mesh"]["closed"])
        self.assertEqual(told["size_mm"], [20, 10, 5])
        refused = self.run_it("inspect", self.mesh, "--picture", self.dir / "seen.png", status=1)
        self.assertIn("is a mesh", refused.stderr)

    def test_check_and_print_take_it(self):
        told = json.loads(self.run_it("check", self.mesh, "--printer", self.board, "--supports", "none", "--json").stdout)
        self.assertAlmostEqual(told["volume_ml"], 1.0, places=2)
        report = self.dir / "print.json"
        self.run_it("print", self.mesh, "--printer", SIM2K, "--layer-height", 0.1, "--supports", "none", "--report", report)
        self.assertEqual(json.loads(report.read_text())["state"], "finished")

    def test_the_daemon_prints_it_from_a_stick(self):
        stick, state = self.dir / "stick", self.dir / "state"
        stick.mkdir()
        write_stl(stick / "BOX.STL", *box((0, 0, 0), (20, 10, 5)))
        confirm_plate(state)
        command = [PLUMBLINED, "--printer", on_stick_printer(self.dir), "--state", state, "--stick", stick, "--speedup", 1e6, "--jobs", 1]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=120, check=False)
        self.assertIn("BOX.STL: finished, 100 of 100 layers", done.stdout + done.stderr)

    def test_as_decides_between_points_and_faces(self):
        obj = self.dir / "box.obj"
        write_obj(obj, *box((0, 0, 0), (20, 10, 5)))
        self.assertIsNotNone(json.loads(self.run_it("inspect", obj, "--json").stdout)["mesh"])
        # As points, its corners are no surface.
        refused = self.run_it("inspect", obj, "--as", "points", status=1)
        self.assertIn("box.obj: no surface found in 8 points", refused.stderr)
        write_sphere(self.scan, points=2000)
        refused = self.run_it("inspect", self.scan, "--as", "mesh", status=1)
        self.assertIn("the file has points but no faces", refused.stderr)
        refused = self.run_it("inspect", self.mesh, "--as", "points", status=1)
        self.assertIn("leave out --as points", refused.stderr)
        self.run_it("inspect", obj, "--as", "surface", status=2)

    def test_broken_and_oversized_meshes_are_refused_with_place_and_remedy(self):
        data = self.mesh.read_bytes()
        self.mesh.write_bytes(data[:200])
        self.assertIn("with 2 of the 12 triangles that its header declares", self.slice_mesh(self.mesh, status=1).stderr)
        write_obj(self.dir / "bad.obj", box((0, 0, 0), (1, 1, 1))[0], [(0, 1, 99)])
        bad = self.slice_mesh(self.dir / "bad.obj", "--as", "mesh", status=1).stderr
        self.assertIn("line 9: a face names vertex 100, but 8 are before it", bad)
        write_stl(self.mesh, *box((0, 0, 0), (500, 500, 5)))
        self.assertIn("Use --scale", self.run_it("slice", self.mesh, "-o", self.out, "--printer", self.board, status=1).stderr)
        write_stl(self.mesh, *box((0, 0, 0), (120, 120, 5)))
        small = self.slice_mesh(self.mesh, "--arena-mib", 6, status=1).stderr
        self.assertIn("the mesh does not fit into the arena of 6.0 MiB: stage", small)
        self.assertFalse(self.out.exists())


if __name__ == "__main__":
    main()
