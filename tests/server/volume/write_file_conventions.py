"""Writes TIFF, MRC, VTK, NRRD, MetaImage files and image stacks that follow the conventions of a program, or state less or more than
usual; see write_odd_volumes.py for what it prints.

    python3 write_file_conventions.py FOLDER
"""
import base64
import gzip
import math
import struct

import numpy

from volume_writing import diagonal, expect_read as read, expect_refused as refuse, folder, run_with_packages, write

SHAPE = (5, 6, 8)  # z, y, x
volume = numpy.arange(240, dtype="<u2").reshape(SHAPE)
second = volume + 1000


# ---- TIFF

def ome_file(name, images, data):
    import tifffile
    text = '<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06">'
    for i, (title, size, blocks) in enumerate(images):
        text += (f'<Image ID="Image:{i}"{title}><Pixels ID="Pixels:{i}" SizeX="8" SizeY="6" SizeZ="5" SizeC="1" SizeT="1" Type="uint16" '
                 f'DimensionOrder="XYZCT" {size}>{blocks}</Pixels></Image>')
    tifffile.imwrite(folder / name, data, description=(text + "</OME>").encode(), metadata=None, photometric="minisblack")
    return folder / name


def tiff():
    import tifffile
    size = 'PhysicalSizeX="0.3" PhysicalSizeY="0.4" PhysicalSizeZ="2"'
    place = {"steps": diagonal(0.3, 0.4, 2), "unit": "µm"}
    both = numpy.concatenate([volume, second])
    images = [("", size, '<TiffData IFD="0" PlaneCount="5"/>'), (' Name="later"', size, '<TiffData IFD="5" PlaneCount="5"/>')]
    path = ome_file("two.ome.tif", images, both)
    read("ome-first", path, volume, notice="of its 2 images", **place)
    for series in ("2", "Image:1", "later"):
        read(f"ome-{series}", path, second, options=f"series={series}", **place)
    refuse("ome-third", path, "it has no image 3", options="series=3", remedy="series=1")
    path = ome_file("follow.ome.tif", [(title, size, "<TiffData/>") for title, size, _ in images], both)
    read("ome-follow", path, second, options="series=2", **place)
    with tifffile.TiffWriter(folder / "types.ome.tif") as out:  # The second image has another size and type.
        for data in (volume, second.astype("<f4")[:3, :4]):
            out.write(data, metadata={"axes": "ZYX"})
    read("ome-other-type", folder / "types.ome.tif", second[:3, :4], options="series=2")
    for name, depth in (("missing", ""), ("zero", 'PhysicalSizeZ="0"'), ("nan", 'PhysicalSizeZ="NaN"')):
        path = ome_file(f"{name}.ome.tif", [("", f'PhysicalSizeX="0.3" PhysicalSizeY="0.4" {depth}', "<TiffData/>")], volume)
        read(f"ome-z-{name}", path, volume, notice="states no spacing along z", steps=diagonal(0.3, 0.4, 1), unit="µm")
        read(f"ome-z-{name}-given", path, volume, options="spacing=0.3:0.4:2", **place)
    mixed = ('PhysicalSizeX="0.3" PhysicalSizeXUnit="µm" PhysicalSizeY="400" PhysicalSizeYUnit="nm" PhysicalSizeZ="0.00002" '
             'PhysicalSizeZUnit="dm"')
    read("ome-units", ome_file("units.ome.tif", [("", mixed, "<TiffData/>")], volume), volume, **place)
    strange = 'PhysicalSizeX="0.3" PhysicalSizeY="0.4" PhysicalSizeZ="2" PhysicalSizeZUnit="reference frame"'
    path = ome_file("strange.ome.tif", [("", strange, "<TiffData/>")], volume)
    read("ome-units-given", path, volume, options="spacing=0.3:0.4:2,unit=um", **place)

    ome_sets()

    # ImageJ takes the absolute value.
    path = folder / "negative.tif"
    tifffile.imwrite(path, volume, imagej=True, resolution=(2, 2), metadata={"spacing": -3.0, "unit": "um", "axes": "ZYX"})
    read("imagej-negative", path, volume, steps=diagonal(0.5, 0.5, 3), unit="µm")

    calibration = {"axes": "ZYX", "spacing": 3.0, "unit": "um", "cf": 0, "c0": -1000.0, "c1": 0.5, "vunit": "HU", "xorigin": 3, "zorigin": 1}
    path = folder / "calibrated.tif"
    tifffile.imwrite(path, volume, imagej=True, resolution=(2, 2), metadata=calibration)
    read("imagej-calibrated", path, volume * 0.5 - 1000, origin=(-1.5, 0, -3), steps=diagonal(0.5, 0.5, 3), unit="µm")
    path = folder / "no-unit.tif"
    tifffile.imwrite(path, volume, imagej=True, resolution=(4, 2), metadata={"axes": "ZYX", "spacing": 3.0})
    read("imagej-no-unit", path, volume, steps=diagonal(0.25, 0.5, 3))
    tifffile.imwrite(folder / "complex.tif", volume.astype("c8"), metadata=None)
    refuse("tiff-complex", folder / "complex.tif", "complex numbers")
    path = folder / "function.tif"
    tifffile.imwrite(path, volume, imagej=True, metadata={"axes": "ZYX", "cf": 8, "c0": 1, "c1": 2})
    read("imagej-function", path, volume, notice="function 8 of ImageJ, which is not read")
    items = '<GDALMetadata><Item name="SCALE" sample="0" role="scale">0.25</Item><Item name="OFFSET" sample="0" role="offset">7</Item>{}</GDALMetadata>'
    for name, stored, more, expected, notice in (("one", volume, "", volume * 0.25 + 7, ""),
                                                 ("float", volume.astype("f4"), "", volume * 0.25 + 7, ""),
                                                 ("two", volume, '<Item sample="1" role="scale">2</Item>', volume, "scales of their own (GDAL)")):
        path = folder / f"scale-{name}.tif"
        tifffile.imwrite(path, stored, metadata=None, photometric="minisblack", extratags=[(42112, "s", 0, items.format(more), True)])
        read(f"gdal-scale-{name}", path, expected, notice=notice)
    for name, more, scale, notice in (("beside-none", "", 1, "scales of their own (GDAL)"), ("beside-one", items[14:-17].replace('"0"', '"1"'), 0.25, "")):
        path = folder / f"scale-{name}.tif"
        tifffile.imwrite(path, numpy.stack([volume, second], axis=-1), metadata=None, photometric="minisblack", planarconfig="contig",
                         extratags=[(42112, "s", 0, items.format(more), True)])
        read(f"gdal-scale-{name}", path, second * scale + (7 if scale < 1 else 0), options="component=1", notice=notice)

    # One directory, followed by the samples of all images.
    hyper = numpy.stack([volume, second], axis=1)  # Z, C, Y, X
    for order, name in (("<", "hyper"), (">", "hyper-big")):
        path = folder / f"{name}.tif"
        tifffile.imwrite(path, hyper, imagej=True, byteorder=order, resolution=(2, 2), metadata={"spacing": 3.0, "unit": "um", "axes": "ZCYX"})
        one_directory(path, order)
        for channel, expected in ((0, volume), (1, second)):
            read(f"{name}-{channel}", path, expected, options=f"channel={channel}", steps=diagonal(0.5, 0.5, 3), unit="µm")
    tifffile.imwrite(folder / "shaped.tif", volume, metadata={"truncated": True}, truncate=True)
    read("tifffile-truncated", folder / "shaped.tif", volume, notice="states no spacing")
    times = numpy.stack([volume, second])
    tifffile.imwrite(folder / "times.tif", times, photometric="minisblack", metadata={"axes": "TZYX"})
    refuse("tifffile-times", folder / "times.tif", "2 volumes", remedy="time=1")
    read("tifffile-time", folder / "times.tif", second, options="time=1")
    tifffile.imwrite(folder / "channels.tif", times, photometric="minisblack", metadata={"axes": "CZYX"}, truncate=True)
    read("tifffile-channel", folder / "channels.tif", second, options="channel=1")
    tifffile.imwrite(folder / "depth.tif", volume, volumetric=True, metadata=None, photometric="minisblack")
    read("image-depth", folder / "depth.tif", volume)
    tifffile.imwrite(folder / "depth-tiles.tif", numpy.zeros((16, 32, 32), "u1"), volumetric=True, tile=(16, 16, 16), compression="zlib",
                     metadata=None, photometric="minisblack")
    refuse("image-depth-tiles", folder / "depth-tiles.tif", "compressed, in tiles or")
    for name, distances in (("from-first", (0, 2)), ("from-last", (2, 0))):
        read(f"metamorph-{name}", stk(f"{name}.stk.tif", volume, distances=distances), volume, steps=diagonal(0.5, 1.5, 2), unit="µm")
    read("metamorph-pixels", stk("pixels.stk.tif", volume, unit="pixel", distances=(0, 0)), volume, notice="states no spacing along x, y and z")
    tags = [(33550, "d", 3, (0.5, 1.5, 2.0), True), (42113, "s", 0, "50", True)]
    tifffile.imwrite(folder / "geo.tif", volume, metadata=None, photometric="minisblack", extratags=tags)
    read("geotiff", folder / "geo.tif", numpy.where(volume == 50, numpy.nan, volume), steps=diagonal(0.5, 1.5, 2))
    tifffile.imwrite(folder / "lsm.tif", volume, metadata=None, photometric="minisblack", extratags=[(34412, "B", 512, bytes(512), True)])
    read("tiff-of-lsm", folder / "lsm.tif", volume, notice="a TIFF file of Zeiss LSM, whose tags are not read")
    read("tiff-of-lsm-given", folder / "lsm.tif", volume, options="spacing=0.5:1.5:2", notice="!LSM", steps=diagonal(0.5, 1.5, 2))
    tifffile.imwrite(folder / "codec.tif", volume, metadata=None, photometric="minisblack")
    data = (folder / "codec.tif").read_bytes()
    write("codec.tif", data.replace(struct.pack("<HHIHH", 259, 3, 1, 1, 0), struct.pack("<HHIHH", 259, 3, 1, 34712, 0)))
    refuse("tiff-other-compression", folder / "codec.tif", "not implemented). Save it with another compression")
    path = stk("short.stk.tif", volume)
    path.write_bytes(path.read_bytes()[:-1])
    refuse("metamorph-short", path, "it ends too early")
    data = bytearray(stk("unknown.tif", numpy.tile(volume, (12, 1, 1)), unit="pixel").read_bytes())
    at = data.index(struct.pack("<HH", 33629, 5))
    data[at:at + 4] = struct.pack("<HH", 65000, 5)  # Another tag.
    path = write("unknown.tif", bytes(data))
    read("tiff-bytes-behind", path, volume[:1], notice="behind its samples are not read")


