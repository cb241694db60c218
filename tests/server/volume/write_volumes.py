"""Writes one volume in every format, with third-party libraries if Debian has them, otherwise by hand.

    python3 write_volumes.py FOLDER

24 x 20 x 12 samples of type i16, spacing 0.5 0.75 2, the first sample at 10 -20 30. Prints a line "FORMAT PATH" for each.
"""
import base64
import gzip
import json
import struct
import zlib

import numpy

from volume_writing import dicom_image, dicom_items as items, dicom_save as save, folder, run_with_packages, write, zarr_2_format

SHAPE = (12, 20, 24)  # z, y, x
SPACING = (0.5, 0.75, 2.0)  # x, y, z
ORIGIN = (10.0, -20.0, 30.0)
z, y, x = numpy.meshgrid(*(numpy.arange(n) for n in SHAPE), indexing="ij")
volume = (900 * numpy.sin(x / 3) * numpy.cos(y / 4) + 40 * z - 200 + (7 * x + 3 * y + 5 * z) % 11).astype("<i2")


def print_volume(name, path):
    print(name, path)


def nrrd():
    head = ("NRRD0004\ntype: int16\ndimension: 3\nsizes: 24 20 12\nencoding: raw\nendian: little\n"
            "space dimension: 3\nspace directions: (0.5,0,0) (0,0.75,0) (0,0,2)\nspace origin: (10,-20,30)\n\n")
    print_volume("nrrd", write("v.nrrd", head.encode() + volume.tobytes()))


def scale(numbers):
    return {"type": "scale", "scale": list(reversed(numbers))}


AXES = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
PLACE = [scale(SPACING), {"type": "translation", "translation": list(reversed(ORIGIN))}]


def zarr_2():
    import numcodecs
    import zarr
    for name, compressor, more in (("blosc", numcodecs.Blosc("lz4"), {}), ("zstd", numcodecs.Zstd(3), {}),
                                   ("gzip", numcodecs.GZip(5), {"order": "F"}), ("plain", None, {}),
                                   ("zlib", numcodecs.Zlib(5), {"dimension_separator": "/"}),
                                   ("bz2", numcodecs.BZ2(5), {})):
        root = zarr.open_group(str(folder / f"{name}2.zarr"), mode="w", **zarr_2_format())
        array = zarr.open_array(str(folder / f"{name}2.zarr/0"), mode="w", shape=SHAPE, dtype=volume.dtype, chunks=(5, 8, 9),
                                compressor=compressor, **more, **zarr_2_format())
        array[:] = volume
        root.attrs["multiscales"] = [{"version": "0.4", "axes": AXES,
                                      "datasets": [{"path": "0", "coordinateTransformations": PLACE}]}]
        print_volume(f"zarr-2-{name}", folder / f"{name}2.zarr")
    # Five dimensions: two times, three channels; the volume is time 1, channel 2.
    root = zarr.open_group(str(folder / "five.zarr"), mode="w", **zarr_2_format())
    five = numpy.zeros((2, 3) + SHAPE, "<i2")
    five[1, 2] = volume
    zarr.open_array(str(folder / "five.zarr/a/0"), mode="w", shape=five.shape, dtype=five.dtype, chunks=(1, 1, 6, 10, 12),
                    **zarr_2_format())[:] = five
    root.attrs["multiscales"] = [{
        "version": "0.4", "axes": [{"name": "t", "type": "time"}, {"name": "c", "type": "channel"}] + AXES,
        "datasets": [{"path": "a/0", "coordinateTransformations": [
            {"type": "scale", "scale": [1, 1, 2.0, 0.75, 0.5]},
            {"type": "translation", "translation": [0, 0, 30, -20, 10]}]}]}]
    print_volume("zarr-2-time-1-channel-2", folder / "five.zarr")


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return struct.pack("<I", crc ^ 0xFFFFFFFF)


