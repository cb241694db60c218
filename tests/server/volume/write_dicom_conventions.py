"""Writes DICOM files that follow the conventions of one modality, manufacturer or program; see write_odd_volumes.py for what it prints.

    python3 write_dicom_conventions.py FOLDER
"""
import io
import shutil
import struct
import subprocess

import numpy

from volume_writing import (diagonal, dicom_image, dicom_items as items, dicom_save as save, expect_read as read,
                            expect_refused as refuse, folder, run_with_packages, write)

SHAPE = (5, 6, 8)  # z, y, x
volume = numpy.arange(240, dtype="<i2").reshape(SHAPE)
PLACE = {"origin": (10, 20, 30), "steps": diagonal(0.5, 1.5, 2), "unit": "mm"}


def image(number, rows=SHAPE[1], columns=SHAPE[2], **more):
    return dicom_image(number, rows, columns, **more)


def one_file(name, change, kind="1.2.840.10008.5.1.4.1.1.2", pixels=volume):
    data = image(1, kind=kind)
    data.NumberOfFrames = len(pixels)
    data.PixelSpacing = [1.5, 0.5]
    data.PixelData = pixels.tobytes()
    change(data)
    return save(data, f"{name}.dcm")


def slices(name, change=None, syntax="1.2.840.10008.1.2.1", pixels=volume):
    for i in range(SHAPE[0]):
        data = image(i + 1, syntax=syntax)
        data.PixelSpacing, data.SliceThickness = [1.5, 0.5], 2
        data.ImagePositionPatient, data.ImageOrientationPatient = [10, 20, 30 + 2 * i], [1, 0, 0, 0, 1, 0]
        data.PixelData = pixels[i].tobytes()
        if change:
            change(i, data)
        save(data, name, f"slice{i}.dcm")
    return folder / name


def moments():
    """Several images at each position: what tells them apart is not their numbers and files."""
    def series(name, count, change, places=lambda i, t: 30 + 2 * i):
        for t in range(count):
            for i in range(SHAPE[0]):
                data = image(i + 1)
                data.PixelSpacing, data.SliceThickness = [1.5, 0.5], 2
                data.ImagePositionPatient, data.ImageOrientationPatient = [10, 20, places(i, t)], [1, 0, 0, 0, 1, 0]
                data.PixelData = (volume[i] + 1000 * t).tobytes()
                data.SOPInstanceUID = data.file_meta.MediaStorageSOPInstanceUID = f"1.2.3.{t}.{i}"
                if change(i, t, data) != "none":  # Names in no order, where something else says the time.
                    save(data, name, f"{t if name == 'moments-none' else (7 * i + 3 * t) % 11:02}-{i}-{t}.dcm")
        return folder / name

    def acquisitions(i, t, data):
        data.AcquisitionNumber = t + 1

    def identified(i, t, data):
        data.TemporalPositionIdentifier, data.InstanceNumber = t + 1, (1 - t if i == 2 else t) * SHAPE[0] + i + 1

    def echoes(i, t, data):
        data.EchoTime, data.InstanceNumber = [10, 20][t], (1 - t) * SHAPE[0] + i + 1

    def incomplete(i, t, data):
        data.AcquisitionNumber = 2 - t
        return "none" if t == 1 and i == 3 else ""

    for name, change in (("restarted", acquisitions), ("identified", identified)):
        path = series(f"moments-{name}", 2, change)
        for t in range(2):
            read(f"moments-{name}-{t}", path, volume + 1000 * t, options=f"time={t}", **PLACE)
    read("moments-none", series("moments-none", 2, lambda i, t, data: ""), volume, options="time=0", **PLACE, notice="no number or time tells '")
    # In the order of their numbers.
    read("moments-echoes", series("moments-echoes", 2, echoes), volume + 1000, options="time=0", **PLACE)
    read("moments-incomplete", series("moments-incomplete", 2, incomplete), volume, notice="skipped slices at duplicate positions", **PLACE)
    between = series("moments-between", 2, acquisitions, lambda i, t: 30 + 2 * i + t)
    both = numpy.stack([volume, volume + 1000], axis=1).reshape(10, *SHAPE[1:])
    read("moments-between", between, both, notice="its slices alternate between 2 values of AcquisitionNumber",
         **{**PLACE, "steps": diagonal(0.5, 1.5, 1)})

    # An enhanced file whose frames alternate, the later time first.
    def enhanced(data, content=lambda i, t: items(TemporalPositionIndex=t + 1)):
        frames = []
        for i in range(SHAPE[0]):
            for t in (1, 0):
                frames.append(items(PlanePositionSequence=items(ImagePositionPatient=[10, 20, 30 + 2 * i]),
                                    FrameContentSequence=content(i, t))[0])
        from pydicom.sequence import Sequence
        data.SharedFunctionalGroupsSequence = items(PixelMeasuresSequence=items(PixelSpacing=[1.5, 0.5], SliceThickness=2),
                                                    PlaneOrientationSequence=items(ImageOrientationPatient=[1, 0, 0, 0, 1, 0]))
        data.PerFrameFunctionalGroupsSequence = Sequence(frames)

    pixels = numpy.stack([volume + 1000, volume], axis=1).reshape(10, *SHAPE[1:])
    path = one_file("moments-enhanced", enhanced, kind="1.2.840.10008.5.1.4.1.1.2.1", pixels=pixels)
    read("moments-enhanced", path, volume, options="time=0", **PLACE)
    def by_dimension(i, t):  # As of diffusion: stack, b-value, slice.
        return items(DimensionIndexValues=[1, t + 1, i + 1])
    path = one_file("moments-dimension", lambda data: enhanced(data, by_dimension), kind="1.2.840.10008.5.1.4.1.1.2.1", pixels=pixels)
    read("moments-dimension", path, volume, options="time=0", **PLACE)