def tiff_series():
    """What says less, or more, than all pages."""
    import tifffile
    small = (second[:3, :4] > 50).astype("u1")
    for name, other in (("mask", second), ("smaller", small)):  # A mask and the like behind the image.
        with tifffile.TiffWriter(folder / f"with-{name}.tif") as file:
            file.write(volume, photometric="minisblack")
            file.write(other, photometric="minisblack")
        path = folder / f"with-{name}.tif"
        read(f"tiff-before-{name}", path, volume, notice="of its 2 images, pages 1 to 5 is used")
        read(f"tiff-{name}", path, other, options="series=2", notice="!is used")
        refuse(f"tiff-{name}-none", path, "it has no image 3", options="series=3", remedy="series=1")
    colors = numpy.stack([volume, second, volume], axis=1).astype("u1")  # Z, C, Y, X
    for name, data in (("planes", colors), ("planar", colors[:1])):
        tifffile.imwrite(folder / f"{name}.tif", data, photometric="rgb", planarconfig="separate")
        read(f"tiff-{name}", folder / f"{name}.tif", data[:, 1], options="component=1")
    with tifffile.TiffWriter(folder / "each.tif") as file:
        for page in volume:
            file.write(page, photometric="minisblack")
    read("tiff-series-of-pages", folder / "each.tif", volume)
    text = "ImageJ=1.53t\nimages=5\nslices=5\nunit=micron\nyunit=mm\nzunit=nm\nspacing=200.0\n"
    tifffile.imwrite(folder / "units.tif", volume, metadata=None, resolution=(2, 4000), resolutionunit=1, description=text)
    read("tiff-imagej-units", folder / "units.tif", volume, steps=diagonal(0.5, 0.25, 0.2), unit="µm")
    blocks = "".join(f'<TiffData FirstZ="{z}" IFD="{i}" PlaneCount="1"/>' for i, z in enumerate((0, 2, 4)))
    ome = ('<OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="Image:0"><Pixels ID="Pixels:0" DimensionOrder="XYZCT" '
           f'Type="int16" SizeX="8" SizeY="6" SizeZ="5" SizeC="1" SizeT="1">{blocks}</Pixels></Image></OME>')
    tifffile.imwrite(folder / "stopped.ome.tif", volume, metadata=None, description=ome)
    refuse("tiff-stopped", folder / "stopped.ome.tif", "it has pages for only 3 of the 5 slices that it describes")
    for name, tag, value, notice in (("mirrored", 274, 2, "turned or mirrored (Orientation 2)"), ("upright", 274, 1, "!Orientation")):
        tifffile.imwrite(folder / f"{name}.tif", volume, metadata=None, photometric="minisblack", extratags=[(tag, "H", 1, value, True)])
        read(f"tiff-{name}", folder / f"{name}.tif", volume, notice=notice)
    tifffile.imwrite(folder / "white.tif", volume, metadata=None, photometric="miniswhite")
    read("tiff-white", folder / "white.tif", volume, notice="WhiteIsZero")