def blocks(shape):
    """Yields blocks of this shape that cover the volume, padded with zeros."""
    counts = [-(-n // s) for n, s in zip(SHAPE, shape)]
    padded = numpy.zeros([c * s for c, s in zip(counts, shape)], "<i2")
    padded[tuple(slice(n) for n in SHAPE)] = volume
    for place in numpy.ndindex(*counts):
        yield place, padded[tuple(slice(p * s, p * s + s) for p, s in zip(place, shape))]


def zarr_3():
    attributes = {"ome": {"version": "0.5", "multiscales": [
        {"axes": AXES, "datasets": [{"path": "s0", "coordinateTransformations": PLACE}]}]}}
    gzipped = {"name": "gzip", "configuration": {"level": 5}}
    little = {"name": "bytes", "configuration": {"endian": "little"}}
    big = {"name": "bytes", "configuration": {"endian": "big"}}
    crc = {"name": "crc32c"}

    def array(name, chunk, codecs):
        root = folder / f"{name}.zarr"
        write(f"{name}.zarr/zarr.json", json.dumps(
            {"zarr_format": 3, "node_type": "group", "attributes": attributes}).encode())
        write(f"{name}.zarr/s0/zarr.json", json.dumps({
            "zarr_format": 3, "node_type": "array", "shape": SHAPE, "data_type": "int16",
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": 0, "codecs": codecs, "dimension_names": ["z", "y", "x"]}).encode())
        print_volume(f"zarr-3-{name}", root)

    array("whole", (5, 8, 9), [big, gzipped, crc])
    for place, block in blocks((5, 8, 9)):
        data = gzip.compress(block.astype(">i2").tobytes())
        write("whole.zarr/s0/c/" + "/".join(map(str, place)), data + crc32c(data))
    array("turned", (6, 10, 12), [{"name": "transpose", "configuration": {"order": [2, 0, 1]}}, little])
    for place, block in blocks((6, 10, 12)):
        write("turned.zarr/s0/c/" + "/".join(map(str, place)), block.transpose(2, 0, 1).tobytes())
    for where in ("end", "start"):
        array(f"sharded-{where}", (8, 10, 12), [{"name": "sharding_indexed", "configuration": {
            "chunk_shape": (4, 5, 6), "codecs": [little, gzipped], "index_codecs": [little, crc],
            "index_location": where}}])
        for place, shard in blocks((8, 10, 12)):
            index_bytes = 16 * 8 + 4
            data = b""
            index = b""
            for inner in numpy.ndindex(2, 2, 2):
                chunk = shard[tuple(slice(p * s, p * s + s) for p, s in zip(inner, (4, 5, 6)))]
                if not chunk.any():
                    index += struct.pack("<QQ", 2**64 - 1, 2**64 - 1)
                    continue
                packed = gzip.compress(chunk.tobytes())
                index += struct.pack("<QQ", len(data) + (index_bytes if where == "start" else 0), len(packed))
                data += packed
            index += crc32c(index)
            write(f"sharded-{where}.zarr/s0/c/" + "/".join(map(str, place)),
                  index + data if where == "start" else data + index)


def n5():
    for name, compression, pack in (
            ("gzip", {"type": "gzip", "level": 5, "useZlib": False}, gzip.compress),
            ("zlib", {"type": "gzip", "useZlib": True}, zlib.compress), ("raw", {"type": "raw"}, bytes)):
        write(f"{name}.n5/attributes.json", json.dumps({
            "dimensions": SHAPE[::-1], "blockSize": (9, 8, 5), "dataType": "int16", "compression": compression,
            "pixelResolution": {"dimensions": SPACING, "unit": "um"}}).encode())
        for place, _ in blocks((5, 8, 9)):
            part = volume[tuple(slice(p * s, p * s + s) for p, s in zip(place, (5, 8, 9)))]
            head = struct.pack(">HHIII", 0, 3, *part.shape[::-1])
            write(f"{name}.n5/" + "/".join(map(str, place[::-1])), head + pack(part.astype(">i2").tobytes()))
        print_volume(f"n5-{name}", folder / f"{name}.n5")


def hdf5():
    import h5py
    with h5py.File(folder / "v.h5", "w") as file:
        file.create_dataset("fields/density", data=volume, chunks=(4, 5, 6), compression="gzip", shuffle=True)
        file["fields/density"].attrs["units"] = "kg/m3"
        for dimension, (label, start, step, n) in enumerate(
                (("z", 30, 2, 12), ("y", -20, 0.75, 20), ("x", 10, 0.5, 24))):
            file[label] = start + step * numpy.arange(n)
            file[label].attrs["units"] = "m"
            file[label].make_scale(label)
            file["fields/density"].dims[dimension].attach_scale(file[label])
        file["fields/other"] = numpy.zeros((3, 3))
    print_volume("hdf5", f"{folder}/v.h5:/fields/density")


def vti_file(name, compressor, attributes, inside, appended=b"", byte_order="LittleEndian", header="UInt32"):
    return write(f"{name}.vti", (
        f'<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="{byte_order}" '
        f'header_type="{header}"{compressor}>\n<ImageData WholeExtent="2 25 0 19 0 11" '
        'Origin="9 -20 30" Spacing="0.5 0.75 2" Direction="1 0 0 0 1 0 0 0 1">\n'
        '<Piece Extent="2 25 0 19 0 11">\n<PointData Scalars="field">\n'
        f'<DataArray type="Int16" Name="field" {attributes}>').encode() + inside + (
            b"</DataArray>\n</PointData>\n<CellData/>\n</Piece>\n</ImageData>\n" + appended + b"</VTKFile>\n"))


def vti():
    def packed(data):
        parts = [data[i:i + 4096] for i in range(0, len(data), 4096)]
        small = [zlib.compress(part) for part in parts]
        last = len(parts[-1]) % 4096
        return struct.pack(f"<{3 + len(parts)}I", len(parts), 4096, last, *map(len, small)), b"".join(small)

    def file(name, *arguments, **more):
        print_volume(f"vti-{name}", vti_file(name, *arguments, **more))

    data = volume.tobytes()
    zipped = ' compressor="vtkZLibDataCompressor"'
    head, blocks_ = packed(data)
    file("text", "", 'format="ascii" RangeMin="0"', ("\n   " + " ".join(map(str, volume.ravel())) + "\n").encode())
    file("base64", "", 'format="binary"', b"\n     " + base64.b64encode(struct.pack("<I", len(data)) + data) + b"\n")
    file("big", "", 'format="binary"', base64.b64encode(struct.pack(">Q", len(data)) + volume.astype(">i2").tobytes()),
         byte_order="BigEndian", header="UInt64")
    file("zlib", zipped, 'format="binary"', b"\n  " + base64.b64encode(head) + base64.b64encode(blocks_) + b"\n")
    file("raw", "", 'format="appended" offset="5"', b"",
         b'<AppendedData encoding="raw">\n _12345' + struct.pack("<I", len(data)) + data + b"\n</AppendedData>\n")
    file("zlib-raw", zipped, 'format="appended" offset="0"', b"",
         b'<AppendedData encoding="raw">\n_' + head + blocks_ + b"\n</AppendedData>\n")
    file("zlib-appended", zipped, 'format="appended" offset="0"', b"",
         b'<AppendedData encoding="base64">\n_' + base64.b64encode(head) + base64.b64encode(blocks_) +
         b"\n</AppendedData>\n")


def vti_lz4():
    import numcodecs
    data = volume.tobytes()
    parts = [data[i:i + 4096] for i in range(0, len(data), 4096)]
    small = [numcodecs.LZ4().encode(part)[4:] for part in parts]  # Strip the size that numcodecs
                                                                  # prepends.
    head = struct.pack(f"<{3 + len(parts)}I", len(parts), 4096, len(parts[-1]) % 4096, *map(len, small))
    print_volume("vti-lz4", vti_file("lz4", ' compressor="vtkLZ4DataCompressor"', 'format="binary"',
                             base64.b64encode(head) + base64.b64encode(b"".join(small))))


def dicom():
    import pydicom
    from pydicom.sequence import Sequence

    def image(number, **more):
        return dicom_image(number, SHAPE[1], SHAPE[2], **more)

    def pixels(samples):
        return (samples + 1000).astype("<i2").tobytes()

    def series(name, row=(1, 0, 0), column=(0, 1, 0), step=(0, 0, 2), syntax=pydicom.uid.ExplicitVRLittleEndian, pack=None):
        for i in range(SHAPE[0]):
            data = image(i + 1, syntax=syntax)
            data.InstanceNumber = 99 - i
            data.PixelSpacing, data.SliceThickness = [0.75, 0.5], 2
            data.ImagePositionPatient = [round(ORIGIN[k] + i * step[k], 9) for k in range(3)]
            data.ImageOrientationPatient = [*row, *column]
            data.RescaleSlope, data.RescaleIntercept, data.RescaleType = 1, -1000, "HU"
            data.PixelData = pixels(volume[i])
            if pack:
                data.compress(pack)
            save(data, name, f"slice{(7 * i) % SHAPE[0]}")

    series("dicom")
    print_volume("dicom", folder / "dicom")
    series("dicom-rle", pack=pydicom.uid.RLELossless)
    print_volume("dicom-rle", folder / "dicom-rle")
    series("dicom-deflated", syntax=pydicom.uid.DeflatedExplicitVRLittleEndian)
    print_volume("dicom-deflated", folder / "dicom-deflated")
    # Not placed like the volume: the tests refer to these by name.
    series("oblique", (0.36, -0.8, 0.48), (0.48, 0.6, 0.64), (-1.6, 0, 1.2))
    series("tilted", step=(0, 0.5, 2))

    # All slices in one file, each described separately (Enhanced CT).
    data = image(1, kind="1.2.840.10008.5.1.4.1.1.2.1")
    data.NumberOfFrames = SHAPE[0]
    data.SharedFunctionalGroupsSequence = items(
        PixelMeasuresSequence=items(PixelSpacing=[0.75, 0.5], SliceThickness=2, SpacingBetweenSlices=2),
        PlaneOrientationSequence=items(ImageOrientationPatient=[1, 0, 0, 0, 1, 0]),
        PixelValueTransformationSequence=items(RescaleIntercept=-1000, RescaleSlope=1, RescaleType="HU"))
    data.PerFrameFunctionalGroupsSequence = Sequence([
        items(PlanePositionSequence=items(ImagePositionPatient=[10, -20, 30 + 2 * i]))[0] for i in range(SHAPE[0])])
    data.PixelData = pixels(volume)
    save(data, "frames", "all")
    print_volume("dicom-frames", folder / "frames")


def tiff():
    import tifffile
    sizes = dict(zip(("PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"), SPACING))
    metadata = {"axes": "ZYX", **sizes, **{f"{name}Unit": "µm" for name in sizes}}
    for name, options in (("tiff-ome", {}), ("tiff-ome-tiled", {"tile": (16, 16), "compression": "zlib"}),
                          ("tiff-ome-big", {"bigtiff": True, "byteorder": ">"})):
        tifffile.imwrite(folder / f"{name}.ome.tif", volume, ome=True, metadata=metadata, **options)
        print_volume(name, folder / f"{name}.ome.tif")
    tifffile.imwrite(folder / "pages.tif", volume, metadata=None)
    print_volume("tiff-pages", folder / "pages.tif")
    (folder / "stack").mkdir()
    for i in range(SHAPE[0]):
        tifffile.imwrite(folder / "stack" / f"slice{i}.tif", volume[i], metadata=None)
    print_volume("tiff-stack", folder / "stack")
    # Not of the volume's type: the tests refer to it by name.
    tifffile.imwrite(folder / "imagej.tif", numpy.stack([volume, volume + 1], 1).astype("f4"), imagej=True,
                     resolution=(2, 4 / 3), metadata={"axes": "ZCYX", "spacing": 2.0, "unit": "um"})


def mrc():
    head = bytearray(1024)
    struct.pack_into("<10i", head, 0, 24, 20, 12, 1, 0, 0, 0, 24, 20, 12)
    struct.pack_into("<6f", head, 40, 12, 15, 24, 90, 90, 90)
    struct.pack_into("<3i", head, 64, 1, 2, 3)
    struct.pack_into("<i", head, 92, 80)
    struct.pack_into("<3f", head, 196, *ORIGIN)
    head[208:214] = b"MAP DD"
    print_volume("mrc", write("v.mrc", bytes(head) + bytes(80) + volume.tobytes()))
    print_volume("mrc-gzip", write("v.map.gz", gzip.compress(bytes(head) + bytes(80) + volume.tobytes())))


def nifti():
    for endian, name in (("<", "v.nii"), (">", "big.nii.gz")):
        head = bytearray(352)
        struct.pack_into(endian + "i", head, 0, 348)
        struct.pack_into(endian + "8h", head, 40, 3, 24, 20, 12, 1, 1, 1, 1)
        struct.pack_into(endian + "2h", head, 70, 4, 16)
        struct.pack_into(endian + "8f", head, 76, 1, 0.5, 0.75, 2, 1, 1, 1, 1)
        struct.pack_into(endian + "3f", head, 108, 352, 1, 0)
        head[123] = 3  # Micrometers.
        struct.pack_into(endian + "2h", head, 252, 0, 2)
        struct.pack_into(endian + "12f", head, 280, -0.5, 0, 0, -10, 0, -0.75, 0, 20, 0, 0, 2, 30)
        head[344:347] = b"n+1"
        data = bytes(head) + volume.astype(endian + "i2").tobytes()
        print_volume(f"nifti-{name}", write(name, gzip.compress(data) if name.endswith("gz") else data))


def raw():
    print_volume("raw-gzip", write("v_24x20x12_int16.raw.gz", gzip.compress(volume.tobytes())))
    write("described.raw", volume.tobytes())
    print_volume("raw-described", write("described.dat", b"ObjectFileName: described.raw\nResolution: 24 20 12\n"
                                b"SliceThickness: 0.5 0.75 2\nFormat: SHORT\n"))


nrrd()
zarr_3()
n5()
vti()
mrc()
nifti()
raw()
run_with_packages(zarr_2, vti_lz4, hdf5, dicom, tiff)  # Needs optional packages.