def spacing():
    def table(_, data):
        data.ModalityLUTSequence = items(LUTDescriptor=[240, 0, 16], ModalityLUTType="HU", LUTData=bytes(480))
    read("value-table", slices("table", table), volume, notice="a table (ModalityLUTSequence), which is not read", **PLACE)
    def padded(_, data):
        data.PixelPaddingValue = 50
    read("padding", slices("padded", padded), volume, notice="stored number is 50 are padding", **PLACE)
    read("no-rescale", slices("no-rescale"), volume, notice="states no scaling; its numbers are read as HU", **PLACE)
    # Nuclear medicine: the sign of the spacing tells on which side of the first slice the others lie.
    def nuclear(step, **more):
        def change(data):
            data.Modality, data.SpacingBetweenSlices, data.SliceThickness = "NM", step, 2
            data.ImageType = ["ORIGINAL", "PRIMARY", "RECON TOMO", "EMISSION"]
            data.DetectorInformationSequence = items(ImagePositionPatient=[10, 20, 30], ImageOrientationPatient=[1, 0, 0, 0, 1, 0])
            for key, value in more.items():
                setattr(data, key, value)
        return change

    kind = "1.2.840.10008.5.1.4.1.1.20"
    read("nm-up", one_file("nm-up", nuclear(2), kind), volume, **PLACE)
    down = {**PLACE, "origin": (10, 20, 22)}
    read("nm-down", one_file("nm-down", nuclear(-2), kind), volume[::-1], **down)
    read("nm-slice-vector", one_file("nm-vector", nuclear(-2, SliceVector=[5, 1, 4, 2, 3]), kind),
         volume[[0, 2, 4, 3, 1]], **{**PLACE, "origin": (10, 20, 30)})
    views = one_file("nm-views", nuclear(2, ImageType=["ORIGINAL", "PRIMARY", "TOMO", "EMISSION"]), kind)
    read("nm-projections", views, volume, notice="not reconstructed", **PLACE)

    # Frames without positions.
    def frames(**more):
        def change(data):
            data.ImagePositionPatient, data.ImageOrientationPatient = [10, 20, 30], [1, 0, 0, 0, 1, 0]
            for key, value in more.items():
                setattr(data, key, value)
        return change

    read("frames-spacing", one_file("frames-spacing", frames(SpacingBetweenSlices=2, SliceThickness=3)), volume,
         notice="2 mm apart (SpacingBetweenSlices)", **PLACE)
    read("frames-thickness", one_file("frames-thickness", frames(SliceThickness=2)), volume,
         notice="2 mm apart (SliceThickness)", **PLACE)
    unknown = {**PLACE, "steps": diagonal(0.5, 1.5, 1)}
    read("frames-unknown", one_file("frames-unknown", frames(SliceThickness=0)), volume, notice="states no spacing along z", **unknown)

    def unplaced(thickness):
        def change(i, data):
            del data.ImagePositionPatient, data.ImageOrientationPatient
            data.SliceThickness = thickness
        return change

    at_0 = {**PLACE, "origin": (0, 0, 0)}
    read("slices-thickness", slices("unplaced", unplaced(2)), volume, notice="2 mm apart (SliceThickness)", **at_0)
    read("slices-unknown", slices("unplaced-unknown", unplaced(None)), volume, notice="states no spacing along z",
         **{**unknown, "origin": (0, 0, 0)})

    def plane(**more):
        def change(_, data):
            del data.PixelSpacing
            for key, value in more.items():
                setattr(data, key, value)
        return change

    read("imager-spacing", slices("imager", plane(ImagerPixelSpacing=[1.5, 0.5])), volume, notice="at the detector", **PLACE)
    read("scanned-spacing", slices("scanned", plane(NominalScannedPixelSpacing=[1.5, 0.5])), volume, notice="scanned film", **PLACE)
    zero = slices("zero", plane(PixelSpacing=[0, 0]))
    read("pixel-spacing-zero", zero, volume, notice="states no spacing along x and y", **{**PLACE, "steps": diagonal(1, 1, 2)})
    read("pixel-spacing-given", zero, volume, options="spacing=0.5:1.5:2", **PLACE)

    def uneven(i, data):
        data.ImagePositionPatient = [10, 20, 30 + (0, 2, 3, 6, 8)[i]]

    refuse("uneven", slices("uneven", uneven), "Get all slices", remedy="resample")
    read("uneven-given", slices("uneven", uneven), volume, options="spacing=0.5:1.5:2", **PLACE)