def ome_sets():
    """The pages of two channels in several files, each of which has the description, or whose description is elsewhere."""
    import tifffile
    head = '<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:{}">'
    pixels = ('<Image ID="Image:0"><Pixels ID="Pixels:0" SizeX="8" SizeY="6" SizeZ="5" SizeC="2" SizeT="1" Type="uint16" DimensionOrder="XYZCT" '
              'PhysicalSizeX="0.3" PhysicalSizeY="0.4" PhysicalSizeZ="2">{}</Pixels></Image></OME>')
    place = {"steps": diagonal(0.3, 0.4, 2), "unit": "µm"}

    def block(i, file, at, more):
        return f'<TiffData FirstZ="{i % 5}" FirstC="{i // 5}" {more}><UUID FileName="{file}">urn:uuid:{at}</UUID></TiffData>'

    def page(path, data, text):
        path.parent.mkdir(exist_ok=True)
        tifffile.imwrite(path, data, description=text.encode(), metadata=None, photometric="minisblack")

    both = numpy.concatenate([volume, second])
    of_channels = "".join(block(5 * c + z, f"c{c}.ome.tif", c, f'IFD="{z}"') for c in range(2) for z in range(5))
    for c in range(2):
        page(folder / "channels" / f"c{c}.ome.tif", both[5 * c:5 * c + 5], head.format(c) + pixels.format(of_channels))
    for given in range(2):
        for c, expected in enumerate((volume, second)):
            read(f"ome-set-{given}-{c}", folder / "channels" / f"c{given}.ome.tif", expected, options=f"channel={c}", **place)
    for name, more in (("ifd", 'IFD="0" PlaneCount="1"'), ("planes", ""), ("gone", "")):
        planes = "".join(block(i, f"p{i}.ome.tif", i, more) for i in range(10))
        for i in range(10):
            page(folder / name / f"p{i}.ome.tif", both[i], head.format(i) + f'<BinaryOnly MetadataFile="all.companion.ome" UUID="urn:uuid:x"/></OME>')
        write(f"{name}/all.companion.ome", (head.format("x") + pixels.format(planes)).encode())
        for given in ("p3.ome.tif", "all.companion.ome") if name != "gone" else ():
            read(f"ome-{name}-{given}", folder / name / given, second, options="channel=1", **place)
    read("ome-set-folder", folder / "ifd" / "p?.ome.tif", both, notice="give this file alone")
    (folder / "gone" / "p8.ome.tif").unlink()
    refuse("ome-set-missing", folder / "gone" / "p3.ome.tif", "'p8.ome.tif' is missing", options="channel=1")
    refuse("ome-set-nameless", write("alone.ome", (head.format("x") + pixels.format("")).encode()), "without names of TIFF files")


