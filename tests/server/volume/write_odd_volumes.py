"""Writes volumes like those of other programs, and invalid ones: unusual DICOM series and rare formats.

    python3 write_odd_volumes.py FOLDER

Prints a tab-separated line for each. For readable volumes: "read", a name, a path, options of VolumeChoice, a file of the
expected samples (f32, x fastest), the counts, the first sample's position and the three steps in the world, the unit, and a
part of the notice (or nothing). For invalid ones: "refuse", a name, a path, options, and a part of the error message.
"""
import gzip
import json
import os
import struct
import zipfile
import zlib

import numpy

from volume_writing import (diagonal, dicom_image, dicom_items as items, dicom_save as save, expect_read as read,
                            expect_refused as refuse, folder, run_with_packages, write)

SHAPE = (6, 7, 9)  # z, y, x
z, y, x = numpy.meshgrid(*(numpy.arange(n) for n in SHAPE), indexing="ij")
volume = (90 * z + 10 * y + 7 * x + (x * y * z) % 5 - 100).astype("<i2")


# ---- DICOM

def dicom():
    import pydicom
    from pydicom.sequence import Sequence
    LITTLE = pydicom.uid.ExplicitVRLittleEndian

    def image(number, **more):
        return dicom_image(number, SHAPE[1], SHAPE[2], **more)

    # Enhanced CT: `order` gives the slice of each frame.
    def enhanced(name, order, slopes=None, places=None, own=None):
        data = image(1, kind="1.2.840.10008.5.1.4.1.1.2.1")
        data.NumberOfFrames = len(order)
        data.SharedFunctionalGroupsSequence = items(
            PixelMeasuresSequence=items(PixelSpacing=[0.75, 0.5], SliceThickness=2),
            PlaneOrientationSequence=items(ImageOrientationPatient=[1, 0, 0, 0, 1, 0]))
        frames = []
        for at in order:
            slope, intercept = slopes[at] if slopes else (1, 0)
            place = places[at] if places else 30 + 2 * at
            frames.append(items(
                PlanePositionSequence=items(ImagePositionPatient=[10, -20, place]),
                PixelValueTransformationSequence=items(RescaleIntercept=intercept, RescaleSlope=slope, RescaleType="HU"))[0])
            if own and at in own:
                frames[-1].update(own[at])
        data.PerFrameFunctionalGroupsSequence = Sequence(frames)
        data.PixelData = volume[order].tobytes()
        return save(data, f"{name}.dcm")

    place = {"origin": (10, -20, 30), "steps": diagonal(0.5, 0.75, 2), "unit": "mm"}
    whole = list(range(SHAPE[0]))
    read("enhanced-descending", enhanced("descending", whole[::-1]), volume, **place)
    shuffled = [3, 0, 5, 1, 4, 2]
    read("enhanced-shuffled", enhanced("shuffled", shuffled), volume, **place)
    for name, own in (("spacing", {"PixelMeasuresSequence": items(PixelSpacing=[1, 1], SliceThickness=2)}),
                      ("orientation", {"PlaneOrientationSequence": items(ImageOrientationPatient=[1, 0, 0, 0, 0, -1])})):
        read(f"enhanced-own-{name}", enhanced(f"own-{name}", whole, own={0: own}), volume[1:], notice="than most is skipped",
             **{**place, "origin": (10, -20, 32)})
    path = enhanced("short-frames", whole)
    data = pydicom.dcmread(path)
    data.PixelData = volume[:3].tobytes()
    refuse("enhanced-short", save(data, "short-frames.dcm"), "require 756")
    slopes = [(1 + 0.5 * i, -10 * i) for i in whole]
    values = numpy.stack([volume[i] * slopes[i][0] + slopes[i][1] for i in whole])
    read("enhanced-slopes", enhanced("slopes", shuffled, slopes), values, **place)
    refuse("enhanced-gap", enhanced("gap", [0, 1, 2, 4, 5]), "1 seem to be missing")
    filled = volume.astype("f4").copy()
    filled[3] = (filled[2] + filled[4]) / 2
    read("enhanced-gap-resampled", enhanced("gap", [0, 1, 2, 4, 5]), filled, options="resample",
         notice="--resample makes them 6 slices", **place)

    # One image per file.
    def slices(name, places, kind=None, syntax=LITTLE, pack=None):
        paths = []
        for i, at in enumerate(places):
            data = image(i + 1, syntax=syntax)
            data.PixelSpacing, data.SliceThickness = [0.75, 0.5], 2
            data.ImagePositionPatient, data.ImageOrientationPatient = list(at), [1, 0, 0, 0, 1, 0]
            data.RescaleSlope, data.RescaleIntercept, data.RescaleType = 1, 0, "HU"
            data.PixelData = volume[i].tobytes()
            if kind:
                kind(i, data)
            if pack:
                data.compress(pack)
            paths.append(save(data, name, f"slice{i}.dcm"))
        return folder / name

    def above(*heights):
        return [(10, -20, height) for height in heights]

    even = above(*(30 + 2 * i for i in range(6)))
    read("dicom-rounded", slices("rounded", above(30, 32.1, 33.9, 36, 38.1, 40)), volume,
         notice="0.1 mm off an even grid", **place)
    uneven = above(30, 32, 33, 36, 38, 40)
    refuse("dicom-uneven", slices("uneven", uneven), "--resample")
    at_34 = (volume[2] + (volume[3].astype("f4") - volume[2]) / 3)
    expected = volume.astype("f4").copy()
    expected[2] = at_34
    read("dicom-uneven-resampled", slices("uneven", uneven), expected, options="resample", notice="are not evenly spaced",
         **place)
    # Steps of 0.01 mm and one distant slice: the message states the true number of slices.
    far = above(30, 30.01, 30.02, 30.03, 30.04, 2530.05)
    refuse("dicom-far", slices("far", far), "would have 250006 slices", options="resample")
    # A tilt of half a row per slice: every other slice has rows between two rows of the new grid.
    tilted = [(10, -20 + 0.375 * i, 30 + 2 * i) for i in range(6)]
    refuse("dicom-tilted", slices("tilt", tilted), "tilted gantry")
    straight = numpy.full((6, 7 + 3, 9), numpy.nan, "f4")
    for i in range(6):
        for row in range(10):
            at = row - 0.5 * i
            if 0 <= at <= 6:
                low = int(at)
                high = min(low + 1, 6)
                straight[i, row] = volume[i, low] + (at - low) * (volume[i, high].astype("f4") - volume[i, low])
    read("dicom-tilted-resampled", slices("tilt", tilted), straight, options="resample", notice="tilted gantry", **place)

    slices("localizer", even)
    other = image(50)
    other.Rows, other.Columns, other.ImageType = 4, 5, ["ORIGINAL", "PRIMARY", "LOCALIZER"]
    other.PixelSpacing, other.ImagePositionPatient, other.ImageOrientationPatient = [1, 1], [0, 0, 0], [1, 0, 0, 0, 0, -1]
    other.PixelData = bytes(40)
    save(other, "localizer", "scout.dcm")
    read("dicom-localizer", folder / "localizer", volume, notice="1 image of a localizer is skipped: 'scout.dcm'", **place)
    del other.ImageType
    slices("second-shape", even)
    save(other, "second-shape", "scout.dcm")
    read("dicom-second-shape", folder / "second-shape", volume, notice="another size, type, spacing or orientation", **place)

    def wider(i, data):
        if i == 0:
            data.PixelSpacing = [1, 1]

    from_second = {**place, "origin": (10, -20, 32)}
    read("dicom-second-spacing", slices("second-spacing", even, wider), volume[1:],
         notice="another size, type, spacing or orientation than most is skipped: 'slice0.dcm'", **from_second)

    # Directions of two decimals: corrected, both by the same angle. GDCM takes them for none.
    rough = numpy.array([[0.88, 0.32, 0.34], [-0.34, 0.94, 0]])
    directions = [one / numpy.linalg.norm(one) for one in rough]
    halves = [one / numpy.linalg.norm(one) * 0.5 ** 0.5 for one in (directions[0] + directions[1], directions[0] - directions[1])]
    row, column = halves[0] + halves[1], halves[0] - halves[1]
    normal = numpy.cross(row, column)

    def rounded(i, data, stored=rough):
        data.ImageOrientationPatient = [f"{v:g}" for v in stored.ravel()]

    places = [tuple(float(f"{v:.9f}") for v in numpy.array([10, -20, 30]) + 2 * i * normal) for i in range(6)]
    read("dicom-rounded-directions", slices("rounded-directions", places, rounded), volume, notice="they were corrected", origin=places[0],
         steps=(0.5 * row, 0.75 * column, 2 * normal), unit="mm")
    refuse("dicom-skewed", slices("skewed", places, lambda i, data: rounded(i, data, rough + [[0, 0, 0], [0.1, 0, 0]])), "at right angles")

    def stranger(i, data):
        if i == 4:
            data.PatientID, data.StudyInstanceUID = "two", "1.2.3.201"

    read("dicom-stranger", slices("stranger", even, stranger), volume, notice="of another patient or study", **place)

    # Truncated files.
    def cut(name, size, which=3, **more):
        slices(name, even, **more)
        path = folder / name / f"slice{which}.dcm"
        data = path.read_bytes()
        path.write_bytes(data[:size] if size >= 0 else data[:len(data) + size])
        return folder / name

    slices("with-text", even)
    write("with-text/VERSION", b"1.0")
    read("dicom-with-text", folder / "with-text", volume, **place)
    refuse("dicom-cut-off", cut("cut", -20), "truncated")
    # Within the meta information, within an element, and at the head of one, where GDCM aborts.
    for size in (133, 200, 400, 600):
        refuse(f"dicom-cut-header-{size}", cut(f"cut-header-{size}", size), "slice3.dcm': it ends within its header")
    refuse("dicom-cut-before-header", cut("cut-all", 60, which=5), "not a DICOM file, or is truncated")

    def short(i, data):
        if i == 2:
            data.PixelData = data.PixelData[:100]

    refuse("dicom-short-pixels", slices("short", even, short), "its rows, columns, frames and bits require 126")
    refuse("dicom-rle-cut-off", cut("cut-rle", -30, pack=pydicom.uid.RLELossless), "truncated")

    def short_rle(i, data):
        if i == 2:
            from pydicom.encaps import encapsulate
            packed = bytes(data.PixelData)
            data.file_meta.TransferSyntaxUID = pydicom.uid.RLELossless
            head = struct.pack("<16I", 2, 64, 100, *[0] * 13)
            data.PixelData = encapsulate([head + bytes([0x80] * 60)])
            data["PixelData"].is_undefined_length = True
            del packed

    refuse("dicom-rle-short", slices("short-rle", even, short_rle), "a compressed frame ends too early")

    def short_jpeg(i, data):
        if i == 2:
            from pydicom.encaps import encapsulate
            data.file_meta.TransferSyntaxUID = pydicom.uid.JPEGLosslessSV1
            data.PixelData = encapsulate([b"\xff\xd8\xff\xc3" + bytes(100)])
            data["PixelData"].is_undefined_length = True

    refuse("dicom-jpeg-short", slices("short-jpeg", even, short_jpeg), "a compressed frame ends too early")

    def jpeg(share):
        def kind(i, data):
            from pydicom.encaps import encapsulate
            frame = lossless_jpeg(volume[i].view("<u2"))
            if i == 2 and share < 1:
                frame = frame[:int(share * len(frame)) // 2 * 2]
            data.file_meta.TransferSyntaxUID = pydicom.uid.JPEGLosslessSV1
            data.PixelData = encapsulate([frame])
            data["PixelData"].is_undefined_length = True
        return kind

    read("dicom-jpeg-lossless", slices("jpeg-lossless", even, jpeg(1)), volume, **place)
    refuse("dicom-jpeg-cut-off", slices("jpeg-cut", even, jpeg(0.6)), "a compressed frame ends too early")
    refuse("dicom-deflated-cut-off", cut("cut-deflated", -30, syntax=pydicom.uid.DeflatedExplicitVRLittleEndian), "too early")


def lossless_jpeg(image):
    """JPEG with process 14, selection value 1: differences to the left neighbor, with codes of five bits for their lengths."""
    rows, columns = image.shape
    left = numpy.empty((rows, columns), "i8")
    left[:, 1:] = image[:, :-1]
    left[1:, 0] = image[:-1, 0]
    left[0, 0] = 1 << 15
    bits = ""
    for difference in ((image.astype("i8") - left + 32767) % 65536 - 32767).ravel().tolist():
        length = abs(difference).bit_length()
        bits += f"{length:05b}"
        if 0 < length < 16:
            bits += f"{difference if difference > 0 else difference + (1 << length) - 1:0{length}b}"
    bits += "1" * (-len(bits) % 8)
    scan = int(bits, 2).to_bytes(len(bits) // 8, "big").replace(b"\xff", b"\xff\0")
    table = bytes([0, 0, 0, 0, 17, *[0] * 11, *range(17)])
    return (b"\xff\xd8\xff\xc3" + struct.pack(">HBHH", 11, 16, rows, columns) + bytes([1, 1, 0x11, 0]) +
            b"\xff\xc4" + struct.pack(">HB", 3 + len(table), 0) + table +
            b"\xff\xda" + struct.pack(">H", 8) + bytes([1, 1, 0, 1, 0, 0]) + scan + b"\xff\xd9")


# ---- formats written without libraries

def mgh():
    # Coronal slices: x to the left, y down, z to the front; 1 x 2 x 3 mm. The directions of
    # columns, rows and slices are in RAS.
    axes = numpy.array([(-1, 0, 0), (0, 0, -1), (0, 1, 0)])
    size = numpy.array((1.0, 2.0, 3.0))
    middle = numpy.array((5.0, 6.0, 7.0))
    head = struct.pack(">7ih", 1, 9, 7, 6, 1, 4, 0, 1) + struct.pack(">15f", *size, *axes.ravel(), *middle)
    data = head.ljust(284, b"\0") + volume.astype(">i2").tobytes()
    steps = axes * size[:, None]
    origin = middle - (steps * numpy.array((9, 7, 6))[:, None] / 2).sum(axis=0)
    turn = numpy.array((-1, -1, 1))
    for name, stored in (("v.mgh", data), ("v.mgz", gzip.compress(data))):
        read(name, write(name, stored), volume, origin * turn, steps * turn, "mm")
    refuse("mgz-trailing", write("t.mgz", gzip.compress(data) + b"more"), "other bytes after its compressed samples")


def npy():
    for name, array in (("c", volume), ("big", volume.astype(">i2")), ("half", volume.astype("f2")), ("f8", volume / 4)):
        numpy.save(folder / f"{name}.npy", array)
        read(f"npy-{name}", folder / f"{name}.npy", array)
    numpy.save(folder / "fortran.npy", numpy.asfortranarray(volume))
    read("npy-fortran", folder / "fortran.npy", volume.transpose(2, 1, 0), steps=((0, 0, 1), (0, 1, 0), (1, 0, 0)))
    numpy.save(folder / "times.npy", numpy.stack([volume * 0, volume]))
    read("npy-time", folder / "times.npy", volume, options="time=1")
    refuse("npy-complex", write("complex.npy", (folder / "c.npy").read_bytes().replace(b"<i2", b"<c8")), "'<c8'")
    further = {"spacing": numpy.ones(3), "name": numpy.array("x"), "complex": volume * 1j}
    for name, save in (("stored", numpy.savez), ("deflated", numpy.savez_compressed)):
        save(folder / f"one-{name}.npz", density=volume.astype("f2"), **further)
        read(f"npz-one-{name}", folder / f"one-{name}.npz", volume)
        save(folder / f"two-{name}.npz", a=volume, b=numpy.stack([volume * 0, volume.astype(">i4")]))
        path = folder / f"two-{name}.npz"
        refuse(f"npz-two-{name}", path, "it has 3 arrays: /a, /b, /group/inner/c", remedy="array=/group/inner/c")
        read(f"npz-time-{name}", path, volume, options="array=b,time=1")
        with zipfile.ZipFile(path, "a") as archive:
            archive.write(folder / "c.npy", "group/inner/c.npy")
        read(f"npz-group-{name}", path, volume, options="array=group/inner/c")
        refuse(f"npz-third-{name}", path, "Its arrays are a, b, group/inner/c", options="array=c")
    refuse("npz-type", folder / "one-stored.npz", "'<c16'", options="array=complex")
    data = (folder / "two-stored.npz").read_bytes()
    at = data.index(volume.tobytes())
    refuse("npz-changed", write("changed.npz", data[:at] + b"!!" + data[at + 2:]), "its checksum (CRC-32) does not match", options="array=a")
    numpy.savez(folder / "none.npz", numpy.ones(3), numpy.ones(4))
    numpy.save(folder / "radius.npy", 1737400 + numpy.linspace(-0.2, 0.2, 240).reshape(5, 6, 8))
    refuse("npy-large-doubles", folder / "radius.npy", "--subtract")
    refuse("npz-none", folder / "none.npz", "no array of numbers with two or more dimensions")


def netcdf3():
    def name_of(text):
        data = text.encode()
        return struct.pack(">I", len(data)) + data + bytes(-len(data) % 4)

    def text_attribute(name, text):
        return name_of(name) + struct.pack(">I", 2) + name_of(text)

    def number_attribute(name, number):
        return name_of(name) + struct.pack(">IId", 6, 1, number)

    def attributes(*list_):
        return struct.pack(">II", 12 if list_ else 0, len(list_)) + b"".join(list_)

    # Variables: name, dimensions, attributes, type, and the bytes of each record or of all data.
    def file(version, with_records):
        z_length = 0 if with_records else 6
        dims = (("z", z_length), ("y", 7), ("x", 9))
        axes = [("z", 30 + 2 * numpy.arange(6)), ("y", -20 + 0.75 * numpy.arange(7)), ("x", 10 + 0.5 * numpy.arange(9))]
        variables = [(name, [i], attributes(text_attribute("units", "um")), 6, values.astype(">f8"), with_records and i == 0)
                     for i, (name, values) in enumerate(axes)]
        packed = volume.astype(">i2")
        variables.append(("field", [0, 1, 2], attributes(number_attribute("scale_factor", 0.5), number_attribute(
            "add_offset", 3), text_attribute("units", "K")), 3, packed, with_records))
        head = b"CDF" + bytes([version]) + struct.pack(">I", 6 if with_records else 0)
        head += struct.pack(">II", 10, len(dims)) + b"".join(name_of(n) + struct.pack(">I", length) for n, length in dims)
        head += attributes(text_attribute("title", "odd"))
        head += struct.pack(">II", 11, len(variables))
        wide = ">Q" if version > 1 else ">I"

        def entries(begins):
            result = b""
            for (name, on, list_, kind, data, records), begin in zip(variables, begins):
                size = data.nbytes // (6 if records else 1)
                result += name_of(name) + struct.pack(">I", len(on)) + b"".join(struct.pack(">I", i) for i in on) + list_
                result += struct.pack(">II", kind, size + -size % 4) + struct.pack(wide, begin)
            return result

        at = len(head) + len(entries([0] * 4))
        begins = {}
        body = b""
        for i, (*_, data, records) in enumerate(variables):
            if not records:
                begins[i] = at + len(body)
                body += data.tobytes() + bytes(-data.nbytes % 4)
        start = at + len(body)
        for i, (*_, data, records) in enumerate(variables):
            if records:
                begins[i] = start
                start += data.nbytes // 6 + -(data.nbytes // 6) % 4
        for record in range(6 if with_records else 0):
            for *_, data, records in variables:
                if records:
                    part = data[record:record + 1].tobytes()
                    body += part + bytes(-len(part) % 4)
        return head + entries([begins[i] for i in range(4)]) + body

    values = volume * 0.5 + 3
    place = {"origin": (10, -20, 30), "steps": diagonal(0.5, 0.75, 2), "unit": "µm"}
    for version in (1, 2):
        for with_records in (False, True):
            name = f"{version}{'r' if with_records else ''}.nc"
            read(f"netcdf3-{name}", write(name, file(version, with_records)), values, **place)
    refuse("netcdf3-cut-off", write("cut.nc", file(1, False)[:-100]), "ends too early")
    refuse("netcdf3-name", f"{folder}/1.nc:/other", "there are field")
    refuse("netcdf-neither", write("neither.nc", b"something else" * 100), "not an HDF5 or NetCDF file")
    try:  # Files that SciPy writes, if installed.
        from scipy.io import netcdf_file
    except ImportError:
        return
    with netcdf_file(folder / "scipy.nc", "w") as out:
        for n, length in zip("zyx", SHAPE):
            out.createDimension(n, length)
        out.createVariable("field", "f4", tuple("zyx"))[:] = volume
    read("netcdf3-scipy", folder / "scipy.nc", volume)


def small_ones():
    head = bytearray(1024)
    struct.pack_into("<10i", head, 0, 9, 7, 6, 12, 0, 0, 0, 9, 7, 6)
    struct.pack_into("<6f", head, 40, 9, 7, 6, 90, 90, 90)
    struct.pack_into("<3i", head, 64, 1, 2, 3)
    head[208:214] = b"MAP DD"
    read("mrc-half", write("half.mrc", bytes(head) + volume.astype("<f2").tobytes()), volume, unit="Å")

    text = ("a cube\nof a test\n1 0 0 0\n6 0 0 2\n7 0 0.5 0\n9 1 0 0\n1 1 0 0 0\n" +
            " ".join(f"{n:.5E}" for n in volume.ravel()) + "\n").encode()
    steps = ((1, 0, 0), (0, 0.5, 0), (0, 0, 2))
    read("cube-gz", write("v.cube.gz", gzip.compress(text)), volume, steps=steps, unit="bohr")

    write("described.raw", volume.tobytes())
    read("dat-comments", write("described.dat", b"# from somewhere\r\n\r\nResolution: 9 7 6 # x y z\r\nFormat: SHORT\r\n"
                               b"ObjectFileName: described.raw\r\nSliceThickness: 1 2 3\r\n"), volume,
         steps=diagonal(1, 2, 3))
    counts = struct.pack("<3H", 9, 7, 6)
    high = (volume + 200).astype("<u2")
    read("counts-gz", write("counts.dat.gz", gzip.compress(counts + high.tobytes())), high)
    read("counts-before-gz", write("before.dat", counts + gzip.compress(high.tobytes())), high)
    packed = gzip.compress(high.tobytes())  # With a name inside that makes it as long as the samples.
    name = b"n" * (high.nbytes - len(packed) - 1) + b"\0"
    read("counts-before-gz-as-long", write("as-long.dat", counts + packed[:3] + b"\x08" + packed[4:10] + name + packed[10:]), high)

    refuse("raw-unknown", write("unknown.raw", bytes(range(200))), "the layout of raw samples with --dims")
    refuse("raw-other-size", write("raw_8x6x5_uint8.raw", bytes(200)), "Give the layout with --dims")

    # Analyze and two-file NIfTI, opened by the samples' file.
    for name, mark in (("analyze", b""), ("pair", b"ni1\0")):
        hdr = bytearray(348)
        struct.pack_into("<i", hdr, 0, 348)
        hdr[38:39] = b"r"
        struct.pack_into("<8h", hdr, 40, 3, 9, 7, 6, 1, 1, 1, 1)
        struct.pack_into("<2h", hdr, 70, 4, 16)
        struct.pack_into("<8f", hdr, 76, 1, 1, 2, 3, 1, 1, 1, 1)
        hdr[123] = 2
        hdr[344:348] = mark.ljust(4, b"\0")
        write(f"{name}.hdr", bytes(hdr))
        write(f"{name}.img", volume.tobytes())
        for suffix in ("hdr", "img"):
            read(f"{name}-{suffix}", folder / f"{name}.{suffix}", volume, steps=diagonal(1, 2, 3), unit="mm")
        struct.pack_into("<f", hdr, 112, 0.25)  # Of SPM and NIfTI.
        path = write(f"scaled-{name}.hdr", bytes(hdr))
        write(f"scaled-{name}.img", volume.tobytes())
        read(f"{name}-scaled", path, volume * 0.25, steps=diagonal(1, 2, 3), unit="mm", notice="" if mark else "scale factor 0.25")

    lines = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 9 7 6\nencoding: {}\nendian: little\n\n"
    packed = gzip.compress(volume.tobytes())
    refuse("nrrd-trailing", write("t.nrrd", lines.format("gzip").encode() + packed + b"garbage"), "other bytes after its compressed samples")
    refuse("nrrd-checksum", write("c.nrrd", lines.format("gzip").encode() + packed[:-8] + b"\0\0\0\0" + packed[-4:]), "damaged")
    refuse("nrrd-no-checksum", write("n.nrrd", lines.format("gzip").encode() + packed[:-8]), "too early")
    read("nrrd-zeros", write("z.nrrd", lines.format("gzip").encode() + packed + bytes(600)), volume)
    long_name = b'<?xml version="1.0"?><VTKFile type="ImageData" version="' + b"1" * 30_000_000
    refuse("vti-attribute", write("long.vti", long_name + b'"></VTKFile>'), "a tag of its XML is longer")
    refuse("name-escaped", write("odd\u202ename\x1b[2J.nii", b"nothing"), r"odd\xe2\x80\xaename\x1b[2J.nii")


def pvti():
    # Pieces that share a layer of samples, as VTK writes them.
    parts = (("left", (0, 4, 0, 6, 0, 5)), ("right", (4, 8, 0, 6, 0, 5)))
    for name, extent in parts:
        x0, x1, y0, y1, z0, z1 = extent
        part = volume[z0:z1 + 1, y0:y1 + 1, x0:x1 + 1]
        write(f"parts/{name}.vti", (
            '<VTKFile type="ImageData"><ImageData WholeExtent="0 8 0 6 0 5" Origin="1 2 3" Spacing="1 2 3"><Piece Extent="' +
            " ".join(map(str, extent)) + '"><PointData><DataArray type="Int16" Name="a" format="ascii">' +
            " ".join(map(str, part.ravel())) + "</DataArray></PointData></Piece></ImageData></VTKFile>").encode())

    def whole(name, pieces):
        return write(f"{name}.pvti", (
            '<VTKFile type="PImageData"><PImageData WholeExtent="0 8 0 6 0 5" GhostLevel="0" Origin="1 2 3" Spacing="1 2 3">' +
            "".join(f'<Piece Extent="{" ".join(map(str, extent))}" Source="{file}"/>' for file, extent in pieces) +
            "</PImageData></VTKFile>").encode())

    pieces = [(f"parts/{name}.vti", extent) for name, extent in parts]
    read("pvti", whole("v", pieces), volume, (1, 2, 3), diagonal(1, 2, 3))
    refuse("pvti-hole", whole("hole", pieces[:1]), "do not cover")
    refuse("pvti-gone", whole("gone", [("parts/gone.vti", parts[0][1])]), "is missing")
    refuse("pvti-out", whole("parts/out", [("../parts/left.vti", parts[0][1]), ("../v.pvti", parts[1][1])]), "--follow")
    refuse("pvti-piece", folder / "parts/left.vti", ".pvti file")


def n5():
    for name, more in (("units", {"resolution": [0.5, 0.75, 2], "units": ["nm", "nm", "nm"]}),
                       ("unit", {"resolution": [0.5, 0.75, 2], "units": "nm"})):
        write(f"{name}.n5/attributes.json", json.dumps({
            "dimensions": SHAPE[::-1], "blockSize": SHAPE[::-1], "dataType": "int16", "compression": {"type": "raw"},
            **more}).encode())
        write(f"{name}.n5/0/0/0", struct.pack(">HHIII", 0, 3, *SHAPE[::-1]) + volume.astype(">i2").tobytes())
        read(f"n5-{name}", folder / f"{name}.n5", volume, steps=diagonal(0.5, 0.75, 2), unit="nm")
    refuse("n5-level", folder / "unit.n5", "--level does not apply", options="level=1")


# ---- Zarr

def zarr_2(name, shape=SHAPE, chunks=None, dtype="<i2", compressor=None, blocks=()):
    write(f"{name}/.zarray", json.dumps({
        "zarr_format": 2, "shape": shape, "chunks": chunks or shape, "dtype": dtype, "compressor": compressor,
        "fill_value": 0, "order": "C", "filters": None}).encode())
    for key, data in blocks:
        write(f"{name}/{key}", data)
    return folder / name


def zarrs():
    read("zarr-half", zarr_2("half.zarr", dtype=">f2", blocks=[("0.0.0", volume.astype(">f2").tobytes())]), volume)
    missing = volume.copy()
    missing[3:] = 0
    read("zarr-missing", zarr_2("missing.zarr", chunks=(3, 7, 9), blocks=[("0.0.0", volume[:3].tobytes())]), missing,
         notice="1 of 2 chunks are missing")
    # As xarray writes them: NaN is not JSON.
    zarr_2("nan.zarr", blocks=[("0.0.0", volume.tobytes())])
    write("nan.zarr/.zattrs", json.dumps({"_FillValue": float("nan"), "valid_range": [float("-inf"), 2]}).encode())
    read("zarr-nan", folder / "nan.zarr", numpy.where(volume > 2, numpy.nan, volume))
    # Links and paths that lead out of the store.
    secret = write("elsewhere/0.0.0", volume.tobytes())
    linked = zarr_2("linked.zarr")
    os.symlink(secret, linked / "0.0.0")
    refuse("zarr-link", linked, "is outside the folder")
    read("zarr-link-followed", linked, volume, options="follow")
    zarr_2("other.zarr", blocks=[("0.0.0", volume.tobytes())])
    write("image.zarr/.zattrs", json.dumps({"multiscales": [{"axes": [{"name": n} for n in "zyx"], "datasets": [
        {"path": "../other.zarr", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]}]}]}).encode())
    refuse("zarr-path-out", folder / "image.zarr", "is outside the folder")
    read("zarr-path-out-followed", folder / "image.zarr", volume, options="follow")
    refuse("zarr-level", folder / "other.zarr", "--level does not apply", options="level=1")
    for option in ("time=1", "channel=1"):
        refuse(f"zarr-{option}", folder / "other.zarr", "does not apply", options=option)
    for method, suffix in ((zipfile.ZIP_STORED, "stored"), (zipfile.ZIP_DEFLATED, "deflated")):
        with zipfile.ZipFile(folder / f"{suffix}.zip", "w", method) as archive:
            for file in ("other.zarr/.zarray", "other.zarr/0.0.0"):
                archive.write(folder / file, file)
        read(f"zarr-zip-{suffix}", folder / f"{suffix}.zip", volume)
    damaged = bytearray((folder / "stored.zip").read_bytes())
    damaged[damaged.index(volume.tobytes()) + 5] ^= 1
    refuse("zarr-zip-damaged", write("damaged.zip", bytes(damaged)), "CRC-32")
    long = zarr_2("long.zarr", (4, *SHAPE), (2_000_000, *SHAPE), blocks=[("0.0.0.0", b"")])
    refuse("zarr-long-chunks", long, "chunks are too large", options="time=0")
    # Shards of 2^21 chunks each, so that the index dominates.
    write("shards.zarr/zarr.json", json.dumps({
        "zarr_format": 3, "node_type": "array", "shape": [8192, 8192, 1], "data_type": "uint8",
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2048, 1024, 1]}},
        "chunk_key_encoding": {"name": "default"}, "fill_value": 0, "codecs": [{
            "name": "sharding_indexed", "configuration": {"chunk_shape": [1, 1, 1], "codecs": [{"name": "bytes"}],
                                                          "index_codecs": [{"name": "bytes"}]}}]}).encode())
    refuse("zarr-shards", folder / "shards.zarr", "shards are too large")