def bits():
    """Samples of 12 of 16 bits, the lowest or others; the rest holds whatever its writer left there."""
    signed = (volume * 16 - 2000).astype("<i2")
    packed = signed.view("<u2") & 0xFFF

    def stored(high, is_signed, samples):
        def change(i, data):
            data.BitsStored, data.HighBit, data.PixelRepresentation = 12, high, is_signed
            data.PixelData = samples[i].astype("<u2").tobytes()
        return change

    for name, high, samples in (("lowest", 11, packed), ("highest", 15, packed << 4 | 5), ("middle", 13, packed << 2 | 0x8001)):
        read(f"bits-{name}", slices(f"bits-{name}", stored(high, 1, samples)), signed, **PLACE)
        read(f"bits-{name}-unsigned", slices(f"bits-{name}-u", stored(high, 0, samples)), packed, **PLACE)

    # Later versions of GDCM refuse runs that are much longer than the pixels, so the low byte is constant.
    def run_lengths(i, data):
        stored(15, 1, (packed & 0xF00) << 4 | 5)(i, data)
        data.compress("1.2.840.10008.1.2.5")
    read("bits-rle", slices("bits-rle", run_lengths), signed & ~0xFF, **PLACE)

    def seven(_, data):
        data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 8, 7, 6, 0
    low = (volume % 128).astype("u1")
    read("bits-seven", slices("bits-seven", seven, pixels=low), low, **PLACE)

    # The highest bits hold an overlay.
    def overlaid(i, data):
        stored(11, 0, packed | 0x1000)(i, data)
        for element, kind, value in ((0x10, "US", 6), (0x11, "US", 8), (0x40, "CS", "G"), (0x50, "SS", [1, 1]), (0x100, "US", 16), (0x102, "US", 12)):
            data.add_new(0x60000000 + element, kind, value)
    read("bits-overlay", slices("bits-overlay", overlaid), packed, **PLACE)

    # Curves and icons, on some of which GDCM aborts.
    def curved(i, data):
        stored(11, 0, packed)(i, data)
        for element, kind, value in ((5, "US", 2), (0x10, "US", 3), (0x20, "CS", "TAC"), (0x103, "US", 3), (0x1001, "LO", "odd"), (0x3000, "OW", bytes(48))):
            data.add_new(0x50000000 + element, kind, value)
        data.compress("1.2.840.10008.1.2.5")
    read("bits-curve", slices("bits-curve", curved), packed, **PLACE)

    def adorned(i, data):
        stored(11, 0, packed)(i, data)
        data.IconImageSequence = items(
            Rows=4, Columns=4, SamplesPerPixel=1, BitsAllocated=8, BitsStored=8, HighBit=7, PixelRepresentation=0, PixelData=bytes(16),
            PhotometricInterpretation="PALETTE COLOR", RedPaletteColorLookupTableDescriptor=[256, 0, 16],
            RedPaletteColorLookupTableData=bytes(10))
        data.compress("1.2.840.10008.1.2.5")
    read("bits-icon", slices("bits-icon", adorned), packed, **PLACE)

    def dense(_, data):
        data.BitsAllocated, data.BitsStored, data.HighBit = 12, 12, 11
    refuse("bits-dense", slices("bits-dense", dense), "in 12 bits")

    def big(i, data):
        data.file_meta.TransferSyntaxUID, data.is_little_endian = "1.2.840.10008.1.2.2", False
        data.BitsAllocated, data.BitsStored, data.HighBit = 32, 32, 31
        data.PixelData = volume[i].astype(">i4").tobytes()
    refuse("bits-big", slices("bits-big", big), "pixels of 32 bits are big-endian")

    def without(name, value=None):
        def change(_, data):
            data["PixelData"].VR = "OW"
            delattr(data, name) if value is None else setattr(data, name, value)
        return slices(f"without-{name}", change)
    refuse("bits-unknown", without("BitsAllocated"), "does not state the bits")
    refuse("bits-pairs", without("SamplesPerPixel", 2), "have 2 samples")
    read("bits-sign", without("PixelRepresentation"), volume, notice="does not state whether its integers have a sign", **PLACE)