def one_directory(path, order):
    """Ends the chain of directories after the first one, whose images follow each other."""
    data = bytearray(path.read_bytes())
    at, = struct.unpack(order + "I", data[4:8])
    count, = struct.unpack(order + "H", data[at:at + 2])
    data[at + 2 + 12 * count:at + 6 + 12 * count] = bytes(4)
    path.write_bytes(data)


def stk(name, data, unit="um", distances=(0, 2)):
    """A stack of MetaMorph: its tag UIC2 has six numbers for each plane, UIC1 pairs of a kind and a value, or an offset of a value."""
    planes, rows, columns = data.shape
    entries = [(256, 4, 1, columns), (257, 4, 1, rows), (258, 3, 1, 16), (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, 0), (277, 3, 1, 1),
               (278, 4, 1, rows), (279, 4, 1, rows * columns * 2),
               (33628, 4, 12, 0), (33629, 5, planes, 0)]
    end = 8 + 2 + 12 * len(entries) + 4
    first, step = distances
    uic2 = b"".join(struct.pack("<6I", first + step * i, 1, 2450000, 0, 2450000, 0) for i in range(planes))
    uic1_at = end + len(uic2)
    values_at = uic1_at + 12 * 8
    text = unit.encode() + b"\0"
    pairs = [(1, 0), (2, 300), (3, 1), (4, values_at), (5, values_at + 8), (6, values_at + 16)] + [(1, 0)] * 6
    behind = b"".join(struct.pack("<2I", *pair) for pair in pairs) + struct.pack("<5I", 1, 2, 3, 2, len(text)) + text
    out = b"II*\0" + struct.pack("<IH", 8, len(entries))
    for tag, kind, count, value in entries:
        out += struct.pack("<HHII", tag, kind, count, {273: uic1_at + len(behind), 33628: uic1_at, 33629: end}.get(tag, value))
    return write(name, out + bytes(4) + uic2 + behind + data.tobytes())


# ---- MRC

def mrc_file(name, data, change):
    import mrcfile
    path = folder / name
    with mrcfile.new(path, overwrite=True) as file:
        file.set_data(data)
        file.voxel_size = (0.5, 1.5, 2)
    raw = bytearray(path.read_bytes())
    change(raw)
    path.write_bytes(raw)
    return path


def mrc():
    def put(raw, at, form, *values):
        raw[at:at + struct.calcsize(form)] = struct.pack(form, *values)

    place = {"steps": diagonal(0.5, 1.5, 2), "unit": "Å"}
    unsigned = numpy.arange(240).reshape(SHAPE)
    signed = unsigned.astype("u1").view("i1")

    def with_range(low, high, stamp=None):
        def change(raw):
            put(raw, 76, "<3f", low, high, (low + high) / 2)
            if stamp is not None:
                put(raw, 152, "<2i", 1146047817, stamp)
        return change

    read("mrc-signed", mrc_file("signed.mrc", signed, with_range(-128, 127)), signed, **place)
    read("mrc-imod", mrc_file("imod.mrc", signed, with_range(0, 239, stamp=0)), unsigned, **place)
    read("mrc-imod-signed", mrc_file("imod-signed.mrc", signed, with_range(-128, 127, stamp=1)), signed, **place)
    read("mrc-imod-contradicted", mrc_file("imod-c.mrc", signed, with_range(-128, 127, stamp=0)), unsigned, notice="the flag is used", **place)
    read("mrc-range", mrc_file("range.mrc", signed, with_range(0, 239)), unsigned, notice="unsigned ones are used", **place)
    wide = (unsigned * 200).astype("<u2").view("<i2")
    read("mrc-range-16", mrc_file("range16.mrc", wide, with_range(0, 47800)), unsigned * 200, notice="unsigned ones are used", **place)
    read("mrc-no-range", mrc_file("none.mrc", signed, with_range(0, -1)), signed, **place)

    stack = numpy.arange(192, dtype="<f4").reshape(4, 6, 8)

    def of_volumes(raw):
        put(raw, 88, "<i", 401)
        put(raw, 36, "<i", 2)
        put(raw, 48, "<f", 4.0)

    path = mrc_file("stack.mrc", stack, of_volumes)
    refuse("mrc-stack", path, "2 volumes", remedy="time=1")
    for time in (0, 1):
        read(f"mrc-stack-{time}", path, stack[2 * time:2 * time + 2], options=f"time={time}", **place)
    zero = mrc_file("zero.mrc", stack, lambda raw: put(raw, 40, "<3f", 4, 0, 0))
    read("mrc-no-cell", zero, stack, notice="states no spacing along y and z", steps=diagonal(0.5, 1, 1), unit="Å")
    images = mrc_file("images.mrc", stack, lambda raw: put(raw, 36, "<i", 1) or put(raw, 88, "<i", 0) or put(raw, 48, "<f", 2.0))
    read("mrc-images", images, stack, notice="a stack of 4 images (ISPG 0, MZ 1)", **place)
    longer = mrc_file("longer.mrc", stack, lambda raw: raw.extend(b"tail"))
    read("mrc-longer", longer, stack, notice="4 bytes more", **place)

    # An oblique cell: beta of 120 degrees shifts sections by half their distance.
    def oblique(raw):
        put(raw, 40, "<3f", 8, 6, 4)
        put(raw, 52, "<3f", 90, 120, 90)

    path = mrc_file("oblique.mrc", stack, oblique)
    refuse("mrc-oblique", path, "not at right angles", remedy="resample")
    rows = numpy.full((4, 6, 10), numpy.nan, "f4")
    for k in range(4):
        for i in range(10):
            at = i - 2 + 0.5 * k
            if 0 <= at <= 7:
                low = math.floor(at)
                high = min(low + 1, 7)
                rows[k, :, i] = stack[k, :, low] + (at - low) * (stack[k, :, high] - stack[k, :, low])
    read("mrc-oblique-resampled", path, rows, options="resample", origin=(-2, 0, 0), steps=diagonal(1, 1, math.sqrt(0.75)), unit="Å",
         notice="--resample makes")


