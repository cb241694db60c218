"""Tests the Python package with a server. Usage: package_test.py DIRECTORY_OF_PROGRAMS (with PYTHONPATH set)"""

import inspect
import itertools
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock
import warnings
from types import SimpleNamespace

try:
    import numpy as np
except ImportError as missing:
    print(f"!! SKIPPED: the Python package is not tested: {missing}")
    sys.exit(0)

import multitetra
from multitetra.addresses import page_address, stream_address
from multitetra.connection import Connection
from multitetra.napari_reader import chosen_datasets, image_layer, napari_get_reader
from multitetra.samples import SampleArray

PROGRAMS = pathlib.Path(sys.argv.pop(1))


def run(program, *words):
    subprocess.run([PROGRAMS / program, *words], check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def octahedron():
    vertices = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    return multitetra.Mesh(vertices, np.array(faces, np.uint32))


def sixfold_volume(vertices, faces):
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum()


class Silence:
    """A server that accepts connections and sends nothing."""

    def __enter__(self):
        self._socket = socket.create_server(("127.0.0.1", 0))
        return "tcp://%s:%d" % self._socket.getsockname()

    def __exit__(self, *_):
        self._socket.close()


class Meddler:
    """A proxy of a server; `meddle(frame, list)` returns each frame of the server, or an iterable of frames, or None to
    cut the connection."""

    def __init__(self, url, meddle):
        host, port = url.removeprefix("tcp://").split(":")
        self._server = (host, int(port))
        self._meddle = meddle
        self._seen = []

    def __enter__(self):
        self._listener = socket.create_server(("127.0.0.1", 0))
        threading.Thread(target=self._accept, daemon=True).start()
        return "tcp://%s:%d" % self._listener.getsockname()

    def __exit__(self, *_):
        self._listener.close()

    def _accept(self):
        try:
            while True:
                client, _ = self._listener.accept()
                server = socket.create_connection(self._server)
                threading.Thread(target=self._pass_on, args=(client, server), daemon=True).start()
                threading.Thread(target=self._meddle_with, args=(server, client), daemon=True).start()
        except OSError:
            pass

    def _pass_on(self, client, server):
        try:
            while data := client.recv(1 << 16):
                server.sendall(data)
        except OSError:
            pass
        server.close()

    def _meddle_with(self, server, client):
        stream = server.makefile("rb")
        while head := stream.read(4):
            frame = self._meddle(stream.read(int.from_bytes(head, "little")), self._seen)
            if frame is None:
                break
            try:
                for one in [frame] if isinstance(frame, bytes) else frame:
                    client.sendall(len(one).to_bytes(4, "little") + one)
            except OSError:  # The client has ended the connection.
                break
        for end in (client, server):
            end.close()


STEP_BEGIN, STEP_END = 0x1A, 0x2A  # The tags of ServerMessage.step_begin and step_end.


def varint(number):
    more = number >> 7
    return bytes([number & 127 | 128]) + varint(more) if more else bytes([number])


def with_fields(frame, fields):
    """The frame of one message with fields at its end, where they replace earlier ones."""
    begin = 1 + next(i for i in range(1, len(frame)) if frame[i] < 128)
    body = frame[begin:] + fields
    return frame[:1] + varint(len(body)) + body


def as_preview(frame):
    """A final step is announced as a preview of spacing 2."""
    return with_fields(frame, b"\x18\0\x30\2") if frame[0] == STEP_BEGIN else frame  # StepBegin.is_final, finest_spacing.


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        run("multitetra-server", "generate", "gyroid", "--size", "33", "-o", cls.path / "gyroid.nrrd", "--quiet")
        run("multitetra-server", "prepare", cls.path / "gyroid.nrrd", "-o", cls.path / "gyroid.mtd", "--quiet")
        (cls.path / "times.nrrd").write_bytes(
            b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 9 9 9 3\nspacings: 1 1 1 0.5\nencoding: raw\n\n"
            + bytes((i + i // 729) % 251 for i in range(3 * 729))
        )
        run("multitetra-server", "prepare", cls.path / "times.nrrd", "--all-times", "--time-unit", "ms", "-o", cls.path / "series",
            "--quiet")
        # Label 4 is a box of 3 x 2 x 5 samples.
        (cls.path / "box.nrrd").write_bytes(
            b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 9 9\nspacings: 0.5 1 2\nencoding: raw\n\n"
            + bytes(4 * (1 <= x < 4 and 4 <= y < 6 and 2 <= z < 7) for z in range(9) for y in range(9) for x in range(9))
        )
        run("multitetra-server", "prepare", cls.path / "box.nrrd", "--label", "4", "-o", cls.path / "labels", "--quiet")
        cls.server, cls.urls = cls.serve(cls.path / "gyroid.mtd", cls.path / "series", cls.path / "labels")

    @classmethod
    def serve(cls, *datasets, tcp="127.0.0.1:0"):
        """A server's process and its addresses."""
        log = cls.path / "log"
        with open(log, "w") as stderr:
            server = subprocess.Popen(
                [PROGRAMS / "multitetra-server", "serve", *datasets, "--tcp", tcp, "--http", "127.0.0.1:0"],
                stdout=subprocess.DEVNULL,
                stderr=stderr,
            )
        for _ in range(600):
            found = dict(re.findall(r"listening on (tcp|http)://([0-9.]+:[0-9]+)", log.read_text()))
            if len(found) == 2:
                break
            time.sleep(0.05)
        return server, ["tcp://" + found["tcp"], "ws://" + found["http"]]

    @classmethod
    def tearDownClass(cls):
        cls.server.terminate()
        cls.server.wait()
        cls.folder.cleanup()

    def test_isosurface_equals_the_command_line(self):
        run(
            "multitetra-client", "fetch", "--server", self.urls[0], "--dataset", "gyroid", "--isovalue", "0.1",
            "--error", "0.5", "-o", self.path / "mesh.stl", "--report", self.path / "report.json", "--quiet",
        )  # fmt: skip
        report = (self.path / "report.json").read_text()
        for url in self.urls:
            with multitetra.connect(url) as server:
                *_, last = server.steps("gyroid", 0.1, error=0.5)
            self.assertIn(f'"content_digest": "{last.digest}"', report)
            triangles = (self.path / "mesh.stl").read_bytes()[84:]
            records = np.frombuffer(triangles, np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]))
            self.assertEqual(len(records), len(last.mesh.faces))
            ours = last.mesh.vertices[last.mesh.faces].reshape(-1, 3)  # Files have another order.
            theirs = records["v"].reshape(-1, 3)
            np.testing.assert_allclose(ours.sum(axis=0), theirs.sum(axis=0), rtol=1e-5)
            np.testing.assert_allclose(ours.min(axis=0), theirs.min(axis=0), rtol=1e-6)

    def test_series_is_sorted_by_time(self):
        with multitetra.connect(self.urls[0]) as server:
            members = server.series("times")
            self.assertEqual([info.name for info in members], ["times.t0000", "times.t0001", "times.t0002"])
            self.assertEqual([(info.member.time, info.member.time_unit) for info in members], [(0, "ms"), (0.5, "ms"), (1, "ms")])
            self.assertIsNone(members[0].member.label)
            self.assertEqual(server.series("gyroid"), [])

    def test_label_has_an_extent_in_samples(self):
        with multitetra.connect(self.urls[0]) as server:
            (box,) = server.series("box")
            extent = box.label_extent
            self.assertEqual((box.member.label.value, extent.samples), (4, 3 * 2 * 5))
            self.assertEqual([list(corner) for corner in extent.box], [[1, 4, 2], [3, 5, 6]])
            self.assertEqual(list(extent.centroid), [2, 4.5, 4])
            self.assertIsNone(server.array("gyroid").info.label_extent)

    def test_slice_and_probe_return_samples(self):
        with multitetra.connect(self.urls[1]) as server:
            layer = server.slice("gyroid", "z", 7)
            self.assertEqual(layer.values.shape, (33, 33))
            self.assertEqual(layer.sample_spacing, 1)
            places = [[x, y, 7] for y in (0, 5, 32) for x in (0, 9, 32)]
            for place, probed in zip(places, server.probe("gyroid", places, coordinates="index")):
                self.assertEqual(layer.values[place[1], place[0]], np.float32(probed.value))
                self.assertEqual(probed.gradient.shape, (3,))
            self.assertIsNone(server.probe("gyroid", [[-1, 0, 0]], coordinates="index")[0].value)
            row = server.slice("gyroid", origin=(0, 5, 7), right=(1, 0, 0), down=(0, 1, 0), width=33, height=1,
                               coordinates="index")  # fmt: skip
            np.testing.assert_array_equal(row.values[0], layer.values[5])
            with self.assertRaisesRegex(multitetra.ServerError, "pixels"):
                server.slice("gyroid", origin=(0, 0, 0), right=(1, 0, 0), down=(0, 1, 0), width=5000, height=5000)

    def test_what_a_slice_or_probe_cannot_be_is_refused(self):
        with multitetra.connect(self.urls[0]) as server:
            for words, error, text in (
                (("xy",), ValueError, "axis is 'xy'"),
                (("",), ValueError, "must be 'x', 'y' or 'z'"),
                (("z", 33), IndexError, "layers 0 to 32"),
                (("z", -1), IndexError, "at is -1"),
            ):
                with self.assertRaisesRegex(error, text):
                    server.slice("gyroid", *words)
            with self.assertRaisesRegex(TypeError, "no keyword colour"):
                server.slice("gyroid", colour=1)
            with self.assertRaisesRegex(TypeError, "needs right, down, width, height"):
                server.slice("gyroid", origin=(0, 0, 0))
            with self.assertRaisesRegex(ValueError, r"\(n, 3\), a row each; these have shape \(3, 2\)"):
                server.probe("gyroid", np.zeros((3, 2)))
            self.assertEqual(len(server.probe("gyroid", (1, 2, 3))), 1)
            self.assertEqual(len(server.probe("gyroid", [])), 0)

    def test_a_restarted_server_is_asked_for_its_datasets_again(self):
        def prepare(spacing):
            run("multitetra-server", "prepare", self.path / "gyroid.nrrd", "--spacing", spacing, "-o", self.path / "other.mtd", "--name", "other", "--quiet")

        prepare("1,1,1")
        process, (tcp, _) = self.serve(self.path / "other.mtd")
        try:
            with multitetra.connect(tcp) as server:
                before = server.isosurface("other", 0.1, error=1)
                for step, first in ((2, server.isosurface), (3, server.slice)):
                    process.kill()
                    process.wait()
                    prepare(f"{step},{step},{step}")
                    process, _ = self.serve(self.path / "other.mtd", tcp=tcp.removeprefix("tcp://"))
                    if first == server.slice:
                        self.assertEqual(server.slice("other", "z", 7).values.shape, (33, 33))  # Over a new connection.
                    else:  # A surface of what was listed before is none of what there is.
                        with self.assertRaisesRegex(multitetra.ServerError, "fetch it again"):
                            server.isosurface("other", 0.1, error=1)
                    np.testing.assert_allclose(server.isosurface("other", 0.1, error=1).bounds, step * before.bounds, atol=0.2)
                    self.assertEqual(server.datasets()[0].spacing[0], step)
        finally:
            process.terminate()
            process.wait()

    def test_an_array_of_a_server_keeps_its_place(self):
        with multitetra.connect(self.urls[0]) as server:
            array = server.array("gyroid")
            there = server.isosurface("gyroid", 0.1, error=0.5)
            here = multitetra.Volume(array).isosurface(0.1, error=0.5)
            np.testing.assert_allclose(here.bounds, there.bounds, atol=1e-6)
            self.assertEqual((here.unit, here.space), (there.unit, there.space))

    def test_dataset_has_shape_and_affine(self):
        with multitetra.connect(self.urls[0]) as server:
            (info,) = [one for one in server.datasets() if one.name == "gyroid"]
            self.assertEqual(info.shape, (33, 33, 33))
            np.testing.assert_allclose((info.affine @ [3, 4, 5, 1])[:3], server.probe("gyroid", [[3, 4, 5]], "index")[0].world)
            self.assertEqual(info.affine.shape, (4, 4))
            self.assertEqual(info.unit, "mm")
            self.assertEqual(list(info.spacing), [1, 1, 1])
            (box,) = server.series("box")
            self.assertEqual(list(box.spacing), [0.5, 1, 2])
            self.assertRegex(repr(info), r"^<Dataset gyroid: 33 x 33 x 33 f32, spacing .*, values .* to .*>$")

    def test_connects_by_page_address(self):
        page = self.urls[1].replace("ws://", "http://")
        with multitetra.connect(page + "/#dataset=gyroid") as server:
            self.assertIn("gyroid", [info.name for info in server.datasets()])
        self.assertEqual(page_address("wss://example.org/volumes/v1/stream"), "https://example.org/volumes/")
        self.assertEqual(stream_address("https://example.org/volumes/"), "wss://example.org/volumes/v1/stream")
        self.assertEqual(stream_address("tls://example.org"), "tls://example.org")
        with self.assertRaisesRegex(ValueError, "tcp://example.org"):
            page_address("tcp://example.org")

    def test_array_is_indexed_like_samples(self):
        with multitetra.connect(self.urls[1]) as server:
            array = server.array("gyroid")
            whole = server.samples("gyroid")
            self.assertEqual(whole.shape, (33, 33, 33))
            self.assertEqual(whole[3, 4, 5], np.float32(server.probe("gyroid", [[3, 4, 5]], "index")[0].value))
            for index in (np.s_[3, 4, 5], np.s_[3], np.s_[..., 5], np.s_[1:9:3, ::-8, 2:4], np.s_[:, -1, 30:99], np.s_[5:5]):
                np.testing.assert_array_equal(array[index], whole[index])
            np.testing.assert_array_equal(server.samples("gyroid", ((1, 3), (0, 33), (7, 8))), whole[1:3, :, 7:8])
            np.testing.assert_array_equal(np.asarray(array), whole)
            for wrong, error in ((33, IndexError), ("x", TypeError), (np.s_[0, 0, 0, 0], IndexError)):
                with self.assertRaises(error):
                    array[wrong]

    def test_chunks_of_an_array_request_their_own_samples(self):
        with multitetra.connect(self.urls[1]) as server:
            requested = []

            class Counted:
                def slice(self, name, **request):
                    requested.append((request["origin"], request["width"], request["height"]))
                    return server.slice(name, **request)

            array = SampleArray(Counted(), server.array("gyroid").info)
            chunk = np.s_[0:4, 8:16, 5:8]
            whole = server.samples("gyroid")
            np.testing.assert_array_equal(array[chunk], whole[chunk])
            self.assertEqual(requested, [((0, 8, z), 4, 8) for z in (5, 6, 7)])
            try:
                import dask.array
            except ImportError as missing:
                print(f"!! SKIPPED: arrays are not tested with dask: {missing}")
                return
            requested.clear()
            lazy = dask.array.from_array(array, chunks=(4, 8, 3), lock=True)
            np.testing.assert_array_equal(lazy[0:4, 8:16, 3:6].compute(), whole[0:4, 8:16, 3:6])
            self.assertEqual(requested, [((0, 8, z), 4, 8) for z in (3, 4, 5)])

    def test_saves_meshes_by_suffix(self):
        ball = octahedron()
        np.testing.assert_array_equal(ball.bounds, [[-1, -1, -1], [1, 1, 1]])
        ball.save(self.path / "ball.stl")
        self.assertEqual(len((self.path / "ball.stl").read_bytes()), 84 + 8 * 50)
        ball.save(self.path / "ball.ply")
        self.assertTrue((self.path / "ball.ply").read_bytes().startswith(b"ply"))
        with self.assertRaisesRegex(ValueError, r"\*\.stl"):
            ball.save(self.path / "ball.step")
        with self.assertRaisesRegex(ValueError, "vertex 6, but the number of vertices is 6"):
            multitetra.Mesh(ball.vertices, ball.faces + np.uint32(4)).save(self.path / "wrong.stl")
        with self.assertRaises(OSError):
            ball.save(self.path / "nowhere" / "ball.stl")

    def test_saves_meshes_far_from_the_origin_as_they_are(self):
        ball = octahedron()
        far = multitetra.Mesh(ball.vertices * 0.1 + [500000.0, 5400000.0, 120.0], ball.faces)
        far.save(self.path / "far.obj")
        lines = (self.path / "far.obj").read_text().splitlines()
        saved = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=np.float64)
        np.testing.assert_array_equal(saved, far.vertices)
        far.save(self.path / "far.ply")
        self.assertIn(b"property double x", (self.path / "far.ply").read_bytes())
        for suffix in "stl", "drc":
            with self.assertRaisesRegex(ValueError, r"files have 32-bit coordinates.* mesh.vertices \+= \(-500000,-5400000,-120\)"):
                far.save(self.path / f"far.{suffix}")
            self.assertFalse((self.path / f"far.{suffix}").exists())
        far.vertices += (-500000, -5400000, -120)
        far.save(self.path / "near.stl")

    def test_volume_bound_holds_for_the_ball_around_a_mesh(self):
        ball = octahedron()
        ball.error_bound = 1 - 3**-0.5
        self.assertGreaterEqual(ball.volume_bound, 4 / 3 * np.pi - ball.volume)
        bend = 12 * 2**0.5 * np.arccos(1 / 3)
        d = ball.error_bound
        self.assertAlmostEqual(ball.volume_bound, d * ball.area + d**2 * bend / 2 + d**3 * 4 * np.pi)

    def test_to_pyvista_counts_the_corners_of_each_face(self):
        class PolyData(dict):
            def __init__(self, points, cells):
                self.points, self.cells = points, cells

        ball = octahedron()
        with unittest.mock.patch.dict(sys.modules, pyvista=SimpleNamespace(PolyData=PolyData)):
            plain = ball.to_pyvista()
            ball.scalars = np.arange(6, dtype=np.float32)
            colored = ball.to_pyvista()
        np.testing.assert_array_equal(plain.points, ball.vertices)
        np.testing.assert_array_equal(plain.cells.reshape(-1, 4)[:, 0], [3] * 8)
        np.testing.assert_array_equal(plain.cells.reshape(-1, 4)[:, 1:], ball.faces)
        self.assertEqual(dict(plain), {})
        np.testing.assert_array_equal(colored["scalars"], ball.scalars)

    def test_display_uses_sample_shells(self):
        with multitetra.connect(self.urls[0]) as server:
            *_, kept = server.steps("gyroid", 0.1, error=0.5)
            *_, drawn = server.steps("gyroid", 0.1, error=0.5, display=True)
            *_, fewer = server.steps("gyroid", 0.1, error=0.5, display=True, drawable_triangles=len(drawn.mesh.faces) // 10)
        self.assertTrue(drawn.is_final)
        self.assertLessEqual(drawn.error_bound_world, 0.5)
        self.assertGreater(drawn.mesh.error_bound, drawn.error_bound_world)  # The lattice error is added.
        self.assertLess(drawn.mesh.error_bound, drawn.error_bound_world + 0.1)
        self.assertEqual((drawn.euler_characteristic, drawn.components), (kept.euler_characteristic, kept.components))
        self.assertGreater(len(drawn.mesh.faces), len(kept.mesh.faces), "it is not simplified")
        self.assertEqual(len(fewer.mesh.faces), len(kept.mesh.faces), "more than it can draw")
        self.assertLess(drawn.payload_bytes, 0.5 * len(drawn.mesh.faces), "triangles take more")
        self.assertGreater(kept.payload_bytes, 0.5 * len(kept.mesh.faces))

    def test_volume_bound_follows_from_the_error_bound(self):
        with multitetra.connect(self.urls[0]) as server:
            steps = list(server.steps("gyroid", 0.1, error=0.5))
            last = steps[-1].mesh
            self.assertGreater(last.error_bound, steps[-1].error_bound_world)  # The lattice error is added.
            self.assertGreater(last.volume_bound, last.area * last.error_bound)
            self.assertLess(last.volume_bound, 4 * last.area * last.error_bound)
            self.assertTrue(all(step.mesh.error_bound is None for step in steps if step.spacing > 1))
            self.assertIsNone(server.isosurface("gyroid", 0.1, error=0.5, bound="paper").error_bound)
            self.assertEqual(last.components()[0].error_bound, last.error_bound)
            self.assertRegex(repr(last), r"^<Mesh: \d+ vertices, \d+ triangles, within ")

    def test_is_full_resolution_only_at_full_resolution(self):
        with multitetra.connect(self.urls[0]) as server:
            self.assertFalse(server.isosurface("gyroid", 0.1, error=0.5).is_full_resolution)
            full = server.isosurface("gyroid", 0.1, error=0)
        self.assertTrue(full.is_full_resolution)
        self.assertTrue(full.components()[0].is_full_resolution)

    def test_napari_reads_a_viewer_address(self):
        page = self.urls[1].replace("ws://", "http://")
        self.assertIsNone(napari_get_reader("head.tif"))
        reader = napari_get_reader(page)
        *_, (surface, options, kind) = reader(page + "/#dataset=gyroid&isovalue=0.1&error=0.5")
        self.assertEqual((kind, options["name"]), ("surface", "gyroid at 0.1"))
        vertices, faces, values = surface
        with multitetra.connect(page) as server:
            mesh = server.isosurface("gyroid", 0.1, error=0.5)
            info = {one.name: one for one in server.datasets()}["gyroid"]
        np.testing.assert_array_equal(vertices, mesh.vertices[:, ::-1])
        self.assertEqual(len(values), len(vertices))
        # Reversing axes mirrors, so faces are flipped to enclose the same volume.
        np.testing.assert_allclose(sixfold_volume(vertices, faces), sixfold_volume(mesh.vertices, mesh.faces))
        samples, options, kind = image_layer(np.zeros((2, 3, 4)), info)
        self.assertEqual((kind, samples.shape), ("image", (4, 3, 2)))
        np.testing.assert_allclose((options["affine"] @ [5, 4, 3, 1])[:3][::-1], (info.affine @ [3, 4, 5, 1])[:3])
        with self.assertRaisesRegex(ValueError, "gyroid"):
            reader(page + "/#dataset=nothing")

    def test_napari_opens_the_labels_of_an_address(self):
        def label(value, name=""):
            return SimpleNamespace(name=f"seg.label{value}", member=SimpleNamespace(series="seg", label=SimpleNamespace(value=value, name=name)))

        infos = [SimpleNamespace(name="head", member=None), *(label(value) for value in (2, 5, 9))]
        found = lambda **chosen: [info.name for info in chosen_datasets(infos, chosen, "http://x")]
        self.assertEqual(found(dataset="seg.label2", labels="5"), ["seg.label5"])
        self.assertEqual(found(dataset="seg", labels="1-9,-5"), ["seg.label2", "seg.label9"])
        self.assertEqual(found(dataset="seg", labels="-9"), ["seg.label2", "seg.label5"])
        self.assertEqual(found(dataset="seg"), ["seg.label2"])
        self.assertEqual(found(), ["head"])
        with self.assertRaisesRegex(ValueError, "no labels 7"):
            found(dataset="seg", labels="7")
        with self.assertRaisesRegex(ValueError, "there are head, seg"):
            found(dataset="teeth")

    def test_colors_by_own_field_equal_the_isovalue(self):
        with multitetra.connect(self.urls[0]) as server:
            *_, last = server.steps("gyroid", 0.1, error=0, color_by="gyroid", normals=8)
            self.assertEqual(len(last.mesh.scalars), len(last.mesh.vertices))
            self.assertLess(np.abs(last.mesh.scalars - 0.1).max(), 0.1)
            again = server.isosurface("gyroid", 0.1, error=0, color_by="gyroid", color_range=(-9, 9), normals=8)
            np.testing.assert_allclose(again.scalars, last.mesh.scalars, atol=18 / 65534 + 1e-4)
            with self.assertRaises(ValueError):
                server.isosurface("gyroid", 0.1, color_range=(0, 1))

    def test_several_surfaces_share_a_budget(self):
        with multitetra.connect(self.urls[0]) as server:
            alone = server.isosurfaces("gyroid", [-0.3, 0.3], error=0.05)
            self.assertGreater(sum(len(mesh.faces) for mesh in alone), 3000)
            shared = server.isosurfaces("gyroid", [-0.3, 0.3], error=0.05, max_triangles=3000)
            self.assertLessEqual(sum(len(mesh.faces) for mesh in shared), 3000)
            self.assertTrue(all(len(mesh.faces) for mesh in shared))

    def test_area_and_volume_equal_vtk(self):
        ball = octahedron()
        self.assertAlmostEqual(ball.area, 4 * 3**0.5)
        self.assertAlmostEqual(ball.volume, 4 / 3)
        two = multitetra.Mesh(
            np.concatenate([ball.vertices, 2 * ball.vertices + [9, 0, 0]]),
            np.concatenate([ball.faces, ball.faces[:7] + np.uint32(6), ball.faces[7:] + np.uint32(6)]),
        )
        self.assertEqual(sorted(round(part.volume, 9) for part in two.components()), [1.333333333, 10.666666667])
        with self.assertRaisesRegex(ValueError, "does not enclose a volume"):
            multitetra.Mesh(ball.vertices, ball.faces[:7]).volume
        with multitetra.connect(self.urls[0]) as server:
            meshes = [ball, two] + server.isosurface("gyroid", 0.1, error=0.5).components()[:2]
        try:
            from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
            from vtkmodules.vtkCommonCore import vtkPoints
            from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
            from vtkmodules.vtkFiltersCore import vtkMassProperties
        except ImportError as missing:
            print(f"!! SKIPPED: areas and volumes are not compared with VTK's: {missing}")
            return
        for mesh in meshes:
            points, cells, data = vtkPoints(), vtkCellArray(), vtkPolyData()
            points.SetData(numpy_to_vtk(mesh.vertices, deep=True))
            lines = np.column_stack([np.full(len(mesh.faces), 3), mesh.faces]).astype(np.int64)
            cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(lines.ravel(), deep=True))
            data.SetPoints(points)
            data.SetPolys(cells)
            properties = vtkMassProperties()
            properties.SetInputData(data)
            properties.Update()
            self.assertAlmostEqual(mesh.area / properties.GetSurfaceArea(), 1, places=6)
            try:
                self.assertAlmostEqual(mesh.volume / properties.GetVolume(), 1, places=6)
            except ValueError:
                pass  # The surface ends at the border of the data.

    def test_warns_about_empty_surfaces(self):
        with multitetra.connect(self.urls[0]) as server:
            for empty in (lambda: server.isosurface("gyroid", 1e9), lambda: list(server.steps("gyroid", 1e9))[-1].mesh,
                          lambda: server.isosurfaces("gyroid", [1e9])[0]):  # fmt: skip
                with self.assertWarnsRegex(multitetra.EmptySurfaceWarning, 'empty: .* values of "gyroid" range from') as output:
                    self.assertEqual(len(empty().faces), 0)
                self.assertEqual(output.filename, __file__)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                server.isosurface("gyroid", 0.1, error=2)

    def test_signatures_name_every_request_option(self):
        for method in (Connection.isosurface, Connection.steps):
            parameters = inspect.signature(method).parameters
            for name in ("error", "unit", "quality", "regions", "region_coordinates", "threshold_grid", "normals", "simplify", "intersection_free", "color_by"):
                self.assertIn(name, parameters)
            self.assertNotIn("request", parameters)
            self.assertEqual([parameters[name].default for name in ("error", "lattice", "unit", "simplify", "view")], [0.25, 5, "voxel", True, None])
            self.assertIn("such as 500KiB", method.__doc__)
        with multitetra.connect(self.urls[0]) as server, self.assertRaises(TypeError):
            server.isosurface("gyroid", 0.1, normal_bits=8)

    def test_parameters_are_named_like_options(self):
        help_text = subprocess.run([PROGRAMS / "multitetra-client", "fetch", "--help-all"], capture_output=True, text=True).stdout
        options = set(re.findall(r"^  --([a-z-]+)", help_text, re.M))
        for name in [*inspect.signature(Connection.isosurface).parameters][3:]:
            option = "region" if name == "regions" else name.replace("_", "-")
            self.assertIn(option, options)

    def test_steps_arrive_coarse_first_with_tiles_once(self):
        for url in self.urls:
            with multitetra.connect(url) as server:
                steps = list(server.steps("gyroid", 0.1, error=0.25))
                self.assertTrue(steps[-1].is_final)
                self.assertEqual([step.number for step in steps], list(range(len(steps))))
                self.assertEqual([step.is_final for step in steps[:-1]], [False] * (len(steps) - 1))
                *_, again = server.steps("gyroid", 0.1, error=0.25)
                self.assertEqual(again.digest, steps[-1].digest)
                self.assertEqual(again.tiles_received, 0)

    def test_region_refines_and_keeps_topology(self):
        with multitetra.connect(self.urls[1]) as server:
            coarse = server.isosurface("gyroid", 0.1, error=2)
            region = multitetra.box([0, 0, 0], [16, 16, 16], error=0)
            fine = server.isosurface("gyroid", 0.1, error=2, regions=[region], region_coordinates="index")
        self.assertGreater(len(fine.faces), len(coarse.faces))
        self.assertEqual(fine.euler_characteristic, coarse.euler_characteristic)

    def test_views_and_grids_refine_locally(self):
        with multitetra.connect(self.urls[0]) as server:
            counts = [
                len(server.isosurface("gyroid", 0.1, error=4, **request).faces)
                for request in (
                    {},
                    {"view": multitetra.camera([-20, 16, 16], 40, 600, 2)},
                    {"threshold_grid": multitetra.grid(np.full((1, 2, 1), 0.25), spacing=[40, 16, 40], origin=[16, 8, 16])},
                )
            ]
        self.assertGreater(counts[1], counts[0])
        self.assertGreater(counts[2], counts[0])

    def test_estimate_is_near_the_surface(self):
        with multitetra.connect(self.urls[1]) as server:
            size = server.estimate("gyroid", 0.1, error=0.5)
            vertices, faces = server.isosurface("gyroid", 0.1, error=0.5)
            self.assertEqual(vertices.shape[1], 3)
            self.assertLess(abs(size.triangles - len(faces)), 0.4 * len(faces))
            with self.assertRaisesRegex(ValueError, "0 or greater"):
                server.estimate("gyroid", 0.1, error=-1)
            whole = server.isosurface("gyroid", 0.1, error=0.5, simplify=False)
            self.assertLess(2 * len(faces), len(whole.faces))
            self.assertEqual(whole.euler_characteristic, server.isosurface("gyroid", 0.1).euler_characteristic)

    def test_quality_names_an_error(self):
        with multitetra.connect(self.urls[0]) as server:
            draft, two = (server.isosurface("gyroid", 0.1, **error) for error in ({"quality": "draft"}, {"error": 2}))
            np.testing.assert_array_equal(draft.faces, two.faces)
            with self.assertRaisesRegex(ValueError, "exclude each other"):
                server.isosurface("gyroid", 0.1, error=1, quality="fine")

    def test_normals_have_unit_length(self):
        with multitetra.connect(self.urls[0]) as server:
            surface = server.isosurface("gyroid", 0.1, normals=8)
        np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1, atol=1e-4)

    def test_abandoned_stream_does_not_affect_the_next(self):
        with multitetra.connect(self.urls[1]) as server:
            for _ in server.steps("gyroid", 0.1, error=0):
                break
            self.assertGreater(len(server.isosurface("gyroid", 0.2, error=1).faces), 0)

    def test_rejections_have_exception_types(self):
        with multitetra.connect(self.urls[1]) as server:
            with self.assertRaises(KeyError):
                server.isosurface("nowhere", 0.1)
            with self.assertRaisesRegex(KeyError, "Did you mean .*gyroid"):
                server.isosurface("gryoid", 0.1)
            with self.assertRaises(ValueError):
                server.isosurface("gyroid", float("nan"))
            with self.assertRaises(KeyError):
                server.isosurface("gyroid", 0.1, color_by="nowhere")
            with self.assertRaises(multitetra.ServerError) as refused:
                server.isosurface("gyroid", 0.1, max_triangles=1)
            self.assertEqual(refused.exception.code, "limit_exceeded")
            self.assertEqual(len(server.isosurface("gyroid", 1e9).faces), 0)

    def test_another_request_ends_a_stream(self):
        with multitetra.connect(self.urls[0]) as server:
            steps = server.steps("gyroid", 0.1, error=0)
            next(steps)
            self.assertGreater(server.estimate("gyroid", 0.1, error=1).triangles, 0)
            with self.assertRaises(multitetra.ServerError) as ended:
                next(steps)
            self.assertEqual(ended.exception.code, "cancelled")

    def test_rejects_damaged_tiles(self):
        def flip_a_bit_of_the_first_tile(frame, seen):
            if frame[0] != 0x22 or seen:  # The tag of ServerMessage.tile.
                return frame
            seen.append(frame)
            middle = len(frame) // 2
            return frame[:middle] + bytes([frame[middle] ^ 0x55]) + frame[middle + 1 :]

        with Meddler(self.urls[0], flip_a_bit_of_the_first_tile) as url, multitetra.connect(url) as server:
            with self.assertRaisesRegex(multitetra.CheckError, "tile"):
                server.isosurface("gyroid", 0.1, error=0.5)
            # Nothing of the failed step is cached, and the connection remains usable.
            self.assertGreater(len(server.isosurface("gyroid", 0.1, error=0.5).faces), 0)

    def test_rejects_wrong_steps(self):
        for requested, answered in ((0.1, 0.2), (0.5, float("nan"))):  # The isovalue and the error.
            def meddle(frame, _):
                if frame[0] != STEP_BEGIN:
                    return frame
                return frame.replace(struct.pack("<d", requested), struct.pack("<d", answered))

            with Meddler(self.urls[0], meddle) as url, multitetra.connect(url) as server:
                # A message with a NaN violates the protocol.
                with self.assertRaises((multitetra.CheckError, ConnectionError)):
                    server.isosurface("gyroid", 0.1, error=0.5)

    def test_rejects_steps_without_end(self):
        def repeat_the_preview(frame, seen):
            if frame[0] not in (STEP_BEGIN, STEP_END):
                return frame
            seen.append(as_preview(frame))
            return self._repeated(*seen) if frame[0] == STEP_END else seen[0]

        steps = []
        with Meddler(self.urls[0], repeat_the_preview) as url, multitetra.connect(url) as server:
            with self.assertRaisesRegex(multitetra.CheckError, "not finer than the step before"):
                steps.extend(step.number for step in server.steps("gyroid", 0.1, error=1, final_only=True))
        self.assertEqual(steps, list(range(len(steps))))
        self.assertLessEqual(len(steps), 64)

    @staticmethod
    def _repeated(begin, end):
        yield end
        for number in itertools.count(1):
            step = b"\x10" + varint(number)  # StepBegin.step and StepEnd.step.
            yield with_fields(begin, step)
            yield with_fields(end, step + b"\x18\0\x20\0")  # No tiles and no bytes are sent again.

    def test_times_out_on_a_server_that_stalls_after_a_step(self):
        stalls = threading.Event()

        def stall_after_the_first_step(frame, seen):
            if seen:  # Also on another connection.
                stalls.wait()
            yield as_preview(frame)
            if frame[0] == STEP_END:
                seen.append(frame)

        try:
            with Meddler(self.urls[0], stall_after_the_first_step) as url, multitetra.connect(url, timeout=0.5) as server:
                steps = server.steps("gyroid", 0.1, error=1, final_only=True)
                self.assertFalse(next(steps).is_final)
                began = time.monotonic()
                with self.assertRaisesRegex(ConnectionError, "0.5 s"):
                    next(steps)
                self.assertLess(time.monotonic() - began, 60)  # With retries on other connections.
        finally:
            stalls.set()

    def test_sanitizes_server_texts(self):
        text = b"\x1b[2J\r\nall is well\n" * 1000
        reply = b"\x10\x08\x1a" + bytes([len(text) & 127 | 128, len(text) >> 7 & 127 | 128, len(text) >> 14]) + text

        def meddle(frame, _):
            if frame[0] != 0x3A:  # The tag of ServerMessage.error.
                return frame
            size = len(reply)
            return b"\x3a" + bytes([size & 127 | 128, size >> 7 & 127 | 128, size >> 14]) + reply

        with Meddler(self.urls[0], meddle) as url, multitetra.connect(url) as server:
            with self.assertRaises(multitetra.ServerError) as refused:
                server.isosurface("gyroid", 0.1, max_triangles=1)
        message = str(refused.exception)
        self.assertTrue(message.isprintable(), message)
        self.assertLess(len(message), 1100)

    def test_reconnects_without_repeating_tiles(self):
        def cut_once_behind_the_first_tiles(frame, seen):
            seen.append(len(frame))
            return None if len(seen) == 9 else frame

        with multitetra.connect(self.urls[0]) as server:
            *_, whole = server.steps("gyroid", 0.1, error=0)
        with Meddler(self.urls[0], cut_once_behind_the_first_tiles) as url, multitetra.connect(url) as server:
            *_, last = server.steps("gyroid", 0.1, error=0)
        self.assertEqual(last.digest, whole.digest)

    def test_times_out_on_silent_server_without_blocking_threads(self):
        counts = []
        with Silence() as url:
            counter = threading.Thread(target=lambda: [counts.append(time.sleep(0.001)) for _ in range(100)])
            counter.start()
            with self.assertRaisesRegex(ConnectionError, "within 0.5 s"):
                multitetra.connect(url, timeout=0.5)
            self.assertGreater(len(counts), 50)
            counter.join()

    def test_a_channel_may_be_dropped_by_the_function_that_it_calls(self):
        held, is_held, is_dropped = [], threading.Event(), threading.Event()

        def closed(_):
            is_held.wait()
            held.clear()  # The last reference.
            is_dropped.set()

        held.append(multitetra._client.Channel("tcp://127.0.0.1:1", "", False, lambda message: None, closed))
        is_held.set()
        self.assertTrue(is_dropped.wait(10))

    def test_ctrl_c_interrupts_a_wait(self):
        script = "import multitetra, sys; print('waits', flush=True); multitetra.connect(sys.argv[1])"
        with Silence() as url:
            waiting = subprocess.Popen(
                [sys.executable, "-c", script, url], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
            waiting.stdout.readline()
            time.sleep(0.5)
            began = time.monotonic()
            waiting.send_signal(signal.SIGINT)
            _, output = waiting.communicate(timeout=30)
        self.assertLess(time.monotonic() - began, 5)
        self.assertIn("KeyboardInterrupt", output)

    def test_raises_errors_at_the_call(self):
        with self.assertRaisesRegex(ValueError, "nonsense://"):
            multitetra.connect("nonsense://here")
        with self.assertRaises(ConnectionError):
            multitetra.connect("tcp://127.0.0.1:1")
        with multitetra.connect(self.urls[0]) as server:
            with self.assertRaisesRegex(ValueError, "unit"):
                server.isosurface("gyroid", 0.1, unit="inch")
        with self.assertRaisesRegex(ConnectionError, "closed"):
            server.datasets()

    def test_version_equals_the_programs(self):
        output = subprocess.run([PROGRAMS / "multitetra-client", "--version"], capture_output=True, text=True).stdout
        self.assertIn(multitetra.__version__, output)

    def test_example_runs(self):
        example = pathlib.Path(__file__).parents[3] / "client/python/examples/surface.py"
        result = subprocess.run([sys.executable, example, self.urls[1]], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("its area", result.stdout)


if __name__ == "__main__":
    unittest.main()