def values():
    """Slope and intercept of all storage classes, private ones, too."""
    def scaled(slope, intercept):
        def change(i, data):
            data.RescaleSlope, data.RescaleIntercept = slope, intercept
        return change
    storage = "1.2.840.10008.5.1.4.1.1."
    for name, kind in (("mr", storage + "4"), ("us", storage + "6.1"), ("xa", storage + "12.1"), ("dx", storage + "1.1.1"),
                       ("rt", storage + "481.1"), ("sc", storage + "7"), ("private", "1.2.840.113619.4.30")):
        def change(i, data):
            scaled(2 + i, -100)(i, data)
            data.SOPClassUID = data.file_meta.MediaStorageSOPClassUID = kind
            data.compress("1.2.840.10008.1.2.5")
        expected = numpy.stack([volume[i] * (2 + i) - 100 for i in range(5)])
        read(f"rescale-{name}", slices(f"rescale-{name}", change), expected, **PLACE)
    read("rescale-zero", slices("rescale-zero", scaled(0, -100)), volume, notice="states no scaling", **PLACE)
    read("rescale-intercept", slices("rescale-intercept", scaled(None, -100)), volume - 100, notice="!states no scaling", **PLACE)

    def mapped(_, data):
        data.RealWorldValueMappingSequence = items(RealWorldValueIntercept=1.0, RealWorldValueSlope=3.0)
    read("mapping", slices("mapping", mapped), volume, notice="RealWorldValueMappingSequence), which is not applied", **PLACE)

    def padded(_, data):
        data.add_new(0x00280120, "SS", -5)
        data.add_new(0x00280121, "SS", 3)
    read("padding-range", slices("padding-range", padded), volume, notice="number is -5 to 3 are padding", **PLACE)


def places():
    def odd(_, data):
        data.add_new(0x00280030, "SH", "1.5")  # Of a wrong type.
    read("spacing-odd", slices("spacing-odd", odd), volume, notice="no spacing along x and y", **{**PLACE, "steps": diagonal(1, 1, 2)})

    def unplaced(i, data):
        if i == 4:
            del data.ImagePositionPatient
    read("position-missing", slices("position-missing", unplaced), volume[:4], notice="1 image without a position is skipped", **PLACE)

    def unturned(_, data):
        del data.ImageOrientationPatient
    read("orientation-missing", slices("orientation-missing", unturned), volume, notice="state no orientation", **PLACE)
    read("orientation-stated", slices("orientation-stated"), volume, notice="!state no orientation", **PLACE)

    def tiles(data):
        data.TotalPixelMatrixColumns, data.TotalPixelMatrixRows = 16, 18
    slide = one_file("tiles", tiles, "1.2.840.10008.5.1.4.1.1.77.1.6")
    refuse("tiles", slide, "tiles of one larger image")

    # What cannot be read of a folder matters only where it is of the series to be read.
    def other_series(data):
        data.SeriesInstanceUID, data.Modality = "1.2.3.300", "SM"
    def slide_of_it(data):
        tiles(data)
        other_series(data)
    folders = {"tiles": lambda: one_file("beside-tiles/slide", slide_of_it), "bits": lambda: one_file("beside-bits/odd", lambda data: (
        other_series(data), setattr(data, "BitsAllocated", 0))), "end": lambda: one_file("beside-end/end", other_series)}
    for name, write_other in folders.items():
        path = slices(f"beside-{name}")
        other = write_other()
        if name == "end":
            other.write_bytes(other.read_bytes()[:-100])
        listed = "it has 2 series: 1: 1.2.3.100 (CT, 5 images of 8 x 6); 2: 1.2.3.300 (SM, 1 image of 8 x 6, cannot be read)"
        refuse(f"beside-{name}", path, listed, remedy="series=1")
        for chosen in ("1", "1.2.3.100"):
            read(f"beside-{name}-{chosen}", path, volume, options=f"series={chosen}", **PLACE)
        refuse(f"beside-{name}-odd", path, {"tiles": "tiles of one larger image", "bits": "does not state the bits",
                                            "end": "its pixel data are truncated"}[name], options="series=2")

    # Facts of some slices, of which the first file is not the lowest.
    def descending(i, data):
        data.ImagePositionPatient = [10, 20, 38 - 2 * i]
        if i == 2:
            del data.ImageOrientationPatient
    read("orientation-of-one-missing", slices("orientation-of-one", descending), volume[::-1], notice="state no orientation", **PLACE)
    def half_scaled(i, data):
        if i < 3:
            data.RescaleSlope, data.RescaleIntercept = 2, 0
    read("rescale-of-some", slices("rescale-of-some", half_scaled), numpy.concatenate([2 * volume[:3], volume[3:]]),
         notice="states no scaling", **PLACE)


def colors():
    pixels = numpy.stack([volume % 256, volume * 3 % 256, 255 - volume % 256], -1).astype("u1")
    coarse = pixels // 64 * 64  # Gets shorter by compression.
    def colored(kind, planes, syntax=None, pixels=pixels):
        def change(i, data):
            data.SamplesPerPixel, data.PlanarConfiguration, data.PhotometricInterpretation = 3, planes, kind
            data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 8, 8, 7, 0
            data.PixelData = (pixels[i].transpose(2, 0, 1) if planes else pixels[i]).tobytes()
            if syntax:
                data.compress(syntax)
        return change
    for name, change, expected in (
            ("pixels", colored("RGB", 0), pixels), ("planes", colored("RGB", 1), pixels),
            ("planes-rle", colored("RGB", 1, "1.2.840.10008.1.2.5", coarse), coarse)):
        read(f"color-{name}", slices(f"color-{name}", change), expected[..., 1], options="component=1", **PLACE)
    read("color-ybr", slices("color-ybr", colored("YBR_FULL", 0)), pixels[..., 1], options="component=1", notice="two color differences", **PLACE)