# ---- VTK

VTK = "# vtk DataFile Version 3.0\nx\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 8 6 5\nORIGIN 1 2 3\nSPACING 0.5 1.5 2\n"


def vtk():
    place = {"origin": (1, 2, 3), "steps": diagonal(0.5, 1.5, 2)}
    cells = numpy.arange(4 * 5 * 7).reshape(4, 5, 7)

    def legacy(name, is_text):
        def samples(data, kind=">f4"):
            return (" ".join(str(v) for v in data.ravel()) + " ").encode() if is_text else data.astype(kind).tobytes()

        out = VTK.format("ASCII" if is_text else "BINARY").encode()
        out += b"CELL_DATA 140\nSCALARS of%20cells float 1\nLOOKUP_TABLE colors\n" + samples(cells) + b"\nLOOKUP_TABLE colors 2\n"
        out += (b"0 0 0 1 1 1 1 1 " if is_text else bytes(8)) + b"\nMETADATA\nINFORMATION 0\n\n"
        out += b"POINT_DATA 240\nFIELD FieldData 2\ndensity 1 240 float\n" + samples(volume) + b"\nMETADATA\nINFORMATION 0\n\n"
        out += b"pressure 1 240 float\n" + samples(second) + b"\nVECTORS v float\n"
        out += samples(numpy.stack([volume, second, volume], axis=-1)) + b"\n"
        return write(name, out)

    for name, is_text in (("many.vtk", False), ("many-text.vtk", True)):
        path = legacy(name, is_text)
        read(name, path, volume, notice="of its 4 arrays, 'density' is used", **place)
        read(f"{name}-second", path, second, options="array=pressure", **place)
        read(f"{name}-vector", path, second, options="array=v,component=1", **place)
        for array in ("of cells", "CellData/of cells"):
            read(f"{name}-{array.replace('/', '-')}", path, cells, options=f"array={array}", origin=(1.25, 2.75, 4), steps=diagonal(0.5, 1.5, 2))
        colors = VTK.format("ASCII" if is_text else "BINARY").encode() + b"POINT_DATA 240\nCOLOR_SCALARS c 1\n"
        colors += b" ".join(b"%g" % (value / 255) for value in volume.flat) if is_text else volume.astype("u1").tobytes()
        read(f"{name}-colors", write(f"colors-{name}", colors + b"\n"), volume, **place)
        refuse(f"{name}-none", path, "Its arrays are CellData/of cells, PointData/density", options="array=nothing")
    ghosts = VTK.format("ASCII") + "POINT_DATA 240\nFIELD FieldData 2\nvtkGhostType 1 240 unsigned_char\n" + "0 " * 240
    ghosts += "\ns 1 240 float\n" + " ".join(map(str, range(240))) + "\n"
    read("vtk-ghosts", write("ghosts.vtk", ghosts.encode()), volume, notice="of its 2 arrays, 's' is used", **place)
    longer = VTK.format("ASCII") + "POINT_DATA 240\nSCALARS s float\nLOOKUP_TABLE default\n" + " ".join(map(str, range(240))) + "\n7 8\n"
    read("vtk-longer", write("longer.vtk", longer.encode()), volume, notice="from '7' on", **place)

    # Arrays of bits and of strings, which are no samples.
    strings = [f"{i:03} odd %" * (i % 40) for i in range(240)]
    for is_text in (False, True):
        bits = b"1 0 " * 120 if is_text else bytes(30)
        texts = b"".join((bytes([0xC0 | len(text)]) if len(text) < 64 else struct.pack(">H", 0x8000 | len(text))) + text.encode()
                         for text in strings)
        if is_text:
            texts = "".join(text.replace("%", "%25").replace(" ", "%20") + "\n" for text in strings).encode()
        numbers = " ".join(map(str, volume.flat)).encode() if is_text else volume.astype(">f4").tobytes()
        out = VTK.format("ASCII" if is_text else "BINARY").encode() + b"POINT_DATA 240\nSCALARS b bit\nLOOKUP_TABLE default\n" + bits
        out += b"\nFIELD FieldData 2\nnames 1 240 string\n" + texts + b"\ns 1 240 float\n" + numbers + b"\n"
        read(f"vtk-strings-{is_text}", write(f"strings-{is_text}.vtk", out), volume, notice="!not read", **place)

    # Elements inside of an inline array, in front of its samples or behind them.
    key = b'<InformationKey name="L2_NORM_RANGE" location="vtkDataArray" length="1"><Value index="0">7.07</Value></InformationKey>'
    packed = base64.b64encode(struct.pack("<I", volume.nbytes) + volume.tobytes())
    numbers = " ".join(map(str, volume.flat)).encode()
    vti_head = b'<VTKFile type="ImageData"><ImageData WholeExtent="0 7 0 5 0 4" Origin="1 2 3" Spacing="0.5 1.5 2"><Piece Extent="0 7 0 5 0 4">'
    for kind, text in (("binary", packed), ("ascii", numbers)):
        for where, inside in (("front", key + b"\n" + text), ("behind", b"\n" + text + b"\n" + key), ("both", key + text + key + b"\n" + key)):
            array = f'<PointData><DataArray type="UInt16" Name="s" format="{kind}">'.encode() + inside + b"</DataArray></PointData>"
            path = write(f"key-{kind}-{where}.vti", vti_head + array + b"</Piece></ImageData></VTKFile>")
            read(f"vti-key-{kind}-{where}", path, volume, **place)
    array = b'<PointData><DataArray type="UInt16" Name="s" format="ascii">' + numbers + b" 7</DataArray></PointData>"
    refuse("vti-longer", write("longer.vti", vti_head + array + b"</Piece></ImageData></VTKFile>"), "more numbers than its header declares")

    # The number of bytes and the samples, encoded apart or together.
    def vti(name, bits, inline, apart):
        head = struct.pack("<I" if bits == 32 else "<Q", volume.nbytes)
        data = volume.tobytes()
        text = (base64.b64encode(head) + base64.b64encode(data)) if apart else base64.b64encode(head + data)
        array = b'<DataArray type="UInt16" Name="s" format="' + (b'binary">\n' + text + b"\n</DataArray>" if inline
                                                                 else b'appended" offset="0"/>')
        out = f'<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian" header_type="UInt{bits}">'.encode()
        out += b'<ImageData WholeExtent="0 7 0 5 0 4" Origin="1 2 3" Spacing="0.5 1.5 2"><Piece Extent="0 7 0 5 0 4"><PointData>'
        out += array + b"</PointData></Piece></ImageData>"
        out += b"" if inline else b'<AppendedData encoding="base64">\n_' + text + b"\n</AppendedData>"
        return write(name, out + b"</VTKFile>")

    for bits in (32, 64):
        for inline in (False, True):
            for apart in (False, True):
                name = f"vti-{bits}-{inline}-{apart}.vti"
                read(name, vti(name, bits, inline, apart), volume, **place)
    flat = b'<VTKFile type="ImageData"><ImageData WholeExtent="0 8 0 6 0 0" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 8 0 6 0 0"><CellData>'
    flat += b'<DataArray type="UInt16" Name="s" format="ascii">' + " ".join(map(str, volume[0].flat)).encode() + b"</DataArray></CellData>"
    read("vti-flat-cells", write("flat.vti", flat + b"</Piece></ImageData></VTKFile>"), volume[:1], origin=(0.5, 0.5, 0))
    path = vti("padded.vti", 32, True, True)
    data = path.read_bytes()
    at = data.index(b'"binary">\n') + 10 + 8 + 40  # Behind the number of bytes.
    write("padded.vti", data[:at + 2] + b"==" + data[at + 4:])
    refuse("vti-padding-inside", path, "base64 data contain an invalid byte")


