"""Writes many variants of further formats, with their own libraries or by hand: MGH, Analyze and NIfTI in two files,
MRC of 16-bit floats, packed cubes, parallel VTK images, PNG and JPEG stacks, OME-Zarr in zip archives, N5, Imaris, DICOM of
a tilted gantry, raw samples behind counts or beside a commented description.

    python3 write_random_files.py FOLDER VARIANTS_OF_EACH_KIND SEED

Prints lines like write_odd_volumes.py.
"""
import gzip
import struct

import numpy

from volume_variants import variants
from volume_writing import dicom_image, dicom_save, diagonal, expect_read, folder, run_with_packages, write, zarr_2_format

# Signed permutations of RAS axes.
TURNS = (((1, 0, 0), (0, 1, 0), (0, 0, 1)), ((-1, 0, 0), (0, 0, -1), (0, 1, 0)), ((0, -1, 0), (1, 0, 0), (0, 0, 1)))


def in_lps(affine):
    """Returns origin and steps in LPS of a 4 x 4 matrix in RAS."""
    turned = numpy.diag((-1.0, -1.0, 1.0)) @ numpy.asarray(affine)[:3]
    return turned[:, 3], turned[:, :3].T


# ---- nibabel

def placed(v):
    """A 4 x 4 matrix in RAS."""
    affine = numpy.eye(4)
    affine[:3, :3] = numpy.array(v.one_of(*TURNS), float).T * v.size()
    affine[:3, 3] = v.origin()
    return affine


def mgz():
    import nibabel
    for v in variants("mgz"):
        shape = v.shape()
        samples = v.samples(shape, v.one_of("u1", "i2", "i4", "f4"))
        affine = placed(v)
        path = folder / f"{v.name}.{v.one_of('mgz', 'mgh')}"
        nibabel.save(nibabel.MGHImage(samples.T, affine), path)
        origin, steps = in_lps(affine)
        expect_read(v.name, path, samples, origin, steps, "mm")


def pairs():
    import nibabel
    for v in variants("pair"):
        samples = v.samples(v.shape(), v.one_of("u1", "i2", "i4", "f4"))
        affine = placed(v)
        nibabel.save(nibabel.Nifti1Pair(samples.T, affine), folder / f"{v.name}.hdr")
        origin, steps = in_lps(affine)
        expect_read(v.name, folder / f"{v.name}.{v.one_of('hdr', 'img')}", samples, origin, steps, "mm")


def analyze():
    import nibabel
    for v in variants("analyze"):
        samples = v.samples(v.shape(), v.one_of("u1", "i2", "i4", "f4"))
        size = v.size()
        image = nibabel.AnalyzeImage(samples.T, numpy.diag([*size, 1]))
        image.header.set_zooms(size)
        nibabel.save(image, folder / f"{v.name}.hdr")
        expect_read(v.name, folder / f"{v.name}.{v.one_of('hdr', 'img')}", samples, steps=diagonal(*size), unit="mm")


# ---- microscopes

def mrc_half():
    import mrcfile
    for v in variants("mrc-half"):
        samples = v.samples(v.shape(), "f2")
        size = v.size()
        path = folder / f"{v.name}.mrc"
        with mrcfile.new(path) as file:
            file.set_data(samples)
            file.voxel_size = tuple(size)
            assert file.header.mode == 12
        expect_read(v.name, path, samples, steps=diagonal(*size), unit="Å")


def n5():
    import numcodecs
    import zarr
    if zarr.__version__ >= "3":
        raise ImportError("zarr 3 writes no N5", name="zarr 2")
    for v in variants("n5"):
        samples = v.samples(v.shape(), v.one_of("u1", "i1", "u2", "i2", "i4", "f4", "f8"))
        size = v.size()
        chunks = tuple(min(pair) for pair in zip(v.chunks(samples.shape), samples.shape))
        array = zarr.open_array(zarr.N5Store(str(folder / f"{v.name}.n5")), "w", shape=samples.shape, chunks=chunks,
                                dtype=samples.dtype, compressor=v.one_of(None, numcodecs.GZip(1), numcodecs.BZ2(1)))
        array[:] = samples
        array.attrs["resolution"], array.attrs["units"] = size, ["nm"] * 3
        expect_read(v.name, folder / f"{v.name}.n5", samples, steps=diagonal(*size), unit="nm")


