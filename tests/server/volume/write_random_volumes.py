"""Writes many variants of formats that programs write in many ways, with their own libraries: DICOM series and multi-frame
DICOM, TIFF, Zarr, NumPy, NetCDF-3 and HDF5.

    python3 write_random_volumes.py FOLDER VARIANTS_OF_EACH_KIND SEED

The seed determines sizes, types, orders, packings, placement and the dimensions before z, y, x. Prints lines like
write_odd_volumes.py.
"""
import numpy

from volume_variants import FLOATS, INTEGERS, variants
from volume_writing import (dicom_image, dicom_items, dicom_save, diagonal, expect_read, folder, run_with_packages, write,
                            zarr_2_format)

# Row and column directions of images, with exact decimals.
ORIENTATIONS = (((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, -1)), ((0, 0, 1), (1, 0, 0)), ((0.6, 0.8, 0), (-0.8, 0.6, 0)),
                ((0.36, -0.8, 0.48), (0.48, 0.6, 0.64)))


# ---- DICOM

def oriented(variant):
    """Returns row, column and normal of slices, and the steps of samples."""
    row, column = (numpy.array(axis, float) for axis in variant.one_of(*ORIENTATIONS))
    return row, column, numpy.cross(row, column), variant.size()


def text(numbers):
    return [format(round(n, 9), ".10g") for n in numbers]