# ---- detached and packed samples

def detached():
    place = {"steps": diagonal(0.5, 1.5, 2)}
    write("front.raw", b"sixteen bytes...".ljust(16) + volume.tobytes())
    write("back.raw", volume.tobytes() + b"tail")
    meta = "ObjectType = Image\nNDims = 3\nDimSize = 8 6 5\nElementSpacing = 0.5 1.5 2\nElementType = MET_USHORT\n{}ElementDataFile = {}\n"
    shifted = numpy.frombuffer((b"sixteen bytes...".ljust(16) + volume.tobytes())[:480], "<u2").reshape(SHAPE)
    read("mhd-front", write("front.mhd", meta.format("", "front.raw").encode()), shifted, notice="'{}' has 16 bytes more".format(folder / "front.raw"), **place)
    read("mhd-front-told", write("told.mhd", meta.format("HeaderSize = -1\n", "front.raw").encode()), volume, **place)
    read("mhd-back", write("back.mhd", meta.format("", "back.raw").encode()), volume, notice="4 bytes more", **place)
    nrrd = ("NRRD0004\ntype: uint16\ndimension: 3\nsizes: 8 6 5\nspacings: 0.5 1.5 2\nendian: little\nencoding: {}\n"
            "{}data file: {}\n")
    read("nhdr-back", write("back.nhdr", nrrd.format("raw", "", "back.raw").encode()), volume, notice="4 bytes more", **place)
    read("nhdr-skip-end", write("end.nhdr", nrrd.format("raw", "byte skip: -5\n", "back.raw").encode()), volume, **place)
    write("front.gz", gzip.compress(b"front" + volume.tobytes()))
    read("nhdr-gzip-end", write("gz.nhdr", nrrd.format("gzip", "byte skip: -1\n", "front.gz").encode()), volume, **place)
    write("both.gz", gzip.compress(b"front" + volume.tobytes()) + gzip.compress(b"tail"))
    read("nhdr-gzip-between", write("gz2.nhdr", nrrd.format("gzip", "byte skip: -5\n", "both.gz").encode()), volume, **place)
    write("one.raw", volume.tobytes() + b"1")
    read("nhdr-one", write("one.nhdr", nrrd.format("raw", "", "one.raw").encode()), volume, notice="has 1 byte more", **place)
    data = volume.tobytes()
    numbers = " ".join(map(str, volume.flat))
    for name, more in (("all", "\n \n"), ("longer", "\n7\n")):
        notice = "has more numbers than the header declares" if name == "longer" else "!more"
        write(f"{name}.txt", (numbers + more).encode())
        read(f"nhdr-text-{name}", write(f"text-{name}.nhdr", nrrd.format("text", "", f"{name}.txt").encode()), volume, notice=notice, **place)
        read(f"mhd-text-{name}", write(f"text-{name}.mhd", meta.format("BinaryData = False\n", f"{name}.txt").encode()), volume, notice=notice, **place)
        cube = "a cube\nof a test\n1 0 0 0\n5 0 0 2\n6 0 1.5 0\n8 0.5 0 0\n1 1 0 0 0\n" + numbers + more
        read(f"cube-{name}", write(f"{name}.cube", cube.encode()), volume, notice=notice, unit="bohr", **place)
    # Twelve orbitals, ten numbers to a line; exponents as Fortran writes them.
    head = "a cube\nof orbitals\n-1 0 0 0\n5 0 0 2\n6 0 1.5 0\n8 0.5 0 0\n1 1 0 0 0\n12 1 2 3 4 5 6 7 8 9\n10 11 12\n"
    rows = "".join(" ".join(["0.1D-03", "1.0-101", *[f"{int(number) * 1000}.D-03"] * 10]) + "\n" for number in volume.flat)
    orbitals = write("orbitals.cube", (head + rows).encode())
    read("cube-orbitals", orbitals, volume, options="component=3", unit="bohr", **place)
    read("cube-fortran", orbitals, numpy.full(volume.shape, 1e-4), options="component=0", unit="bohr", **place)
    read("cube-fortran-of-three-digits", orbitals, 0 * volume, options="component=1", unit="bohr", **place)
    write("longer.hex", (data + b"12").hex().encode())
    read("nhdr-hex-longer", write("hex.nhdr", nrrd.format("hex", "", "longer.hex").encode()), volume, notice="has 2 bytes more", **place)
    write("members.gz", gzip.compress(data[:100]) + gzip.compress(data[100:]) + gzip.compress(b"more"))
    read("nhdr-gzip-members", write("gz3.nhdr", nrrd.format("gzip", "", "members.gz").encode()), volume, notice="4 bytes more", **place)