def zarr_zips():
    import zarr
    for v in variants("zip"):
        samples = v.samples(v.shape(), v.one_of("u1", "u2", "i2", "f4"))
        size, origin = v.size(), v.origin()
        path = folder / f"{v.name}.zip"
        with zarr.storage.ZipStore(str(path), compression=v.one_of(0, 8), mode="w") as store:
            group = zarr.group(store, **zarr_2_format())
            chunks = tuple(min(pair) for pair in zip(v.chunks(samples.shape), samples.shape))
            zarr.create(samples.shape, store=store, path="0", dtype=samples.dtype, chunks=chunks, **zarr_2_format())[:] = samples
            transforms = [{"type": "scale", "scale": size[::-1]}, {"type": "translation", "translation": origin[::-1]}]
            group.attrs["multiscales"] = [{
                "version": "0.4", "axes": [{"name": n, "type": "space", "unit": "micrometer"} for n in "zyx"],
                "datasets": [{"path": "0", "coordinateTransformations": transforms}]}]
        expect_read(v.name, path, samples, origin, diagonal(*size), "µm")


def imaris():
    import h5py

    def text(group, **attributes):
        for key, value in attributes.items():
            group.attrs[key] = numpy.frombuffer(str(value).encode(), "S1")

    for v in variants("imaris"):
        shape = v.shape()
        samples = v.samples(shape, v.one_of("u1", "u2", "f4"))
        size, origin = v.size(), v.origin()
        times, channels = v.choose.randint(1, 2), v.choose.randint(1, 2)
        time, channel = v.entry(times), v.entry(channels)
        padded = tuple(-(-n // 4) * 4 for n in shape)
        path = folder / f"{v.name}.ims"
        with h5py.File(path, "w") as file:
            extents = {f"Ext{end}{axis}": origin[axis] + (shape[2 - axis] * size[axis] if end == "Max" else 0)
                       for end in ("Min", "Max") for axis in range(3)}
            text(file.create_group("DataSetInfo/Image"), Unit="um", **extents)
            for t in range(times):
                for c in range(channels):
                    group = file.create_group(f"DataSet/ResolutionLevel 0/TimePoint {t}/Channel {c}")
                    text(group, ImageSizeX=shape[2], ImageSizeY=shape[1], ImageSizeZ=shape[0])
                    data = numpy.zeros(padded, samples.dtype)
                    data[:shape[0], :shape[1], :shape[2]] = samples if (t, c) == (time, channel) else 1
                    group.create_dataset("Data", data=data, chunks=(4, 4, 4), compression="gzip")
        options = ",".join(([f"time={time}"] if times > 1 else []) + ([f"channel={channel}"] if channels > 1 else []))
        expect_read(v.name, path, samples, [o + s / 2 for o, s in zip(origin, size)], diagonal(*size), "µm", options=options)


# ---- pictures

def png_stacks():
    from PIL import Image
    for v in variants("png"):
        samples = v.samples(v.shape(), v.one_of("u1", "u2"))
        (folder / v.name).mkdir()
        for i, image in enumerate(samples):
            Image.fromarray(image).save(folder / v.name / f"s{i + 8}.png")
        expect_read(v.name, folder / v.name, samples)


def jpeg_stacks():
    from PIL import Image
    for v in variants("jpeg"):
        shape = v.shape(3, 20)
        samples = v.samples(shape, "u1")
        decoded = []
        (folder / v.name).mkdir()
        for i, image in enumerate(samples):
            path = folder / v.name / f"slice{i + 8}.{v.one_of('jpg', 'jpeg')}"
            Image.fromarray(image).save(path, quality=v.choose.randint(30, 100), progressive=v.one_of(True, False))
            decoded.append(numpy.asarray(Image.open(path)))
        expect_read(v.name, folder / v.name, numpy.stack(decoded))


# ---- DICOM

def gantry_tilts():
    """A tilt of whole rows per slice: the resampled grid contains the original rows."""
    for v in variants("tilt"):
        shape = v.shape(3)
        sx, sy, sz = v.size()
        origin, samples = v.origin(), v.samples(shape, "i2")
        rows = v.one_of(-1, 1)
        for i in range(shape[0]):
            data = dicom_image(1000 * v.choose.randint(1, 10**6) + i, *shape[1:])
            data.PixelSpacing, data.SliceThickness = [sy, sx], sz
            data.ImagePositionPatient = [origin[0], origin[1] + rows * i * sy, origin[2] + sz * i]
            data.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
            data.PixelData = samples[i].tobytes()
            dicom_save(data, v.name, f"{i}.dcm")
        first = min(0, rows * (shape[0] - 1))  # The first row in the new grid.
        height = shape[1] + shape[0] - 1
        straight = numpy.full((shape[0], height, shape[2]), numpy.nan)
        for i in range(shape[0]):
            at = rows * i - first
            straight[i, at:at + shape[1]] = samples[i]
        expect_read(v.name, folder / v.name, straight, [origin[0], origin[1] + first * sy, origin[2]], diagonal(sx, sy, sz),
                    "mm", "tilted gantry", "resample")


# ---- formats written without libraries

def cubes():
    for v in variants("cube"):
        shape = v.shape()
        samples = v.samples(shape, "f4") / 8
        size, origin = v.size(), v.origin()
        # A cube file's first axis is the slowest: z here, with its step along x of the world.
        head = [f"{v.name}", "as programs write it", " ".join(map(str, [1, *origin]))]
        head += [f"{shape[0]} {size[0]} 0 0", f"{shape[1]} 0 {size[1]} 0", f"{shape[2]} 0 0 {size[2]}", "8 8.0 0 0 0"]
        lines = [" ".join(f"{n:.5E}" for n in row[i:i + 6]) for plane in samples for row in plane for i in range(0, len(row), 6)]
        path = write(f"{v.name}.cube.gz", gzip.compress("\n".join(head + lines + [""]).encode()))
        expect_read(v.name, path, samples, origin, ((0, 0, size[2]), (0, size[1], 0), (size[0], 0, 0)), "bohr")


def pvtis():
    for v in variants("pvti"):
        shape = v.shape(3)
        dtype, name = v.one_of(("u1", "UInt8"), ("i2", "Int16"), ("f4", "Float32"))
        samples = v.samples(shape, dtype)
        size, origin = v.size(), v.origin()
        extent = (0, shape[2] - 1, 0, shape[1] - 1, 0, shape[0] - 1)
        axis = v.choose.randrange(3)
        cut = v.choose.randint(1, extent[2 * axis + 1] - 1)  # The layer of samples that both pieces
                                                             # contain.
        place = f'Origin="{" ".join(map(str, origin))}" Spacing="{" ".join(map(str, size))}"'
        whole = f'WholeExtent="{" ".join(map(str, extent))}"'
        pieces = ""
        for number, ends in enumerate(((0, cut), (cut, extent[2 * axis + 1]))):
            box = list(extent)
            box[2 * axis:2 * axis + 2] = ends
            x0, x1, y0, y1, z0, z1 = box
            part = samples[z0:z1 + 1, y0:y1 + 1, x0:x1 + 1]
            text = " ".join(map(str, box))
            write(f"{v.name}/p{number}.vti", (
                f'<VTKFile type="ImageData"><ImageData {whole} {place}><Piece Extent="{text}"><PointData Scalars="a">'
                f'<DataArray type="{name}" Name="a" format="ascii">' + " ".join(map(str, part.ravel())) +
                "</DataArray></PointData></Piece></ImageData></VTKFile>").encode())
            pieces += f'<Piece Extent="{text}" Source="{v.name}/p{number}.vti"/>'
        path = write(f"{v.name}.pvti", (f'<VTKFile type="PImageData"><PImageData {whole} GhostLevel="0" {place}>'
                                        f'{pieces}</PImageData></VTKFile>').encode())
        expect_read(v.name, path, samples, origin, diagonal(*size))


def counted():
    for v in variants("counts"):
        shape = v.shape(4)
        # Large values, so that the file does not also match a type of half the size.
        samples = (v.samples(shape, "u2") + 300).astype("<u2")
        counts, packed = struct.pack("<3H", *shape[::-1]), gzip.compress(samples.tobytes())
        path, data = v.one_of((f"{v.name}.dat", counts + packed), (f"{v.name}.dat.gz", gzip.compress(counts + samples.tobytes())))
        expect_read(v.name, write(path, data), samples)


def described():
    for v in variants("dat"):
        samples = v.samples(v.shape(), v.one_of("u1", "<u2"))
        size = v.size()
        write(f"{v.name}.raw", samples.tobytes())
        lines = [f"ObjectFileName: {v.name}.raw", f"Resolution: {' '.join(map(str, samples.shape[::-1]))}",
                 f"SliceThickness: {' '.join(map(str, size))}", f"Format: {'UCHAR' if samples.itemsize == 1 else 'USHORT'}"]
        v.choose.shuffle(lines)
        for _ in range(v.choose.randint(1, 3)):
            lines.insert(v.choose.randrange(len(lines) + 1), v.one_of("# a comment", "", "  # another: 3 4 5"))
        lines = [line + v.one_of("", " # x y z") if ":" in line and "#" not in line else line for line in lines]
        path = write(f"{v.name}.dat", v.one_of("\n", "\r\n").join([*lines, ""]).encode())
        expect_read(v.name, path, samples, steps=diagonal(*size))


run_with_packages(mgz, pairs, analyze, mrc_half, n5, zarr_zips, imaris, png_stacks, jpeg_stacks, gantry_tilts, cubes, pvtis,
                  counted, described)
