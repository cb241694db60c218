"""Volumes as other programs write them, and others that no reader should take: odd DICOM series and formats that are rare.

    python3 write_odd_volumes.py FOLDER

Prints a line for each, with tabs in between. What is to be read: "read", a name, a path, options of VolumeChoice, a file of
the expected samples (f32, x fastest), the counts, the first sample's place and the three steps in the world, the unit, and a
part of the notice (or nothing). What is to be refused: "refuse", a name, a path, options, and a part of the sentence.
"""
import base64
import gzip
import json
import os
import pathlib
import struct
import sys
import zipfile
import zlib

import numpy

folder = pathlib.Path(sys.argv[1])
SHAPE = (6, 7, 9)  # z, y, x
z, y, x = numpy.meshgrid(*(numpy.arange(n) for n in SHAPE), indexing="ij")
volume = (90 * z + 10 * y + 7 * x + (x * y * z) % 5 - 100).astype("<i2")


def write(name, data):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def read(name, path, samples, origin=(0, 0, 0), steps=((1, 0, 0), (0, 1, 0), (0, 0, 1)), unit="", notice="", options=""):
    expected = write(f"expected/{name}", numpy.ascontiguousarray(samples).astype("<f4").tobytes())
    numbers = [*samples.shape[::-1], *origin, *(n for step in steps for n in step)]
    print("read", name, path, options, expected, *numbers, unit, notice, sep="\t")


def refuse(name, path, sentence, options=""):
    print("refuse", name, path, options, sentence, sep="\t")


def diagonal(sx, sy, sz):
    return ((sx, 0, 0), (0, sy, 0), (0, 0, sz))


# ---- DICOM

def dicom():
    import pydicom
    from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
    from pydicom.sequence import Sequence
    LITTLE = pydicom.uid.ExplicitVRLittleEndian

    def image(number, kind="1.2.840.10008.5.1.4.1.1.2", syntax=LITTLE):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = kind
        meta.MediaStorageSOPInstanceUID = f"1.2.3.{number}"
        meta.TransferSyntaxUID = syntax
        data = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
        data.is_little_endian, data.is_implicit_VR = True, False
        data.SOPClassUID, data.SOPInstanceUID = kind, meta.MediaStorageSOPInstanceUID
        data.SeriesInstanceUID, data.StudyInstanceUID, data.PatientID = "1.2.3.100", "1.2.3.200", "one"
        data.Modality, data.InstanceNumber = "CT", number
        data.Rows, data.Columns = SHAPE[1], SHAPE[2]
        data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
        data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 1
        return data

    def save(data, *path):
        path = folder.joinpath(*path)
        path.parent.mkdir(parents=True, exist_ok=True)
        data.save_as(path, write_like_original=False)
        return path

    def items(**elements):
        item = Dataset()
        for key, value in elements.items():
            setattr(item, key, value)
        return Sequence([item])

    # Enhanced CT: `order` gives the slice of each frame.
    def enhanced(name, order, slopes=None, places=None):
        data = image(1, "1.2.840.10008.5.1.4.1.1.2.1")
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
        data.PerFrameFunctionalGroupsSequence = Sequence(frames)
        data.PixelData = volume[order].tobytes()
        return save(data, f"{name}.dcm")

    place = {"origin": (10, -20, 30), "steps": diagonal(0.5, 0.75, 2), "unit": "mm"}
    whole = list(range(SHAPE[0]))
    read("enhanced-descending", enhanced("descending", whole[::-1]), volume, **place)
    shuffled = [3, 0, 5, 1, 4, 2]
    read("enhanced-shuffled", enhanced("shuffled", shuffled), volume, **place)
    slopes = [(1 + 0.5 * i, -10 * i) for i in whole]
    values = numpy.stack([volume[i] * slopes[i][0] + slopes[i][1] for i in whole])
    read("enhanced-slopes", enhanced("slopes", shuffled, slopes), values, **place)
    refuse("enhanced-gap", enhanced("gap", [0, 1, 2, 4, 5]), "1 seem to be missing")
    filled = volume.astype("f4").copy()
    filled[3] = (filled[2] + filled[4]) / 2
    read("enhanced-gap-resampled", enhanced("gap", [0, 1, 2, 4, 5]), filled, options="resample",
         notice="interpolated to 6 slices", **place)

    # One image a file.
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
    # A tilt of half a row a slice: rows lie between two of the new grid's.
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
    read("dicom-localizer", folder / "localizer", volume, notice="that are localizers are left out: 'scout.dcm'", **place)
    del other.ImageType
    slices("second-shape", even)
    save(other, "second-shape", "scout.dcm")
    read("dicom-second-shape", folder / "second-shape", volume, notice="another size, type or orientation", **place)

    def stranger(i, data):
        if i == 4:
            data.PatientID, data.StudyInstanceUID = "two", "1.2.3.201"

    read("dicom-stranger", slices("stranger", even, stranger), volume, notice="of another patient or study", **place)

    # Cut off.
    def cut(name, size, which=3, **more):
        slices(name, even, **more)
        path = folder / name / f"slice{which}.dcm"
        data = path.read_bytes()
        path.write_bytes(data[:size] if size >= 0 else data[:len(data) + size])
        return folder / name

    refuse("dicom-cut-off", cut("cut", -20), "cut off")
    refuse("dicom-cut-in-header", cut("cut-header", 400), "damaged")
    refuse("dicom-cut-before-header", cut("cut-all", 60, which=5), "no DICOM file or is cut off")

    def short(i, data):
        if i == 2:
            data.PixelData = data.PixelData[:100]

    refuse("dicom-short-pixels", slices("short", even, short), "its rows, columns, frames and bits need 126")
    refuse("dicom-rle-cut-off", cut("cut-rle", -30, pack=pydicom.uid.RLELossless), "cut off")

    def short_rle(i, data):
        if i == 2:
            from pydicom.encaps import encapsulate
            packed = bytes(data.PixelData)
            data.file_meta.TransferSyntaxUID = pydicom.uid.RLELossless
            head = struct.pack("<16I", 2, 64, 100, *[0] * 13)
            data.PixelData = encapsulate([head + bytes([0x80] * 60)])
            data["PixelData"].is_undefined_length = True
            del packed

    refuse("dicom-rle-short", slices("short-rle", even, short_rle), "a packed frame ends too early")

    def short_jpeg(i, data):
        if i == 2:
            from pydicom.encaps import encapsulate
            data.file_meta.TransferSyntaxUID = pydicom.uid.JPEGLosslessSV1
            data.PixelData = encapsulate([b"\xff\xd8\xff\xc3" + bytes(100)])
            data["PixelData"].is_undefined_length = True

    refuse("dicom-jpeg-short", slices("short-jpeg", even, short_jpeg), "a packed frame ends too early")
    refuse("dicom-deflated-cut-off", cut("cut-deflated", -30, syntax=pydicom.uid.DeflatedExplicitVRLittleEndian), "too early")


for writer in (dicom,):
    try:
        writer()
    except ImportError as problem:
        print("missing", problem.name, sep="\t")