def further_fields():
    """Fields of NRRD and MetaImage beside the spacings."""
    nrrd = "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 8 6 5\nendian: little\nencoding: raw\n{}\n"
    meta = "NDims = 3\nDimSize = 8 6 5\nElementSpacing = 0.5 1.5 2\nElementType = MET_USHORT\n{}ElementDataFile = LOCAL\n"
    place = {"origin": (1, 2, 3), "steps": diagonal(0.5, 1.5, 2)}

    def file(name, head, fields):
        return write(name, head.format(fields).encode() + volume.tobytes())

    read("nrrd-ends", file("ends.nrrd", nrrd, "axis mins: 1 2 3\naxis maxs: 4.5 9.5 11\ncenters: node node node\n"), volume, **place)
    read("nrrd-ends-cells", file("cells.nrrd", nrrd, "axis mins: 0.75 1.25 2\naxis maxs: 4.75 10.25 12\n"), volume, **place)
    four = nrrd.replace("dimension: 3\nsizes: 8 6 5", "dimension: 4\nsizes: {}")
    for name, sizes, steps, samples in (("last", "8 6 5 2", "0.5 1.5 2 nan", numpy.stack([volume, 2 * volume])),
                                        ("first", "2 8 6 5", "NaN 0.5 1.5 2", numpy.stack([volume, 2 * volume], axis=-1))):
        path = write(f"nan-{name}.nrrd", four.format(sizes, f"spacings: {steps}\n").encode() + samples.astype("<u2").tobytes())
        read(f"nrrd-nan-{name}", path, 2 * volume, options="time=1", steps=diagonal(0.5, 1.5, 2))
        refuse(f"nrrd-nan-{name}-times", path, "--all-times")
    read("nrrd-quantized", file("old.nrrd", nrrd, "old min: -1\nold max: 1\nspacings: 1 1 1\n"), volume, notice="stand for -1 to 1")
    read("mha-function", file("slope.mha", meta, "ElementToIntensityFunctionSlope = 0.5\n"), volume, steps=diagonal(0.5, 1.5, 2),
         notice="ElementToIntensityFunction is not applied")
    read("mha-unit", file("unit.mha", meta, "DistanceUnits = um\n"), volume, steps=diagonal(0.5, 1.5, 2), unit="µm")