def zarr_lz4():
    import numcodecs
    data = numcodecs.LZ4().encode(volume.tobytes())
    read("zarr-lz4", zarr_2("lz4.zarr", compressor={"id": "lz4", "acceleration": 1}, blocks=[("0.0.0", data)]), volume)


# ---- HDF5

def hdf5():
    import h5py
    with h5py.File(folder / "lzf.h5", "w") as file:
        file.create_dataset("v", data=volume, chunks=(2, 7, 9), compression="lzf", shuffle=True)
    read("hdf5-lzf", folder / "lzf.h5", volume)
    with h5py.File(folder / "short.h5", "w") as file:
        short = file.create_dataset("v", SHAPE, "<i2", chunks=SHAPE, compression="lzf")
        short.id.write_direct_chunk((0, 0, 0), b"\x1f" + bytes(32))  # 32 bytes of a whole chunk.
    refuse("hdf5-lzf-short", folder / "short.h5", "cannot be read")
    # Layers of chunks, the second one too short for its shape, with every filter; and complete ones.
    short = volume.tobytes()[:60]
    layouts = {"deflate": {"compression": "gzip"}, "shuffle": {"compression": "gzip", "shuffle": True},
               "checksum": {"compression": "gzip", "fletcher32": True}, "none": {}}
    for name, filters in layouts.items():
        for libver in "earliest", "latest":
            path = folder / f"chunks-{name}-{libver}.h5"
            with h5py.File(path, "w", libver=libver) as file:
                file.create_dataset("v", data=volume, chunks=(2, 4, 9), **filters)
            read(f"hdf5-chunks-{name}-{libver}", path, volume)
    for name, filters, data, skipped in (
            ("deflate", layouts["deflate"], zlib.compress(short), 0), ("shuffle", layouts["shuffle"], zlib.compress(short), 0),
            ("more", layouts["deflate"], zlib.compress(bytes(2 * 2 * 4 * 9 + 2)), 0), ("none", {}, short, 0),
            ("skipped-filter", layouts["deflate"], short, 1),
            ("scale-offset", {"scaleoffset": 0}, b"\x0a" + bytes(60), 0), ("scale-offset-header", {"scaleoffset": 0}, bytes(9), 0),
            ("scale-offset-deflate", {"scaleoffset": 0, "compression": "gzip"}, zlib.compress(b"\x0a" + bytes(60)), 0)):
        if name == "none" and h5py.version.hdf5_version_tuple >= (2,):
            continue  # The library aborts instead of writing it.
        path = folder / f"short-{name}.h5"
        with h5py.File(path, "w") as file:
            dataset = file.create_dataset("v", data=volume, chunks=(2, 4, 9), **filters)
            dataset.id.write_direct_chunk((4, 4, 0), data, skipped)
        refuse(f"hdf5-short-{name}", path, "bytes that its shape requires")
    # A chunk of the stored size less some bytes, where the filter's own bytes count.
    def shorten(dataset, bytes_left_out):
        data = dataset.id.read_direct_chunk((4, 4, 0))[1]
        dataset.id.write_direct_chunk((4, 4, 0), data[:-bytes_left_out])

    twelve_bits = h5py.h5t.STD_I16LE.copy()
    twelve_bits.set_precision(12)
    for name, number, bytes_left_out, sentence in (("nbit", h5py.h5z.FILTER_NBIT, 3, "bytes that its shape requires"),
                                                   ("szip", None, 20, "bytes that its shape requires"),
                                                   ("zstd", 32015, 0, "packed with HDF5 filter 32015")):
        for is_short in (False, True):
            path = folder / f"{'short' if is_short else 'whole'}-{name}.h5"
            with h5py.File(path, "w") as file:
                creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
                creation.set_chunk((2, 4, 9))
                if name == "szip":
                    creation.set_szip(h5py.h5z.SZIP_EC_OPTION_MASK, 8)
                else:
                    creation.set_filter(number, h5py.h5z.FLAG_OPTIONAL, ())
                kind = twelve_bits if name == "nbit" else h5py.h5t.STD_I16LE
                h5py.h5d.create(file.id, b"v", kind, h5py.h5s.create_simple(SHAPE), creation)
                file["v"][:] = volume
                if is_short and bytes_left_out:
                    shorten(file["v"], bytes_left_out)
                elif is_short:
                    file["v"].id.write_direct_chunk((4, 4, 0), bytes(143))  # With the size of a whole chunk it would stay unpacked.
            if is_short:
                refuse(f"hdf5-short-{name}", path, sentence)
            else:
                read(f"hdf5-{name}", path, volume)
    for name, filters in (("scale-offset", {"scaleoffset": 0}),
                          ("scale-offset-more", {"scaleoffset": 0, "shuffle": True, "compression": "gzip"})):
        with h5py.File(folder / f"{name}.h5", "w") as file:
            file.create_dataset("v", data=volume, chunks=(2, 4, 9), **filters)
        read(f"hdf5-{name}", folder / f"{name}.h5", volume)
    # A chunk that the file claims to be wider than what LZF unpacks to.
    wide = (folder / "lzf.h5").read_bytes().replace(struct.pack("<4I", 2, 7, 9, 2), struct.pack("<4I", 2, 7, 16, 2))
    is_old = h5py.version.hdf5_version_tuple < (1, 14)  # Later versions refuse the chunk themselves.
    refuse("hdf5-lzf-wide", write("wide.h5", wide), "bytes that its shape requires" if is_old else "cannot be read")
    with h5py.File(folder / "scale.h5", "w") as file:
        file["v"] = volume
        scale = file.create_dataset("z", data=numpy.arange(6.0), chunks=(6,), compression="gzip")
        scale.make_scale()
        file["v"].dims[0].attach_scale(scale)
        scale.id.write_direct_chunk((0,), zlib.compress(bytes(16)))
    refuse("hdf5-short-dimension", str(folder / "scale.h5") + ":/v", "bytes that its shape requires")
    with h5py.File(folder / "block.h5", "w", userblock_size=512) as file:
        file["v"] = volume.astype("f2")
    read("hdf5-user-block", folder / "block.h5", volume)
    whole = (folder / "lzf.h5").read_bytes()
    refuse("hdf5-cut-off", write("cut.h5", whole[:len(whole) // 2]), "libhdf5 cannot open it: truncated")

    # External storage.
    write("raw/inside.raw", volume.tobytes())
    write("outside.raw", volume.tobytes())
    write("raw/short.raw", volume.tobytes()[:-2])
    os.mkfifo(folder / "raw/pipe.raw")
    for name, data, sentence in (("inside", "inside.raw", None), ("outside", "../outside.raw", "--follow"),
                                 ("absolute", str(folder / "outside.raw"), "--follow"),
                                 ("short", "short.raw", "fewer bytes than required"),
                                 ("gone", "gone.raw", "is missing"), ("pipe", "pipe.raw", "not a regular file")):
        with h5py.File(folder / f"raw/{name}.h5", "w") as file:
            creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            creation.set_external(data.encode(), 0, volume.nbytes)
            h5py.h5d.create(file.id, b"v", h5py.h5t.STD_I16LE, h5py.h5s.create_simple(SHAPE), creation)
        path = folder / f"raw/{name}.h5"
        if sentence:
            refuse(f"hdf5-external-{name}", path, sentence)
        if not sentence or sentence == "--follow":
            read(f"hdf5-external-{name}-followed", path, volume, options="follow" if sentence else "")

    # Virtual datasets.
    for name in ("virtual/own.h5", "far.h5"):
        (folder / name).parent.mkdir(exist_ok=True)
        with h5py.File(folder / name, "w") as file:
            file["v"] = volume
    for name, source, dataset, sentence in (("inside", "own.h5", "v", None), ("outside", "../far.h5", "v", "--follow"),
                                            ("gone", "nothing.h5", "v", "is missing"), ("no-dataset", "own.h5", "w", "is missing")):
        layout = h5py.VirtualLayout(shape=SHAPE, dtype="i2")
        layout[:] = h5py.VirtualSource(source, dataset, shape=SHAPE, dtype="i2")
        path = folder / f"virtual/{name}.h5"
        with h5py.File(path, "w", libver="latest") as file:
            file.create_virtual_dataset("v", layout)
        if sentence:
            refuse(f"hdf5-virtual-{name}", path, sentence)
        if not sentence or sentence == "--follow":
            read(f"hdf5-virtual-{name}-followed", path, volume, options="follow" if sentence else "")

    # Sources with short chunks: the one of the last slices, and not read; slices of a stack, one of them short.
    with h5py.File(folder / "virtual/short.h5", "w") as file:
        dataset = file.create_dataset("v", data=volume, chunks=(2, 4, 9), compression="gzip")
        dataset.id.write_direct_chunk((4, 4, 0), zlib.compress(short))
        for i in range(6):
            dataset = file.create_dataset(f"slice{i}", data=volume[i], chunks=(4, 9), compression="gzip")
        dataset.id.write_direct_chunk((4, 0), zlib.compress(short))
    for name, slices, is_stack in (("short", 6, False), ("part", 4, False), ("short-slice", 6, True), ("slices", 5, True)):
        layout = h5py.VirtualLayout(shape=(slices, *SHAPE[1:]), dtype="i2")
        for i in range(slices if is_stack else 0):
            layout[i] = h5py.VirtualSource("short.h5", f"slice{i}", shape=SHAPE[1:], dtype="i2")
        if not is_stack:
            layout[:] = h5py.VirtualSource("short.h5", "v", shape=SHAPE, dtype="i2")[:slices]
        path = folder / f"virtual/of-{name}.h5"
        with h5py.File(path, "w", libver="latest") as file:
            file.create_virtual_dataset("v", layout)
        if slices == 6:
            refuse(f"hdf5-virtual-{name}", path, "bytes that its shape requires")
        else:
            read(f"hdf5-virtual-{name}", path, volume[:slices])

    # External links.
    for name, target, sentence in (("near", "own.h5", None), ("out", "../far.h5", "--follow")):
        with h5py.File(folder / f"virtual/link-{name}.h5", "w") as file:
            file["v"] = h5py.ExternalLink(target, "/v")
        path = f"{folder}/virtual/link-{name}.h5:/v"
        if sentence:
            refuse(f"hdf5-link-{name}", path, sentence)
        read(f"hdf5-link-{name}-followed", path, volume, options="follow" if sentence else "")

    with h5py.File(folder / "virtual/link-pipe.h5", "w") as file:
        file["DataSet"] = h5py.ExternalLink("../raw/pipe.raw", "/")
        file["v"] = volume
    read("hdf5-link-pipe", folder / "virtual/link-pipe.h5", volume)

    # Imaris: padded datasets, extents in attributes of single characters.
    def text(group, **attributes):
        for key, value in attributes.items():
            group.attrs[key] = numpy.frombuffer(str(value).encode(), "S1")

    with h5py.File(folder / "v.ims", "w") as file:
        text(file.create_group("DataSetInfo/Image"), ExtMin0=10, ExtMin1=-20, ExtMin2=30, ExtMax0=14.5, ExtMax1=-14.75,
             ExtMax2=42, Unit="um", X=9, Y=7, Z=6)
        for level, time, channel in ((0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (1, 0, 0)):
            group = file.create_group(f"DataSet/ResolutionLevel {level}/TimePoint {time}/Channel {channel}")
            text(group, ImageSizeX=9, ImageSizeY=7, ImageSizeZ=6)
            data = numpy.zeros((8, 8, 16), "<i2")
            data[:6, :7, :9] = volume if (level, time, channel) == (0, 1, 1) else 1
            group.create_dataset("Data", data=data, chunks=(4, 8, 8), compression="gzip")
            group["Histogram"] = numpy.zeros(256, "<u8")
    place = {"origin": (10.25, -19.625, 31), "steps": diagonal(0.5, 0.75, 2), "unit": "µm"}
    read("imaris", folder / "v.ims", volume, options="time=1,channel=1", **place)
    read("imaris-path", f"{folder}/v.ims:/DataSet/ResolutionLevel 0/TimePoint 1/Channel 1/Data", volume, **place)
    refuse("imaris-channel", folder / "v.ims", "--channel", options="time=1")


mgh()
npy()
netcdf3()
small_ones()
pvti()
n5()
zarrs()
run_with_packages(dicom, zarr_lz4, hdf5)
