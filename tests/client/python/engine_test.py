"""Tests surfaces in the process. Usage: engine_test.py DIRECTORY_OF_PROGRAMS (with PYTHONPATH set)"""

import doctest
import importlib
import inspect
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
import warnings
import zipfile

try:
    import numpy as np
except ImportError as missing:
    print(f"!! SKIPPED: surfaces in the process are not tested: {missing}")
    sys.exit(77)

import multitetra
import multitetra.volume

PROGRAMS = pathlib.Path(sys.argv.pop(1)) if len(sys.argv) > 1 else None


def ball(shape=(24, 26, 29), dtype=np.float32):
    """Greatest in the middle; every axis differs."""
    x, y, z = np.meshgrid(*(np.linspace(-1, 1, side) for side in shape), indexing="ij")
    return (1 - np.sqrt(x**2 + 1.5 * y**2 + 2 * z**2)).astype(dtype)


def digest(data, isovalue=0.25, **how):
    return multitetra.isosurface(data, isovalue, **how).certificate.content_digest


def needs(library):
    try:
        importlib.import_module(library)
    except ImportError:
        return unittest.skip(f"!! SKIPPED: {library} is not installed")
    return lambda test: test


class Surfaces(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def run_server(self, *words):
        return subprocess.run([PROGRAMS / "multitetra-server", *words], check=True, capture_output=True, text=True).stdout

    def serve_bucket(self):
        """Lets s3://volumes/ lead to a folder, which it returns, in processes that are started after it."""
        (self.path / "bucket").mkdir()
        program = pathlib.Path(__file__).parents[2] / "support" / "serve_folder.py"
        server = subprocess.Popen([sys.executable, program, self.path / "bucket"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(server.communicate)
        self.addCleanup(server.terminate)
        endpoint = server.stdout.readline().split()[0] + "/s3"
        keys = {"AWS_ENDPOINT_URL": endpoint, "AWS_ACCESS_KEY_ID": "reader", "AWS_SECRET_ACCESS_KEY": "a secret"}
        replaced = unittest.mock.patch.dict(os.environ, keys)
        replaced.start()
        self.addCleanup(replaced.stop)
        return self.path / "bucket"

    def test_equals_the_command_line(self):
        np.save(self.path / "ball.npy", ball())
        self.run_server("prepare", self.path / "ball.npy", "-o", self.path / "ball.mtd", "--samples-only", "--spacing", "3,2,1", "--quiet")
        for how, options in (
            ({"error": 0.5}, ["--error", "0.5"]),
            ({"error": 0.3, "simplify": False, "unit": "world"}, ["--error", "0.3", "--simplify", "off", "--unit", "world"]),
            ({"max_triangles": 300}, ["--max-triangles", "300"]),
        ):
            words = ["extract", self.path / "ball.mtd", "--isovalue", "0.25", *options, "-o", self.path / "ball.ply", "--json"]
            report = json.loads(self.run_server(*words))
            mesh = multitetra.isosurface(ball(), 0.25, spacing=(1, 2, 3), **how)
            certificate = mesh.certificate
            self.assertEqual(certificate.content_digest, report["content_digest"])
            self.assertEqual(len(mesh.faces), report["triangles"])
            for name in ("components", "euler_characteristic", "border_edges", "open_edges", "nonmanifold_edges"):
                self.assertEqual(getattr(certificate, name), report[name])
            self.assertGreaterEqual(certificate.error_bound, report["error_bound_world"])

    def test_vertices_have_the_order_of_axes_and_face_low_values(self):
        spacing = np.array([0.5, 2, 1])
        for array in (ball(), np.asfortranarray(ball()), ball()[::-1, :, ::-1]):
            mesh = multitetra.isosurface(array, 0.25, error=0, spacing=spacing)
            middle = (np.array(ball().shape) - 1) / 2 * spacing
            np.testing.assert_allclose(mesh.bounds.mean(axis=0), middle, atol=1e-9)
            radii = 0.75 / np.sqrt([1, 1.5, 2]) * middle
            np.testing.assert_allclose(mesh.bounds[1] - middle, radii, atol=0.05)
            self.assertAlmostEqual(mesh.volume / (4 / 3 * np.pi * radii.prod()), 1, delta=0.02)  # Positive: it faces outwards.
            self.assertTrue(mesh.certificate.is_watertight)

    def test_affine_places_samples(self):
        affine = np.array([[0, -2, 0, 10], [3, 0, 0, -5], [0, 0, 1, 2], [0, 0, 0, 1.0]])
        plain = multitetra.isosurface(ball(), 0.25, error=0)
        placed = multitetra.isosurface(ball(), 0.25, error=0, affine=affine)
        there = plain.vertices @ affine[:3, :3].T + affine[:3, 3]
        np.testing.assert_allclose(np.sort(placed.vertices, axis=0), np.sort(there, axis=0))
        self.assertAlmostEqual(placed.volume, 6 * plain.volume, delta=1e-6)

    def test_every_numeric_type_and_layout_gives_the_same_surface(self):
        expected = digest(ball())
        np.save(self.path / "ball.npy", ball())
        for array in (ball().astype(">f4"), ball().astype(np.float64), ball().astype(">f8"), np.load(self.path / "ball.npy", mmap_mode="r"),
                      np.ma.masked_array(ball(), False), ball().astype(np.longdouble), ball().tolist()):  # fmt: skip
            self.assertEqual(digest(array), expected)
        expected = digest(np.round(100 * ball()), 25.5)
        for dtype in ("i2", ">i2", "i4", "i8", ">i8", "f2"):
            self.assertEqual(digest(np.round(100 * ball()).astype(dtype), 25.5), expected, dtype)
        expected = digest(np.maximum(100 * ball(), 0).astype(np.uint8), 25.5)
        for dtype in ("i1", "u2", ">u2", "u4", "u8"):
            self.assertEqual(digest(np.maximum(100 * ball(), 0).astype(dtype), 25.5), expected, dtype)
        self.assertEqual(digest(ball() > 0.25, 0.5), digest((ball() > 0.25).astype(np.uint8), 0.5))
        self.assertEqual(digest(np.asfortranarray(ball())), digest(np.ascontiguousarray(ball().T)))

    def test_regions_in_indices_have_the_order_of_axes(self):
        regions = [multitetra.half_space((1, 0, 0), 12, 0.05), multitetra.box((2, 3, 4), (9, 20, 12), 0.1)]
        view = multitetra.camera((30, 2, 1), 40, 800, 2)
        for order in "CF":
            volume = multitetra.Volume(np.array(ball(), order=order))
            for how in ({"regions": regions}, {"view": view}):
                of = [volume.isosurface(0.25, error=3, region_coordinates=name, **how).certificate.content_digest for name in ("world", "index")]
                self.assertEqual(*of)

    def test_masked_samples_are_void(self):
        array = ball()
        is_masked = np.indices(array.shape)[0] > 11
        with_nan = np.where(is_masked, np.nan, array)
        expected = digest(with_nan)
        self.assertEqual(digest(np.ma.masked_array(array, is_masked)), expected)
        mesh = multitetra.isosurface(np.ma.masked_array((100 * array).astype(np.int16), is_masked), 25.5)
        self.assertLessEqual(mesh.bounds[1][0], 11)
        self.assertGreater(mesh.certificate.border_edges, 0)
        closed = multitetra.isosurface(array[:12], 0.25, pad_value=-1)
        self.assertTrue(closed.certificate.is_watertight)

    @needs("dask")
    def test_dask_arrays_are_read_by_slabs(self):
        import dask.array

        counted = []

        def count(block):
            if block.size:
                counted.append(block.shape)
            return block

        chunked = dask.array.from_array(ball(), chunks=(7, 26, 29))
        self.assertEqual(digest(chunked.map_blocks(count, meta=np.empty((0, 0, 0), np.float32))), digest(ball()))
        self.assertEqual(len(counted), 4)  # Each chunk once.

    @needs("distributed")
    def test_dask_prepares_the_file_of_one_machine(self):
        import dask.array
        import distributed

        import multitetra.dask

        samples = np.random.default_rng(1).standard_normal((40, 50, 150), np.float32)
        alone = multitetra.prepare(samples, self.path / "alone.mtd", spacing=(1, 2, 3), pad_value=0)
        np.save(self.path / "samples.npy", samples)
        bucket = self.serve_bucket()
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
            made = multitetra.dask.prepare(client, samples, "s3://volumes/made.mtd", parts=3, spacing=(1, 2, 3), pad_value=0)
            self.assertEqual(made, "s3://volumes/made.mtd")
            self.assertEqual((bucket / "made.mtd").read_bytes(), pathlib.Path(alone).read_bytes())
            with self.assertRaisesRegex(multitetra.VolumeError, "Cannot .* 's3://elsewhere/.*status 403"):
                multitetra.dask.prepare(client, samples, "s3://elsewhere/made.mtd")
            for data in (samples, dask.array.from_array(samples, chunks=(16, 50, 150))):
                made = multitetra.dask.prepare(client, data, self.path / "made.mtd", parts=3, spacing=(1, 2, 3), pad_value=0)
                self.assertEqual(pathlib.Path(made).read_bytes(), pathlib.Path(alone).read_bytes())
                os.remove(made)
        self.assertEqual(sorted(file.name for file in self.path.iterdir()), ["alone.mtd", "bucket", "samples.npy"])

    @needs("distributed")
    def test_dask_prepares_times_as_one_machine_does(self):
        import distributed

        import multitetra.dask
        from multitetra.programs import server_program

        source, options = str(self.path / "times"), ("--time-series", "beat")
        os.mkdir(source)
        for number in range(5):
            np.save(f"{source}/beat{number}.npy", ball() + np.float32(0.1 * number))
        subprocess.run([server_program(), "prepare", source, "-o", str(self.path / "alone"), "--quiet", *options], check=True)
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
            made = pathlib.Path(multitetra.dask.prepare_series(client, source, self.path / "made", *options, parts=3))
            with self.assertRaisesRegex(multitetra.VolumeError, "nowhere"):
                multitetra.dask.prepare_series(client, "nowhere.nii", self.path / "never", "--all-times")
        self.assertEqual(sorted(file.name for file in made.iterdir()), [f"beat.t000{number}.mtd" for number in range(5)])
        for file in made.iterdir():
            self.assertEqual(file.read_bytes(), (self.path / "alone" / file.name).read_bytes(), file.name)

    @needs("xarray")
    def test_xarray_states_coordinates_and_units(self):
        import xarray

        coordinates = {"u": np.linspace(0, 1, 24), "v": 5 - 0.25 * np.arange(26), "w": np.arange(29) * 2.0}
        data = xarray.DataArray(ball(), dims=("u", "v", "w"), coords=coordinates, attrs={"units": "K"}, name="temperature")
        for dim in "uvw":
            data[dim].attrs["units"] = "km"
        volume = multitetra.Volume(data)
        self.assertEqual((volume.info.name, volume.info.unit, volume.info.value_unit), ("temperature", "km", "K"))
        self.assertEqual(volume.shape, (24, 26, 29))
        np.testing.assert_allclose(volume.spacing, [1 / 23, 0.25, 2])
        middle = [places.mean() for places in coordinates.values()]
        np.testing.assert_allclose(volume.isosurface(0.25).bounds.mean(axis=0), middle, atol=0.01)
        uneven = data.assign_coords(u=np.linspace(0, 1, 24) ** 2)
        with self.assertRaisesRegex(ValueError, "'u' is uneven"):
            multitetra.Volume(uneven)
        # What is given replaces that alone.
        volume = multitetra.Volume(uneven, spacing=(1, 2, 3))
        np.testing.assert_allclose(volume.isosurface(0.25).bounds.mean(axis=0), [11.5, 5 - 25, 42], atol=0.1)
        volume = multitetra.Volume(data, origin=(100, 0, 0))
        np.testing.assert_allclose(volume.isosurface(0.25).bounds.mean(axis=0), [100.5, -3.125, 28], atol=0.02)
        # Axes in several units.
        data["u"].attrs["units"] = "m"
        volume = multitetra.Volume(data)
        self.assertEqual(volume.info.unit, "m")
        np.testing.assert_allclose(volume.spacing, [1 / 23, 250, 2000])
        np.testing.assert_allclose(volume.isosurface(0.25).bounds.mean(axis=0), [0.5, 1875, 28000], rtol=0.01)
        data["u"].attrs["units"] = "s"
        with self.assertWarnsRegex(multitetra.VolumeWarning, "no common unit .'s' and 'km'."):
            self.assertEqual(multitetra.Volume(data).info.unit, "")
        with self.assertRaisesRegex(TypeError, "one array of a data set"):
            multitetra.Volume(data.to_dataset())

    def test_what_reading_gives_counts(self):
        """Libraries unpack and mask what they store otherwise."""

        class Unpacked:  # As variables of netCDF4.
            ndim, dtype = 3, np.dtype(np.int16)

            def __init__(self, values):
                self.values, self.shape = values, values.shape

            def __getitem__(self, index):
                return self.values[index]

        floats = ball() * 0.5
        masked = np.ma.masked_less(floats, 0)
        for values in (floats, masked):
            self.assertEqual(digest(Unpacked(values), 0.125), digest(values, 0.125))
        self.assertEqual(digest([layer for layer in masked], 0.125), digest(masked, 0.125))

    @needs("dask")
    def test_dask_arrays_that_say_what_they_are_not_are_refused(self):
        import dask.array

        whole = dask.array.from_array(np.arange(24**3).reshape(24, 24, 24), chunks=8)
        floats = whole.map_blocks(lambda block: block / 7.5, meta=np.empty((0, 0, 0), np.int32))
        with self.assertRaisesRegex(TypeError, "its samples are int32, but reading gives float64"):
            multitetra.Volume(floats)
        masked = whole.map_blocks(lambda block: np.ma.masked_less(block, 50), meta=np.empty((0, 0, 0), int))
        with self.assertRaisesRegex(TypeError, "Some samples are masked"):
            multitetra.Volume(masked)
        void = whole.map_blocks(lambda block: np.ma.masked_less(block.astype(float), 5000), meta=np.empty((0, 0, 0)))
        self.assertEqual(multitetra.Volume(void).info.void_samples, 5000)

    @needs("vtkmodules")
    def test_vtk_images_keep_their_geometry(self):
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonDataModel import vtkImageData

        values = ball()  # By z, y, x.
        image = vtkImageData()
        image.SetExtent(5, 33, 0, 25, 0, 23)
        image.SetSpacing(1, 2, 3)
        image.SetOrigin(-5, 10, 20)
        with self.assertRaisesRegex(ValueError, "no active scalars"):
            multitetra.Volume(image)
        image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=True))
        mesh = multitetra.isosurface(image, 0.25)
        np.testing.assert_allclose(mesh.bounds.mean(axis=0), [14, 35, 54.5], atol=0.1)

    @needs("nibabel")
    def test_nibabel_images_keep_their_geometry(self):
        import nibabel

        affine = np.array([[-2.0, 0, 0, 90], [0, 2, 0, -126], [0, 0, 3, -72], [0, 0, 0, 1]])
        image = nibabel.Nifti1Image(ball(), affine)
        image.header.set_xyzt_units("mm")
        expected = multitetra.isosurface(ball(), 0.25, affine=affine).bounds
        for suffix in (".nii", ".nii.gz"):
            nibabel.save(image, self.path / f"ball{suffix}")
            volume = multitetra.Volume(nibabel.load(self.path / f"ball{suffix}"))
            self.assertEqual((volume.info.unit, volume.info.space), ("mm", "RAS"))
            np.testing.assert_allclose(volume.isosurface(0.25).bounds, expected, atol=0.5)
            from_file = multitetra.Volume(self.path / f"ball{suffix}")  # The readers' coordinates are LPS.
            self.assertTrue(multitetra.certify(from_file.isosurface(0.25), volume, 0.25, error=0.5))
            named = multitetra.Volume(self.path / f"ball{suffix}", space="RAS")  # As the file says.
            np.testing.assert_allclose(named.info.affine, from_file.info.affine)
            other = multitetra.Volume(self.path / f"ball{suffix}", space="LPS")
            np.testing.assert_allclose(other.info.affine, np.diag([-1, -1, 1, 1]) @ from_file.info.affine)
            np.testing.assert_allclose(from_file.isosurface(0.25).bounds[1][2], expected[1][2], atol=0.5)
        with self.assertRaisesRegex(ValueError, "states where its samples lie"):
            multitetra.Volume(image, spacing=1)

    def test_itk_images_keep_their_geometry(self):
        """Images have the functions that SimpleITK's and ITK's have in common; indices are x, y, z, arrays z, y, x."""
        turned = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]

        class Image:
            def GetNumberOfComponentsPerPixel(self):
                return 1

            def GetSpacing(self):
                return (1.0, 2.0, 3.0)

            def GetOrigin(self):
                return (10.0, 20.0, 30.0)

            def GetDirection(self):
                return np.ravel(turned)

        Image.__module__ = "SimpleITK.SimpleITK"
        library = types.SimpleNamespace(GetArrayViewFromImage=lambda image: ball())
        with unittest.mock.patch.dict(sys.modules, {"SimpleITK": library}):
            mesh = multitetra.isosurface(Image(), 0.25)
        index = (np.array(ball().shape)[::-1] - 1) / 2
        np.testing.assert_allclose(mesh.bounds.mean(axis=0), [10 - 2 * index[1], 20 + index[0], 30 + 3 * index[2]], atol=0.1)

    @needs("h5py")
    def test_hdf5_and_zarr_arrays_are_read_by_chunks(self):
        import h5py

        with h5py.File(self.path / "ball.h5", "w") as file:
            self.assertEqual(digest(file.create_dataset("ball", data=ball(), chunks=(5, 9, 9))), digest(ball()))

    def test_files_are_read(self):
        np.save(self.path / "ball.npy", ball())
        volume = multitetra.Volume(self.path / "ball.npy", spacing=(3, 2, 1), unit="mm")
        self.assertEqual(repr(volume), "<Volume ball: shape (29, 26, 24), spacing (3.0, 2.0, 1.0) mm, values -1.12132 to MAX>".replace(
            "MAX", str(round(volume.info.max, 5))))  # fmt: skip
        far = multitetra.Volume(ball().astype(np.float64) + 1737400, subtract=0, allow_loss=True)
        self.assertRegex(repr(far), r"values 1737398\.875 to 1737400\.875>$")
        made = volume.isosurface(0.25).certificate
        file = multitetra.prepare(ball(), self.path / "ball.mtd", spacing=(1, 2, 3))
        prepared = multitetra.Volume(file).isosurface(0.25, simplify=False).certificate
        self.assertEqual(prepared.euler_characteristic, made.euler_characteristic)
        self.assertIn("all checksums match", self.run_server("verify", file))
        with self.assertRaisesRegex(multitetra.VolumeError, "does not exist"):
            multitetra.Volume(self.path / "none.nrrd")
        (self.path / "damaged.nii").write_bytes(b"\x5c\x01\0\0" + bytes(348))
        with self.assertRaisesRegex(multitetra.VolumeError, "damaged.nii"):
            multitetra.Volume(self.path / "damaged.nii")
        with self.assertRaisesRegex(TypeError, "states this itself: spacing"):
            multitetra.Volume(file, spacing=2)

    def test_what_files_state_is_not_ignored(self):
        multitetra.prepare(ball(), self.path / "ball")  # A dataset without a suffix.
        self.assertEqual(multitetra.Volume(self.path / "ball").shape, (29, 26, 24))
        for how in ({"subtract": 1}, {"name": "other"}, {"allow_loss": True}, {"spacing": 2}):
            with self.assertRaisesRegex(TypeError, f"states this itself: {next(iter(how))}"):
                multitetra.Volume(self.path / "ball", **how)
        self.run_server("generate", "sphere", "--size", "9", "-o", self.path / "a.nrrd")
        for how, text in (({"spacing": (1, -2, 3)}, "greater than 0"), ({"origin": (1, np.nan, 3)}, "finite")):
            with self.assertRaisesRegex(ValueError, text):
                multitetra.Volume(self.path / "a.nrrd", **how)
        for how in ({"time": "x"}, {"array": 5}, {"level": 1.5}, {"space": 3}):
            with self.assertRaisesRegex(TypeError, "not of the right type"):
                multitetra.Volume(self.path / "a.nrrd", **how)
        with self.assertRaises(TypeError):
            multitetra.Volume(self.path / "a.nrrd", pad_value=0, pad=1.5)
        np.testing.assert_allclose(multitetra.Volume(self.path / "a.nrrd", origin=5).info.affine[:3, 3], 5)

    def test_meshes_are_saved_as_they_are(self):
        mesh = multitetra.isosurface(ball(), 0.25, length_unit="mm", error=0.3)
        self.assertNotEqual(mesh, multitetra.isosurface(ball(), 0.25))  # By identity.
        for scalars in (np.arange(3 * len(mesh.vertices), dtype=np.float32).reshape(-1, 3)[:, 0], np.arange(len(mesh.vertices), dtype=np.float32)[::-1]):
            mesh.scalars = scalars
            mesh.save(self.path / "a.ply")
            mesh.scalars = scalars.copy()
            mesh.save(self.path / "b.ply")
            self.assertEqual((self.path / "a.ply").read_bytes(), (self.path / "b.ply").read_bytes())
        mesh.scalars = None
        mesh.save(self.path / "a.3mf")
        with zipfile.ZipFile(self.path / "a.3mf") as file:
            self.assertIn(b'unit="millimeter"', file.read("3D/3dmodel.model"))
        self.assertEqual([part.unit for part in mesh.components()], ["mm"])
        mesh.vertices[0] = np.nan
        with self.assertRaisesRegex(ValueError, "not finite"):
            mesh.save(self.path / "c.ply")

    def test_steps_refine_and_keep_the_topology(self):
        x = np.linspace(0, 4 * np.pi, 33)
        gyroid = (np.sin(x)[:, None, None] * np.cos(x)[None, :, None] + np.sin(x)[None, :, None] * np.cos(x)[None, None, :]
                  + np.sin(x)[None, None, :] * np.cos(x)[:, None, None]).astype(np.float32)  # fmt: skip
        volume = multitetra.Volume(gyroid)
        steps = list(volume.steps(0.1, error=0.25))
        self.assertEqual([step.is_final for step in steps], [False] * (len(steps) - 1) + [True])
        first = next(multitetra.Volume(np.tile(gyroid, (2, 2, 2))).steps(0.1, error=0.25))
        self.assertFalse(first.is_final)
        self.assertGreater(first.spacing, 1)
        self.assertIsNone(first.mesh.error_bound)
        final = volume.isosurface(0.1, error=0.25)
        self.assertEqual(final.certificate, steps[-1].mesh.certificate)
        exact = volume.isosurface(0.1, error=0)
        self.assertTrue(exact.is_full_resolution)
        for name in ("euler_characteristic", "components"):
            self.assertEqual(getattr(final.certificate, name), getattr(exact.certificate, name))
        one, two = volume.isosurface([-0.3, 0.3], error=0.05, max_triangles=3000)
        self.assertLessEqual(len(one.faces) + len(two.faces), 3000)
        self.assertLess(abs(volume.estimate(0.1, error=0.25) - len(final.faces)), 0.5 * len(final.faces))
        free = volume.isosurface(0.1, error=1, intersection_free=True)
        self.assertEqual(free.certificate.self_intersecting_triangles, 0)
        normals = volume.isosurface(0.1, error=1, normals=8).normals
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)

    def test_certifies_meshes_of_all_kinds(self):
        volume = multitetra.Volume(ball((14, 15, 16)), spacing=2, unit="mm")
        mesh = volume.isosurface(0.25, error=0.5)
        mesh.save(self.path / "ball.stl")
        mesh.save(self.path / "ball.3mf")
        alike = types.SimpleNamespace
        cells = np.column_stack([np.full(len(mesh.faces), 3), mesh.faces]).ravel()
        for other in (mesh, self.path / "ball.stl", self.path / "ball.3mf", (mesh.vertices, mesh.faces), alike(vertices=mesh.vertices, faces=mesh.faces),
                      alike(vertices=mesh.vertices, triangles=mesh.faces), alike(points=mesh.vertices, faces=cells)):  # fmt: skip
            found = multitetra.certify(other, volume, 0.25, error=0.6)
            self.assertTrue(found and found.proven and found.topology_kept and found.watertight, str(found))
            self.assertLess(found.distance, 1.2)
        moved = multitetra.certify((mesh.vertices + [2, 0, 0], mesh.faces), volume, 0.25, error=1.5, unit="world")
        self.assertFalse(moved)
        self.assertIn("NOT certified", str(moved))
        self.assertFalse(multitetra.certify((mesh.vertices, mesh.faces[:, ::-1]), volume, 0.25, error=1))
        self.assertTrue(multitetra.certify((mesh.vertices, mesh.faces[:, ::-1]), volume, 0.25, error=1, inside_out=True))
        # Of other libraries: cells that are no triangles are not left out.
        block = lambda kind, data: types.SimpleNamespace(type=kind, data=data)  # noqa: E731
        meshio = alike(points=mesh.vertices, cells=[block("triangle", mesh.faces), block("line", mesh.faces[:, :2])])
        self.assertTrue(multitetra.certify(meshio, volume, 0.25, error=0.6))
        meshio.cells.append(block("quad", np.zeros((1, 4), int)))
        with self.assertRaisesRegex(ValueError, "cells of type quad"):
            multitetra.certify(meshio, volume, 0.25, error=0.6)
        for how, text in (({"error": np.nan}, "error is nan"), ({"error": -1}, "0 or greater"), ({"isovalue": np.inf}, "isovalue is inf"),
                          ({"min_component": np.inf}, "min_component"), ({"lattice": 99}, "lattice is 99")):  # fmt: skip
            with self.assertRaisesRegex(ValueError, text):
                multitetra.certify(mesh, volume, **{"isovalue": 0.25, **how})
        with self.assertRaisesRegex(TypeError, "Faces are numbers"):
            multitetra.certify((mesh.vertices, mesh.faces + 0.7), volume, 0.25)
        # Its own files say how vertices were rounded, and the unit.
        fine = volume.isosurface(0.25, error=0.01)
        for suffix in ("ply", "stl", "obj", "3mf"):
            fine.save(self.path / f"fine.{suffix}")
            self.assertTrue(multitetra.certify(self.path / f"fine.{suffix}", volume, 0.25, error=0.01), suffix)
        in_metres = multitetra.Volume(ball((14, 15, 16)), spacing=0.002, unit="m")
        self.assertTrue(multitetra.certify(self.path / "fine.3mf", in_metres, 0.25, error=0.01))
        for vertices, faces in ((mesh.vertices[:9], mesh.faces), (mesh.vertices * np.nan, mesh.faces), (mesh.vertices, -mesh.faces.astype(int))):
            with self.assertRaises(ValueError):
                multitetra.certify((vertices, faces), volume, 0.25)

    @needs("skimage")
    def test_lies_where_scikit_image_has_it(self):
        from skimage.measure import marching_cubes

        volume = multitetra.Volume(ball(), spacing=(0.7, 0.7, 1))
        for direction in ("descent", "ascent"):
            vertices, faces, _, _ = marching_cubes(ball(), 0.25, spacing=(0.7, 0.7, 1), gradient_direction=direction)
            found = multitetra.certify((vertices, faces), volume, 0.25, error=0.5, inside_out=direction == "descent")
            self.assertTrue(found, str(found))

    def test_interrupts_end_calls_soon(self):
        volume = multitetra.Volume(np.random.default_rng(1).standard_normal((150, 150, 150), np.float32))
        for call in (lambda: volume.isosurface(0.1, error=0.25), lambda: list(volume.steps(0.1, error=0.25))):
            self.assert_interrupted(call)

    def assert_interrupted(self, call):
        before = signal.signal(signal.SIGALRM, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        asked = time.monotonic() + 0.3
        try:
            with self.assertRaises(KeyboardInterrupt):
                call()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
        self.assertLess(time.monotonic() - asked, 3)  # 0.1 on a quiet machine.

    def test_other_threads_run_meanwhile(self):
        volume = multitetra.Volume(ball((60, 60, 60)))
        ticks, is_done = [], threading.Event()

        def tick():
            while not is_done.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.001)

        ticking = threading.Thread(target=tick)
        ticking.start()
        results = []
        threads = [threading.Thread(target=lambda: results.append(volume.isosurface(0.25).certificate)) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        is_done.set()
        ticking.join()
        self.assertEqual(len(set(results)), 1)
        self.assertEqual(results[0], multitetra.Volume(ball((60, 60, 60)), threads=1).isosurface(0.25).certificate)
        self.assertLess(max(np.diff(ticks)), 0.5)

    def test_progress_is_reported_and_may_stop(self):
        stages = []
        volume = multitetra.Volume(ball((70, 70, 70)), progress=lambda stage, fraction: stages.append((stage, fraction)))
        volume.isosurface(0.25)
        self.assertTrue({"surface", "checks"}.intersection(stage for stage, _ in stages), stages)
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in stages))

        def stop(stage, fraction):
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            multitetra.Volume(ball(), progress=stop)

    def test_errors_of_arrays_are_raised_as_they_are(self):
        class Broken:
            shape, ndim, dtype = (9, 9, 9), 3, np.dtype(np.float32)

            def __getitem__(self, index):
                raise OSError("the disk is gone")

        with self.assertRaisesRegex(OSError, "the disk is gone"):
            multitetra.Volume(Broken())

    def test_mistakes_are_named(self):
        for data, how, error, text in (
            (ball()[0], {}, ValueError, "three axes"),
            (ball().astype(complex), {}, TypeError, "no real numbers"),
            (ball(), {"spacing": 0}, ValueError, "greater than 0"),
            (ball(), {"spacing": 1, "affine": np.eye(4)}, ValueError, "give either"),
            (ball(), {"affine": np.eye(3)}, ValueError, "shape"),
            (ball(), {"affine": [[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}, multitetra.VolumeError, "right angles"),
            (ball(), {"affine": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [5, 6, 7, 1]]}, ValueError, "Is it transposed"),
            (ball(), {"affine": np.diag([1, 0, 1, 1])}, ValueError, "neither tiny nor huge"),
            (ball(), {"affine": [[1, 1, 0, 0], [0, 0, 0, 0], [0, 0, 1, 0]]}, ValueError, "the same direction"),
            (ball(), {"spacing": 1e-300}, ValueError, "neither tiny nor huge"),
            (ball(), {"origin": (0, np.nan, 0)}, ValueError, "coordinates are finite"),
            (ball(), {"origin": 1e17}, ValueError, "so far away"),
            (multitetra.Volume(ball()), {}, TypeError, "not a Volume"),
            (ball(), {"max_triangles": 1}, ValueError, "too small"),
            (ball(), {"error": -1}, ValueError, "0 or greater"),
            (ball(), {"color_by": "x"}, TypeError, "no colors"),
            (ball(), {"eror": 1}, TypeError, "eror"),
            (ball(), {"threads": -1}, ValueError, "threads"),
        ):
            with self.assertRaisesRegex(error, text):
                multitetra.isosurface(data, 0.25, **how)

    def test_only_losses_are_warned_of(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            digest(ball(dtype=float))
            digest(np.round(100 * ball()).astype(int), 25.5)
        with self.assertWarnsRegex(multitetra.VolumeWarning, "errors of at most"):
            digest(ball(dtype=float) + 1000, 1000.25)
        with self.assertRaisesRegex(multitetra.VolumeError, "subtract"):
            digest(ball(dtype=float) + 1e7, 1e7 + 0.25)
        # A value far away, such as that of missing samples, does not hide what is lost of the others; noise of doubles is no loss.
        noise = np.where(ball() > 0.25, 400, 293.15 + 1e-13 * np.arange(ball().size).reshape(ball().shape) % 1e-12)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            digest(noise, 350)
        outlier = np.round(100 * ball()).astype(np.int64) + 10**9
        outlier[0, 0, 0] = -(10**11)
        with self.assertRaisesRegex(multitetra.VolumeError, "of their range without its ends. .* subtract=1e.09"):
            digest(outlier, 10**9 + 25.5)
        kept = multitetra.Volume(outlier, subtract=10**9).isosurface(25.5)
        self.assertEqual(len(kept.faces), len(multitetra.isosurface(np.round(100 * ball()), 25.5).faces))
        # Also where one face of a volume differs, of as many samples along x as computers like.
        random = np.random.default_rng(1)
        inflow = random.uniform(0, 2, (32, 64, 64))
        inflow[..., 0] = 1 + random.uniform(-1e-8, 1e-8, (32, 64))
        multitetra.Volume(inflow)
        fill = 1e8 + random.uniform(0, 100, (32, 64, 64))
        fill[..., 0] = 0
        with self.assertRaisesRegex(multitetra.VolumeError, "without its ends"):
            multitetra.Volume(fill)
        shifted = multitetra.Volume(ball(dtype=float) + 2.0**20, subtract=2.0**20).isosurface(0.25)
        self.assertEqual(len(shifted.faces), len(multitetra.isosurface(ball(), 0.25).faces))

    def test_warnings_name_the_line_of_the_user(self):
        infinite = ball()
        infinite[0, 0, 0] = np.inf
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            mesh = multitetra.isosurface(infinite, 9)
        self.assertEqual(len(mesh.faces), 0)
        self.assertEqual([one.category for one in caught], [multitetra.VolumeWarning, multitetra.EmptySurfaceWarning])
        self.assertEqual({one.filename for one in caught}, {__file__})

    def test_documentation_runs(self):
        for name in ("volume", "certification"):
            module = importlib.import_module(f"multitetra.{name}")
            results = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
            self.assertGreater(results.attempted, 0)
            self.assertEqual(results.failed, 0)
        signature = inspect.signature(multitetra.isosurface).parameters
        for name in ("error", "quality", "regions", "intersection_free", "spacing"):
            self.assertIn(name, signature)
        self.assertNotIn("color_by", signature)
        self.assertIn("Other Parameters\n----------------\n", inspect.getdoc(multitetra.Volume.isosurface))
        self.assertTrue((pathlib.Path(multitetra.__file__).parent / "py.typed").exists())

    def test_clients_load_no_engine(self):
        code = "import multitetra, sys; sys.exit('multitetra._engine' in sys.modules)"
        subprocess.run([sys.executable, "-c", code], check=True, env=os.environ)


if __name__ == "__main__":  # Processes of dask import this file again.
    unittest.main(verbosity=2)