def described():
    write("described.raw", volume.astype(">u2").tobytes())
    lines = b"ObjectFileName: described.raw\nResolution: 8 6 5\nFormat: USHORT\n%s: BIG\n"
    for key in (b"Endian", b"ByteOrder"):
        read(f"dat-{key.decode()}", write(f"{key.decode()}.dat", lines % key), volume)


def numbered_images():
    from PIL import Image
    images = [Image.fromarray(one) for one in volume[0:4].astype("u1")]

    def stack(name, *files):
        (folder / name).mkdir()
        for file, image in zip(files, images):
            image.save(folder / name / file)
        return folder / name

    for name, files, notice in (("gap-pair", (f"s{i}_t{40 * i}.png" for i in (1, 2, 4, 5)), "3 is missing"),
                                ("gap-dense", (f"t{1000 * i * i}_s{i}.png" for i in (1, 2, 40, 41)), "images, 3, 4, 5"),
                                ("gap-long", (f"s2024010112000000000{i}.png" for i in (1, 2, 4, 5)), "3 is missing")):
        read(name, stack(name, *files), volume[:4], notice=notice)
    path = stack("same-number", "s1.png", "s2.png", "s3.png")
    (path / "s03.png").write_bytes((path / "s3.png").read_bytes())
    read("same-number", path, volume[[0, 1, 2, 2]], notice="some of its images have the same number")
    for suffix in ("png", "tif"):
        read(f"gap-{suffix}", stack(f"gap-{suffix}", *(f"s{i}.{suffix}" for i in (1, 2, 3, 6))), volume[:4], notice="4, 5 are missing")
    read("steps", stack("steps", "s010.png", "s020.png", "s030.png", "s050.png"), volume[:4], notice="40 is missing")
    read("no-gap", stack("no-gap", "s7.png", "s8.png", "s9.png", "s10.png"), volume[:4], notice="!missing")
    images = [image.convert("P") for image in images]
    read("palette", stack("palette", "s1.png", "s2.png", "s3.png", "s4.png"), volume[:4], notice="indices of a color palette")
    read("two-kinds", stack("kinds", "ct1.png", "ct2.png", "mask1.png", "mask2.png"), volume[:4], notice="'ct1.png' and 'mask1.png'")
    read("two-numbers", stack("two", "z1c1.png", "z1c2.png", "z2c1.png", "z2c2.png"), volume[:4], notice="have two numbers, 2 by 2")


def json_shape():
    """A description that is JSON, but no shape."""
    import tifffile
    tifffile.imwrite(folder / "json.tif", volume, description='{"shape": "none"}', metadata=None, photometric="minisblack")
    read("tiff-other-json", folder / "json.tif", volume)


def nifti():
    """Two placements of one header: sform and qform."""
    import nibabel
    plain = numpy.diag([0.5, 1.5, 2, 1.0])
    plain[:3, 3] = 1, 2, 3
    moved = plain.copy()
    moved[0, 3] += 3
    sheared = plain.copy()
    sheared[0, 1] = 0.4
    place = {"origin": (-1, -2, 3), "steps": ((-0.5, 0, 0), (0, -1.5, 0), (0, 0, 2)), "unit": "mm"}
    for name, sform, qform, codes, notice in (
            ("same", plain, plain, (1, 1), "!qform"), ("apart", plain, moved, (1, 1), "place it up to 6 voxels apart; the sform is used"),
            ("atlas", plain, moved, (4, 1), "!qform"), ("sheared", sheared, plain, (1, 1), "its sform is sheared; the qform is used")):
        image = nibabel.Nifti1Image(volume.transpose(2, 1, 0).astype("i2"), None)
        image.set_sform(sform, codes[0])
        image.set_qform(qform, codes[1])
        image.header.set_xyzt_units("mm")
        nibabel.save(image, folder / f"{name}.nii")
        read(f"nifti-{name}", folder / f"{name}.nii", volume, notice=notice, **place)
    data = bytearray((folder / "same.nii").read_bytes())
    data[254:256] = struct.pack("<h", 0)
    data[80:84] = struct.pack("<f", -0.5)  # Only the first of pixdim mirrors.
    read("nifti-negative-step", write("negative.nii", data), volume, **place)
    data = bytearray((folder / "same.nii").read_bytes())
    data[280:328] = bytes(48)
    read("nifti-empty-sform", write("empty-sform.nii", data), volume, notice="its sform has an axis without length; the qform is used", **place)
    data = bytearray((folder / "same.nii").read_bytes())
    data[112:120] = struct.pack("<2f", 2, math.nan)
    read("nifti-no-intercept", write("intercept.nii", data), 2 * volume, notice="its intercept (scl_inter) is not a number; 0 is used", **place)
    data[123] = 0
    read("nifti-no-unit", write("unit.nii", data), 2 * volume, notice="states no unit of lengths; mm is assumed", **place)
    read("nifti-given-unit", folder / "unit.nii", 2 * volume, options="unit=mm", notice="!unit of lengths", **place)
    data[70:72] = struct.pack("<h", 32)
    refuse("nifti-complex", write("complex.nii", data), "complex numbers")


detached()
further_fields()
described()
vtk()
run_with_packages(tiff, tiff_series, json_shape, mrc, nifti, numbered_images)
