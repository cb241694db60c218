"""Writes small volumes under the names that server/volume/FORMATS.md uses, into the current folder.

Omits formats that need a library (DICOM, OME-TIFF, HDF5, Imaris).
"""
import gzip
import json
import math
import pathlib
import shutil
import struct

SIDE = 12
INDICES = [(x, y, z) for z in range(SIDE) for y in range(SIDE) for x in range(SIDE)]
BALL = [10 * (SIDE / 2 - math.dist(index, (5.5, 5.5, 5.5))) for index in INDICES]


def nifti(name, values, times=1, code=16, letter="f"):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 4 if times > 1 else 3, SIDE, SIDE, SIDE, times, 1, 1, 1)
    struct.pack_into("<2h", header, 70, code, struct.calcsize(letter) * 8)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into("<2f", header, 108, 352, 1)  # Offset and slope of the samples.
    header[123] = 2 + 8  # Millimetres, seconds.
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
    header[344:348] = b"n+1\0"
    samples = struct.pack(f"<{len(values)}{letter}", *values)
    pathlib.Path(name).write_bytes(gzip.compress(bytes(header) + samples))


def vti(name, *arrays):
    data = "".join(f'<DataArray type="Float32" Name="{array}" format="ascii">{" ".join(map(str, BALL))}</DataArray>'
                   for array in arrays)
    extent = f"0 {SIDE - 1} " * 3
    pathlib.Path(name).write_text(
        f'<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="{extent}" '
        f'Origin="0 0 0" Spacing="1 1 1"><Piece Extent="{extent}"><PointData>{data}</PointData></Piece>'
        "</ImageData></VTKFile>")


def tiff(name, z):
    pixels = struct.pack(f"<{SIDE * SIDE}H", *(int(1000 + BALL[z * SIDE * SIDE + i]) for i in range(SIDE * SIDE)))
    tags = [(256, 3, SIDE), (257, 3, SIDE), (258, 3, 16), (259, 3, 1), (262, 3, 1), (273, 4, 8), (277, 3, 1),
            (278, 3, SIDE), (279, 4, len(pixels))]
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", tag, kind, 1, value)
                                                        for tag, kind, value in tags) + bytes(4)
    pathlib.Path(name).write_bytes(b"II*\0" + struct.pack("<I", 8 + len(pixels)) + pixels + directory)


def mrc(name):
    header = bytearray(1024)
    struct.pack_into("<10i", header, 0, SIDE, SIDE, SIDE, 2, 0, 0, 0, SIDE, SIDE, SIDE)
    struct.pack_into("<6f", header, 40, SIDE, SIDE, SIDE, 90, 90, 90)
    struct.pack_into("<3i", header, 64, 1, 2, 3)
    header[208:216] = b"MAP \x44\x44\0\0"
    pathlib.Path(name).write_bytes(gzip.compress(bytes(header) + struct.pack(f"<{len(BALL)}f", *BALL)))


def cube(name):
    # The last axis is the fastest.
    values = [BALL[(z * SIDE + y) * SIDE + x] for x in range(SIDE) for y in range(SIDE) for z in range(SIDE)]
    axes = "".join(f"{SIDE} " + " ".join("1.0" if i == axis else "0.0" for i in range(3)) + "\n" for axis in range(3))
    pathlib.Path(name).write_text("an orbital\n\n1 0.0 0.0 0.0\n" + axes + "1 0.0 0.0 0.0 0.0\n" +
                                  "\n".join(map(str, values)) + "\n")


def ome_zarr(name):
    root = pathlib.Path(name)
    (root / "0").mkdir(parents=True)
    (root / ".zgroup").write_text('{"zarr_format": 2}')
    axes = [{"name": "t", "type": "time"}, {"name": "c", "type": "channel"}] + [
        {"name": axis, "type": "space", "unit": "micrometer"} for axis in "zyx"]
    transform = [{"type": "scale", "scale": [1, 1, 1, 1, 1]}]
    (root / ".zattrs").write_text(json.dumps({"multiscales": [{"version": "0.4", "axes": axes, "datasets": [
        {"path": "0", "coordinateTransformations": transform}]}]}))
    shape = [1, 2, SIDE, SIDE, SIDE]
    (root / "0" / ".zarray").write_text(json.dumps({
        "zarr_format": 2, "shape": shape, "chunks": [1, 1, SIDE, SIDE, SIDE], "dtype": "<f4", "compressor": None,
        "fill_value": 0, "order": "C", "filters": None}))
    for channel in range(2):
        (root / "0" / f"0.{channel}.0.0.0").write_bytes(struct.pack(f"<{len(BALL)}f", *BALL))


nifti("brain.nii.gz", BALL)
nifti("heart4d.nii.gz", BALL * 3, times=3)
nifti("seg.nii.gz", [(1 if index[0] < 6 else 2) if value > 0 else 0 for index, value in zip(INDICES, BALL)], code=4, letter="h")
vti("step60.vti", "density", "temperature")
vti("run.vti", "pressure", "temperature")
for number in range(3):
    vti(f"flow_{number}.vti", "flow")
pathlib.Path("slices").mkdir()
for slice_number in range(SIDE):
    tiff(f"slices/ct_{slice_number:02}.tif", slice_number)
mrc("emd_1234.map.gz")
pathlib.Path("emd-1234.xml").write_text('<emd emdb_id="EMD-1234"><map><contour_list><contour primary="true"><level>12.5</level>'
                                        "</contour></contour_list></map></emd>")
cube("orbital.cube")
ome_zarr("image.zarr")
pathlib.Path("fuel_64x64x64_uint8.raw").write_bytes(bytes(min(255, x * y * z // 900) for z in range(64) for y in range(64)
                                                          for x in range(64)))
pathlib.Path("scans").mkdir()
shutil.copy("brain.nii.gz", "scans")