def dicom_series():
    for v in variants("dicom-series"):
        shape = v.shape(3)
        row, column, normal, (sx, sy, sz) = oriented(v)
        origin = numpy.array(v.origin())
        samples = v.samples(shape, "i2")
        # Exact, rounded within a tenth of a step, or uneven.
        spread = v.one_of(0, 0.04, 0.4)
        heights = [round(sz * (i + (spread * v.choose.uniform(-1, 1) if 0 < i < shape[0] - 1 else 0)), 4)
                   for i in range(shape[0])]
        slope, intercept = v.one_of((1, 0), (1, -1000), (0.5, 3))
        for i, height in enumerate(heights):
            data = dicom_image(v.choose.randint(1, 10**6) * 100 + i, *shape[1:])
            data.PixelSpacing, data.SliceThickness = [sy, sx], sz
            data.ImagePositionPatient = text(origin + height * normal)
            data.ImageOrientationPatient = text([*row, *column])
            data.RescaleSlope, data.RescaleIntercept = slope, intercept
            data.PixelData = samples[i].tobytes()
            dicom_save(data, v.name, f"{v.choose.randint(0, 10**9)}-{i}.dcm")
        values = samples * slope + intercept
        off = max(abs(height - heights[-1] * i / (shape[0] - 1)) for i, height in enumerate(heights))
        step = heights[-1] / (shape[0] - 1)
        notice = "off an even grid" if off > 0.0101 * step else ""
        if off > 0.1 * step:
            usual = sorted(numpy.diff(heights))[(shape[0] - 1) // 2]
            intervals = int(heights[-1] / usual + 0.5)
            step = heights[-1] / intervals
            values = numpy.apply_along_axis(
                lambda line: numpy.interp(numpy.arange(intervals + 1) * step, heights, line), 0, values)
            notice = "--resample makes"
        expect_read(v.name, folder / v.name, values, origin, [row * sx, column * sy, normal * step], "mm", notice, "resample")


def dicom_frames():
    from pydicom.sequence import Sequence
    for v in variants("dicom-frames"):
        shape = v.shape(2)
        row, column, normal, (sx, sy, sz) = oriented(v)
        origin = numpy.array(v.origin())
        samples = v.samples(shape, "i2")
        slopes = [v.one_of((1, 0), (0.5, -7), (2, 30)) for _ in range(shape[0])]
        order = list(range(shape[0]))
        v.one_of(v.choose.shuffle, list.reverse, len)(order)
        data = dicom_image(1, *shape[1:], kind="1.2.840.10008.5.1.4.1.1.2.1")
        data.NumberOfFrames = shape[0]
        shared = {"PixelMeasuresSequence": dicom_items(PixelSpacing=[sy, sx], SliceThickness=sz)}
        orientation = {"PlaneOrientationSequence": dicom_items(ImageOrientationPatient=text([*row, *column]))}
        is_shared = v.one_of(True, False)
        data.SharedFunctionalGroupsSequence = dicom_items(**shared, **(orientation if is_shared else {}))
        data.PerFrameFunctionalGroupsSequence = Sequence([dicom_items(
            PlanePositionSequence=dicom_items(ImagePositionPatient=text(origin + sz * at * normal)),
            PixelValueTransformationSequence=dicom_items(RescaleSlope=slopes[at][0], RescaleIntercept=slopes[at][1],
                                                         RescaleType="HU"),
            **({} if is_shared else orientation))[0] for at in order])
        data.PixelData = samples[order].tobytes()
        values = numpy.stack([samples[i] * slope + intercept for i, (slope, intercept) in enumerate(slopes)])
        expect_read(v.name, dicom_save(data, f"{v.name}.dcm"), values, origin, [row * sx, column * sy, normal * sz], "mm")


# ---- TIFF

def tiff_pages():
    import tifffile
    for v in variants("tiff"):
        shape = v.shape(2, 20)
        samples = v.samples(shape, v.one_of(*INTEGERS, *FLOATS))
        layout = v.one_of({}, {"tile": (16, 16)}, {"tile": (16, 32)}, {"rowsperstrip": v.choose.randint(1, 5)})
        path = folder / f"{v.name}.tif"
        tifffile.imwrite(path, samples, metadata=None, photometric="minisblack", compression=v.one_of(None, "zlib"),
                         bigtiff=v.one_of(True, False), byteorder=v.one_of("<", ">"), **layout)
        expect_read(v.name, path, samples)


def tiff_hyperstacks():
    import tifffile
    for v in variants("imagej"):
        shape = v.shape()
        times, channels = v.choose.randint(1, 3), v.choose.randint(1, 3)
        samples = v.samples((times, shape[0], channels, *shape[1:]), v.one_of("u1", "u2", "f4"))
        sx, sy, sz = v.size()
        path = folder / f"{v.name}.tif"
        tifffile.imwrite(path, samples, imagej=True, photometric="minisblack", resolution=(1 / sx, 1 / sy),
                         metadata={"axes": "TZCYX", "spacing": sz, "unit": "um"})
        time, channel = v.entry(times), v.entry(channels)
        options = ",".join(([f"time={time}"] if times > 1 else []) + ([f"channel={channel}"] if channels > 1 else []))
        expect_read(v.name, path, samples[time, :, channel], steps=diagonal(sx, sy, sz), unit="µm", options=options)


def tiff_ome():
    import tifffile
    for v in variants("ome"):
        shape = v.shape(2, 18)
        times, channels = v.choose.randint(1, 3), v.choose.randint(1, 3)
        order = v.one_of("TCZ", "TZC", "CTZ", "ZTC", "CZT", "ZCT")
        samples = v.samples((times, channels, *shape), v.one_of(*INTEGERS, "f4", "f8"))
        sx, sy, sz = v.size()
        metadata = {"axes": order + "YX", "PhysicalSizeX": sx, "PhysicalSizeY": sy, "PhysicalSizeZ": sz,
                    **{f"PhysicalSize{axis}Unit": "nm" for axis in "XYZ"}}
        path = folder / f"{v.name}.ome.tif"
        tifffile.imwrite(path, samples.transpose([*("TCZ".index(axis) for axis in order), 3, 4]), ome=True,
                         photometric="minisblack", metadata=metadata, byteorder=v.one_of("<", ">"), **v.one_of({}, {"tile": (16, 16)}))
        time, channel = v.entry(times), v.entry(channels)
        options = ",".join(([f"time={time}"] if times > 1 else []) + ([f"channel={channel}"] if channels > 1 else []))
        expect_read(v.name, path, samples[time, channel], steps=diagonal(sx, sy, sz), unit="nm", options=options)


# ---- arrays

def zarrs():
    import numcodecs
    import zarr
    for v in variants("zarr"):
        shape = v.shape()
        samples = v.samples(shape, v.one_of(">", "<") + v.one_of(*INTEGERS, *FLOATS))
        chunks = tuple(min(pair) for pair in zip(v.chunks(shape), shape))
        fill = v.one_of(0, 7)
        array = zarr.open_array(
            str(folder / f"{v.name}.zarr"), mode="w", shape=shape, chunks=chunks, dtype=samples.dtype, order=v.one_of("C", "F"),
            fill_value=fill, dimension_separator=v.one_of(".", "/"),
            compressor=v.one_of(None, numcodecs.Zstd(1), numcodecs.GZip(1), numcodecs.Zlib(1), numcodecs.BZ2(1), numcodecs.LZ4(),
                                numcodecs.Blosc("lz4", shuffle=1), numcodecs.Blosc("zstd", shuffle=2)), **zarr_2_format())
        written = v.choose.randint(1, shape[0])  # The remaining chunks are missing.
        array[:written] = samples[:written]
        samples[written:] = fill
        expect_read(v.name, folder / f"{v.name}.zarr", samples)


def npys():
    for v in variants("npy"):
        shape = v.shape()
        dtype = v.one_of(">", "<") + v.one_of(*INTEGERS, *FLOATS)
        times = v.one_of(1, 1, 3)
        samples = v.samples((times, *shape) if times > 1 else shape, dtype)
        path = write(f"{v.name}.npy", b"")
        if v.one_of(True, False) and times == 1:
            numpy.save(path, numpy.asfortranarray(samples))
            expect_read(v.name, path, samples.transpose(2, 1, 0), steps=((0, 0, 1), (0, 1, 0), (1, 0, 0)))
            continue
        numpy.save(path, samples)
        time = v.entry(times)
        expect_read(v.name, path, samples[time] if times > 1 else samples, options=f"time={time}" if times > 1 else "")


def coordinates(v, shape):
    """Returns origin and steps of a volume, and the coordinates along z, y, x."""
    origin, size = v.origin(), v.size()
    return origin, size, [origin[2 - i] + size[2 - i] * numpy.arange(n) for i, n in enumerate(shape)]


def netcdf3():
    from scipy.io import netcdf_file
    for v in variants("netcdf3"):
        shape = v.shape()
        times = v.one_of(0, 2, 3)
        dtype = v.one_of("i1", "i2", "i4", "f4", "f8")
        samples = v.samples((times, *shape) if times else shape, dtype)
        origin, size, axes = coordinates(v, shape)
        path = folder / f"{v.name}.nc"
        slope, intercept = v.one_of((1, 0), (0.5, 3)) if dtype[0] == "i" else (1, 0)
        with netcdf_file(path, "w", version=v.one_of(1, 2)) as out:
            if times:
                out.createDimension("time", v.one_of(None, times))
            for name, values in zip("zyx", axes):
                out.createDimension(name, len(values))
                axis = out.createVariable(name, "f8", (name,))
                axis[:] = values
                axis.units = "m"
            field = out.createVariable("field", dtype, (("time",) if times else ()) + tuple("zyx"))
            field[:] = samples
            if (slope, intercept) != (1, 0):
                field.scale_factor, field.add_offset = slope, float(intercept)
        time = v.entry(times or 1)
        expect_read(v.name, path, (samples[time] if times else samples) * slope + intercept, origin, diagonal(*size), "m",
                    options=f"time={time}" if times else "")


def hdf5():
    import h5py
    for v in variants("hdf5"):
        shape = v.shape()
        times = v.one_of(0, 2, 3)
        samples = v.samples((times, *shape) if times else shape, v.one_of(">", "<") + v.one_of(*INTEGERS, *FLOATS))
        origin, size, axes = coordinates(v, shape)
        has_scales = v.one_of(True, False)
        path = folder / f"{v.name}.h5"
        layout = v.one_of({}, {"compression": "lzf"}, {"compression": "lzf", "shuffle": True}, {"compression": "gzip"},
                          {"shuffle": True, "fletcher32": True})
        if layout:
            layout = {**layout, "chunks": tuple(min(pair) for pair in zip(v.chunks(samples.shape), samples.shape))}
        with h5py.File(path, "w", libver=v.one_of("earliest", "latest")) as file:
            field = file.create_dataset("group/field", data=samples, **layout)
            for i, values in enumerate(axes if has_scales else []):
                file[f"axis{i}"] = values
                file[f"axis{i}"].attrs["units"] = "m"
                file[f"axis{i}"].make_scale()
                field.dims[i + (1 if times else 0)].attach_scale(file[f"axis{i}"])
        time = v.entry(times or 1)
        place = {"origin": origin, "steps": diagonal(*size), "unit": "m"} if has_scales else {}
        expect_read(v.name, path, samples[time] if times else samples, options=f"time={time}" if times else "", **place)


run_with_packages(npys, netcdf3, dicom_series, dicom_frames, tiff_pages, tiff_hyperstacks, tiff_ome, zarrs, hdf5)