def ultrasound():
    def region(dx, dy, spatial=1, unit=3):
        return items(RegionSpatialFormat=spatial, RegionDataType=1, PhysicalUnitsXDirection=unit, PhysicalUnitsYDirection=unit,
                     PhysicalDeltaX=dx, PhysicalDeltaY=dy)[0]

    def frames(*regions, **more):
        def change(data):
            from pydicom.sequence import Sequence
            data.Modality, data.SliceThickness = "US", 2
            del data.PixelSpacing
            data.SequenceOfUltrasoundRegions = Sequence(regions)
            for key, value in more.items():
                setattr(data, key, value)
        return change

    kind = "1.2.840.10008.5.1.4.1.1.3.1"
    place = {"steps": diagonal(0.5, 1.5, 2), "unit": "mm"}
    plane, motion = region(0.05, -0.15), region(0.2, 0.01, spatial=2, unit=4)
    read("us-region", one_file("us", frames(plane, motion, plane), kind), volume, notice="!states no spacing", **place)
    read("us-cine", one_file("us-cine", frames(plane, FrameTime=40), kind), volume, notice="follow each other in time", **place)
    unknown = {**place, "steps": diagonal(1, 1, 2)}
    read("us-two", one_file("us-two", frames(plane, region(0.1, 0.1)), kind), volume, notice="several distances", **unknown)
    read("us-motion", one_file("us-motion", frames(motion), kind), volume, notice="no distances in a plane", **unknown)
    # Frames with places in a space of the volume, which is not that of a patient.
    def enhanced(data):
        from pydicom.sequence import Sequence
        data.Modality, data.UltrasoundAcquisitionGeometry = "US", "APEX"
        del data.PixelSpacing
        data.SharedFunctionalGroupsSequence = items(
            PixelMeasuresSequence=items(PixelSpacing=[1.5, 0.5], SliceThickness=9),
            PlaneOrientationVolumeSequence=items(ImageOrientationVolume=[0.0, 1.0, 0.0, 0.0, 0.0, 1.0]))
        data.PerFrameFunctionalGroupsSequence = Sequence(
            items(PlanePositionVolumeSequence=items(ImagePositionVolume=[10.0 + 2 * i, 20.0, 30.0]))[0] for i in range(5))
    read("us-enhanced", one_file("us-enhanced", enhanced, "1.2.840.10008.5.1.4.1.1.6.2"), volume, origin=(10, 20, 30),
         steps=((0, 0.5, 0), (0, 0, 1.5), (2, 0, 0)), unit="mm", notice="!no positions")
    read("us-both", one_file("us-both", frames(region(0.1, 0.1), PixelSpacing=[1.5, 0.5]), kind), volume, notice="than PixelSpacing", **place)


def mosaics():
    # Five slices as tiles of 3 x 3, the position being that of a mosaic with their common center.
    tiles = numpy.zeros((3 * 6, 3 * 8), "<i2")
    for i in range(5):
        tiles[i // 3 * 6:i // 3 * 6 + 6, i % 3 * 8:i % 3 * 8 + 8] = volume[i]
    for name, backwards in (("mosaic", False), ("mosaic-backwards", True)):
        data = image(1, *tiles.shape, kind="1.2.840.10008.5.1.4.1.1.4")
        data.Modality, data.ImageType = "MR", ["ORIGINAL", "PRIMARY", "M", "ND", "MOSAIC"]
        data.PixelSpacing, data.SpacingBetweenSlices, data.SliceThickness = [1.5, 0.5], 2, 1.5
        data.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        data.ImagePositionPatient = [10 - 0.5 * (24 - 8) / 2, 20 - 1.5 * (18 - 6) / 2, 30]
        block = data.private_block(0x0019, "SIEMENS MR HEADER", create=True)
        block.add_new(0x0A, "US", 5)
        if backwards:
            block = data.private_block(0x0029, "SIEMENS CSA HEADER", create=True)
            block.add_new(0x10, "OB", csa({"NumberOfImagesInMosaic": ["5"], "SliceNormalVector": ["0", "0", "-1"]}))
        data.PixelData = tiles.tobytes()
        path = save(data, f"{name}.dcm")
        read(name, path, volume[::-1] if backwards else volume, **{**PLACE, "origin": (10, 20, 22 if backwards else 30)})
    del data[0x0019, 0x1000 | 0x0A], data[0x0029, 0x1010]
    refuse("mosaic-unknown", save(data, "mosaic-unknown.dcm"), "does not state how many")


def csa(elements):
    """A CSA header of Siemens, version 2."""
    out = b"SV10\4\3\2\1" + struct.pack("<2I", len(elements), 77)
    for name, values in elements.items():
        out += name.encode().ljust(64, b"\0") + struct.pack("<i4s3i", len(values), b"FD", 3, 6, 77)
        for value in values + [""] * (6 - len(values)):
            length = len(value)
            out += struct.pack("<4i", length, length, 77, length) + value.encode().ljust((length + 3) // 4 * 4, b"\0")
    return out


def without_preamble():
    def strip(path, meta_too):
        data = path.read_bytes()
        begin = 132
        if meta_too:
            begin += 12 + struct.unpack("<I", data[140:144])[0]
        path.write_bytes(data[begin:])

    for name, syntax, meta_too in (("bare", "1.2.840.10008.1.2.1", True), ("bare-implicit", "1.2.840.10008.1.2", True),
                                   ("no-preamble", "1.2.840.10008.1.2.1", False)):
        def implicit(_, data):
            data.is_implicit_VR = syntax == "1.2.840.10008.1.2"
        slices(name, implicit, syntax=syntax)
        for path in (folder / name).iterdir():
            strip(path, meta_too)
        read(name, folder / name, volume, **PLACE)


# ---- segmentations

def segmentation(name, kind, frames, pixels, bits, spacing=2, numbers=(1, 2), sop="1.2.840.10008.5.1.4.1.1.66.4", **more):
    """`frames` has the segment and the slice of each; pixels are packed."""
    from pydicom.dataset import Dataset
    from pydicom.sequence import Sequence
    data = image(1, kind=sop)
    data.Modality, data.SegmentationType = "SEG", kind
    data.NumberOfFrames = len(frames)
    data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = bits, bits, bits - 1, 0
    data.MaximumFractionalValue = 255
    measures = {"PixelSpacing": [1.5, 0.5], "SliceThickness": 2}
    if spacing:
        measures["SpacingBetweenSlices"] = spacing
    data.SharedFunctionalGroupsSequence = items(PixelMeasuresSequence=items(**measures),
                                                PlaneOrientationSequence=items(ImageOrientationPatient=[1, 0, 0, 0, 1, 0]))
    segments = []
    for number in numbers:
        segment = Dataset()
        segment.SegmentNumber, segment.SegmentLabel = number, f"organ {number}"
        segment.RecommendedDisplayCIELabValue = [34922, 53485, 50171]  # Red.
        segments.append(segment)
    data.SegmentSequence = Sequence(segments)
    groups = []
    for segment, slice_ in frames:
        own = {"PlanePositionSequence": items(ImagePositionPatient=[10, 20, 30 + 2 * slice_])}
        if segment:
            own["SegmentIdentificationSequence"] = items(ReferencedSegmentNumber=segment)
        groups.append(items(**own)[0])
    data.PerFrameFunctionalGroupsSequence = Sequence(groups)
    data.PixelData = pixels + b"\0" * (len(pixels) % 2)
    for key, value in more.items():
        setattr(data, key, value)
    return data


def bits_of(frames):
    return numpy.packbits(numpy.concatenate([frame.ravel() for frame in frames]).astype(bool), bitorder="little").tobytes()


def segmentations():
    one = numpy.zeros(SHAPE, "u1")
    one[1:3, 1:4, 2:5] = 1
    two = numpy.zeros(SHAPE, "u1")
    two[0, 2:5, 1:3] = 1
    two[4, 1:3, 3:6] = 1
    frames = [(1, 1), (1, 2), (2, 0), (2, 4)]
    sources = {1: one, 2: two}
    packed = bits_of([sources[s][z] for s, z in frames])
    label = one + 2 * two
    names = "1:organ 1:FF0100:0;2:organ 2:FF0100:0"
    read("seg-binary", save(segmentation("", "BINARY", frames, packed, 1), "seg.dcm"), label, labels=names, **PLACE)
    read("seg-binary-no-spacing", save(segmentation("", "BINARY", frames, packed, 1, spacing=None), "seg2.dcm"), label, labels=names, **PLACE)
    deflated = segmentation("", "BINARY", frames, packed, 1)
    from pydicom.uid import DeflatedExplicitVRLittleEndian
    deflated.file_meta.TransferSyntaxUID = DeflatedExplicitVRLittleEndian
    read("seg-deflated", save(deflated, "seg-deflated.dcm"), label, labels=names, **PLACE)

    # Overlapping segments are in two layers.
    wide = numpy.zeros(SHAPE, "u1")
    wide[0:3, 0:5, 0:6] = 1
    sources = {1: one, 2: two, 3: wide}
    frames = [(1, 1), (1, 2), (2, 0), (2, 4), (3, 0), (3, 1), (3, 2)]
    packed = bits_of([sources[s][z] for s, z in frames])
    path = save(segmentation("", "BINARY", frames, packed, 1, numbers=(1, 2, 3)), "seg-overlap.dcm")
    names = "1:organ 1:FF0100:0;2:organ 2:FF0100:0;3:organ 3:FF0100:1"
    refuse("seg-overlap", path, "3 segments in 2 layers", remedy="component=0")
    read("seg-layer-0", path, label, options="component=0", labels=names, **PLACE)
    read("seg-layer-1", path, 3 * wide, options="component=1", labels=names, **PLACE)

    # Fractional: half of the largest share of each segment.
    shares = numpy.zeros(SHAPE, "u1")
    shares[0:3, 1:3, 1:5] = 200
    shares[0:3, 3, 1:5] = 99
    shares[3:5, 1:3, 1:5] = 100
    shares[3:5, 3, 1:5] = 49
    expected = numpy.zeros(SHAPE)
    expected[0:3, 1:3, 1:5] = 1
    expected[3:5, 1:3, 1:5] = 2
    frames = [(1, 0), (1, 1), (1, 2), (2, 3), (2, 4)]
    data = segmentation("", "FRACTIONAL", frames, shares.tobytes(), 8)
    read("seg-fractional", save(data, "seg-fractional.dcm"), expected, notice="fractional",
         labels="1:organ 1:FF0100:0;2:organ 2:FF0100:0", **PLACE)
    data = segmentation("", "FRACTIONAL", frames, shares.tobytes(), 8)
    data.compress("1.2.840.10008.1.2.5")
    read("seg-fractional-rle", save(data, "seg-rle.dcm"), expected, **PLACE)

    # A label map, of 16 bits; the slices 1 and 3 have no frame.
    labels = numpy.zeros(SHAPE, "<u2")
    labels[0, 1:3], labels[2, 2:4], labels[4, 0:2] = 1, 300, 300
    data = segmentation("", "LABELMAP", [(0, 0), (0, 2), (0, 4)], labels[[0, 2, 4]].tobytes(), 16, numbers=(1, 300),
                        sop="1.2.840.10008.5.1.4.1.1.66.7")
    read("seg-label-map", save(data, "seg-map.dcm"), labels, labels="1:organ 1:FF0100:0;300:organ 300:FF0100:0", **PLACE)

    off = segmentation("", "BINARY", frames, bits_of([one[1]] * 5), 1, spacing=1.4)
    refuse("seg-off-grid", save(off, "seg-off.dcm"), "is not on a grid")


def parametric_maps():
    from pydicom.sequence import Sequence
    from pydicom.dataset import Dataset
    from pydicom.encaps import encapsulate
    for name, element, kind in (("floats", "FloatPixelData", "<f4"), ("doubles", "DoubleFloatPixelData", "<f8")):
        data = image(1, kind="1.2.840.10008.5.1.4.1.1.30")
        data.Modality, data.NumberOfFrames = "MR", 5
        del data.BitsStored, data.HighBit, data.PixelRepresentation
        data.BitsAllocated = 8 * numpy.dtype(kind).itemsize
        unit = Dataset()
        unit.CodeValue = "mm2/s"
        data.SharedFunctionalGroupsSequence = items(
            PixelMeasuresSequence=items(PixelSpacing=[1.5, 0.5], SliceThickness=2),
            PlaneOrientationSequence=items(ImageOrientationPatient=[1, 0, 0, 0, 1, 0]),
            RealWorldValueMappingSequence=items(RealWorldValueIntercept=1.0, RealWorldValueSlope=2.0,
                                                MeasurementUnitsCodeSequence=Sequence([unit])))
        data.PerFrameFunctionalGroupsSequence = Sequence(
            [items(PlanePositionSequence=items(ImagePositionPatient=[10, 20, 30 + 2 * i]))[0] for i in range(5)])
        setattr(data, element, (volume / 8).astype(kind).tobytes())
        read(f"parametric-{name}", save(data, f"map-{name}.dcm"), 1 + volume / 4, **PLACE)
        data.file_meta.TransferSyntaxUID = "1.2.840.10008.1.2.1.99"  # Deflated as a whole.
        read(f"parametric-{name}-deflated", save(data, f"deflated-{name}.dcm"), 1 + volume / 4, **PLACE)
        pixels = data[element].value
        setattr(data, element, pixels[:-80])
        refuse(f"parametric-{name}-short", save(data, f"short-{name}.dcm"), "missing, too short or compressed")
        delattr(data, element)
        refuse(f"parametric-{name}-none", save(data, f"none-{name}.dcm"), "no pixel data")
        data.file_meta.TransferSyntaxUID = "1.2.840.10008.1.2.5"
        setattr(data, element, encapsulate([pixels[i::5] for i in range(5)]))
        data[element].is_undefined_length = True
        refuse(f"parametric-{name}-compressed", save(data, f"compressed-{name}.dcm"), "its floating-point pixels are compressed")


def compressed():
    from PIL import Image
    from pydicom.encaps import encapsulate

    # JPEG streams that fill bytes of FF follow.
    steps = numpy.repeat(numpy.arange(5, dtype="u1") * 40 + 20, 48).reshape(SHAPE)

    def padded(i, data):
        data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 8, 8, 7, 0
        out = io.BytesIO()
        Image.fromarray(steps[i]).save(out, "JPEG", quality=100)
        data.PixelData = encapsulate([out.getvalue() + b"\xff" * (6 + len(out.getvalue()) % 2)])
        data["PixelData"].is_undefined_length = True
        data.LossyImageCompression = "01"

    read("jpeg-padded", slices("jpeg-padded", padded, syntax="1.2.840.10008.1.2.4.50", pixels=steps), steps, **PLACE)

    # JPEG 2000 streams of unsigned numbers, of which PixelRepresentation says that they are signed.
    numbers = (volume * 4 - 500).astype("<i2")

    def unsigned_stream(i, data):
        data.BitsStored, data.HighBit = 13, 12
        out = io.BytesIO()
        Image.fromarray((numbers[i].astype("i4") & 0x1FFF).astype("<u2")).save(out, "JPEG2000", irreversible=False, no_jp2=True)
        stream = bytearray(out.getvalue())
        at = stream.index(b"\xff\x51") + 40  # Ssiz in the segment SIZ.
        assert stream[at] == 15
        data.PixelData = encapsulate([bytes(stream) + b"\0" * (len(stream) % 2)])
        data["PixelData"].is_undefined_length = True

    # Frames in several fragments.
    def fragmented(data):
        data.file_meta.TransferSyntaxUID = "1.2.840.10008.1.2.4.90"
        data.ImagePositionPatient, data.ImageOrientationPatient, data.SliceThickness = [10, 20, 30], [1, 0, 0, 0, 1, 0], 2
        data.PixelRepresentation = 0
        streams = []
        for frame in volume.astype("<u2"):
            out = io.BytesIO()
            Image.fromarray(frame).save(out, "JPEG2000", irreversible=False, no_jp2=True)
            streams.append(out.getvalue() + b"\0" * (len(out.getvalue()) % 2))
        data.PixelData = encapsulate(streams, fragments_per_frame=2)
        data["PixelData"].is_undefined_length = True
    read("j2k-fragments", one_file("j2k-fragments", fragmented), volume, **PLACE)

    # JPEG 2000 streams of 16 bits, of which the header says 32, and of 32 bits, which OpenJPEG refuses.
    def wide(bits):
        def change(i, data):
            data.PixelRepresentation, data.BitsAllocated, data.BitsStored, data.HighBit = 0, 32, bits, bits - 1
            out = io.BytesIO()
            Image.fromarray(volume[i].astype("<u2")).save(out, "JPEG2000", irreversible=False, no_jp2=True)
            stream = bytearray(out.getvalue())
            stream[stream.index(b"\xff\x51") + 40] = bits - 1  # Ssiz in the segment SIZ.
            data.PixelData = encapsulate([bytes(stream) + b"\0" * (len(stream) % 2)])
            data["PixelData"].is_undefined_length = True
        return slices(f"j2k-in-{bits}", change, syntax="1.2.840.10008.1.2.4.90")
    refuse("j2k-of-32", wide(32), "GDCM cannot decompress its pixels. Save it without compression")
    path = wide(16)
    refuse("j2k-of-16-in-32", path, "has 96 bytes, but its header declares 192. Decompress it first, for example with gdcmconv --raw")
    if shutil.which("gdcmconv"):
        (folder / "j2k-by-gdcmconv").mkdir()
        for file in list(path.iterdir()):
            subprocess.run(["gdcmconv", "--raw", file, folder / "j2k-by-gdcmconv" / file.name], check=True)
        read("j2k-by-gdcmconv", folder / "j2k-by-gdcmconv", volume, **PLACE)

    # Uncompressed samples in a fragment, which the standard forbids.
    def in_a_fragment(i, data):
        data.PixelData = encapsulate([volume[i].tobytes()])
    path = slices("raw-fragment", in_a_fragment)
    for file in path.iterdir():
        stored = file.read_bytes()
        at = stored.index(b"\xe0\x7f\x10\x00") + 8
        file.write_bytes(stored[:at] + b"\xff" * 4 + stored[at + 4:] + struct.pack("<HHI", 0xFFFE, 0xE0DD, 0))
    refuse("raw-fragment", path, "its transfer syntax is uncompressed")

    # Deflated as a whole by GDCM, which writes checksum and length of gzip behind the stream.
    from pydicom.uid import DeflatedExplicitVRLittleEndian
    path = slices("deflated", syntax=DeflatedExplicitVRLittleEndian)
    for file in path.iterdir():
        file.write_bytes(file.read_bytes() + b"\x3b\x6e\x01\x20\x66\x01\0\0")
    read("deflated-trailer", path, volume, **PLACE)

    path = slices("j2k-unsigned", unsigned_stream, syntax="1.2.840.10008.1.2.4.90", pixels=numbers)
    read("j2k-unsigned", path, numbers, **PLACE)


run_with_packages(moments, spacing, bits, values, places, colors, ultrasound, mosaics, without_preamble, segmentations, parametric_maps, compressed)
