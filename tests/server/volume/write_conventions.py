"""Writes volumes in the conventions of communities for HDF5, NetCDF, Zarr and N5, most of them by other programs than ours, and prints
what is right for each (see odd_volumes_test.cpp)."""
import base64
import json
import pathlib
import shutil
import struct
import subprocess

import numpy

from volume_writing import diagonal, expect_read as read, expect_refused as refuse, folder, run_with_packages, write

SHAPE = (5, 6, 8)  # z, y, x
volume = numpy.arange(240, dtype="<i2").reshape(SHAPE)
PLACE = {"origin": (1, 2, 3), "steps": diagonal(0.5, 1.5, 2)}
AXES = {"x": (1 + 0.5 * numpy.arange(8), "mm"), "y": (2 + 1.5 * numpy.arange(6), "mm"), "z": (3 + 2.0 * numpy.arange(5), "mm")}


def hdf5_file(name):
    import h5py
    return h5py.File(folder / name, "w")


def itk():
    """As ITK's HDF5ImageIO writes images: a row of Directions for each axis."""
    cosines = numpy.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    for name, data in (("itk", volume), ("itk-vectors", numpy.stack([volume * 0, volume], axis=-1))):
        with hdf5_file(f"{name}.h5") as file:
            image = file.create_group("ITKImage/0")
            image["VoxelData"], image["Directions"], image["Spacing"], image["Origin"] = data, cosines * 1.0, [0.5, 1.5, 2.0], [1.0, 2.0, 3.0]
        read(name, folder / f"{name}.h5", volume, origin=(1, 2, 3), steps=((0, 0.5, 0), (0, 0, 1.5), (2, 0, 0)),
             options="component=1" if data is not volume else "")


def minc():
    """MINC 2 by h5py and, if there is minc-tools, MINC 1 and 2 by rawtominc."""
    lps = {"origin": (10, 20, -30), "steps": ((-0.5, 0, 0), (0, -1.5, 0), (0, 0, 2)), "unit": "mm"}
    def write_minc(name, image, order, low, high, starts=(-30.0, -20.0, -10.0), cosines=numpy.eye(3)):
        with hdf5_file(name) as file:
            for axis, (start, step, cosine) in enumerate(zip(starts, (2.0, 1.5, 0.5), cosines[::-1])):
                dimension = file.create_dataset(f"minc-2.0/dimensions/{'zyx'[axis]}space", data=0)
                dimension.attrs.update({"start": start, "step": step, "direction_cosines": cosine, "units": numpy.bytes_(b"mm"),
                                        "length": SHAPE[axis]})
            data = file.create_dataset("minc-2.0/image/0/image", data=image)
            data.attrs.update({"dimorder": numpy.bytes_(order.encode()), "valid_range": [0.0, 239.0]})
            file["minc-2.0/image/0/image-min"] = low
            file["minc-2.0/image/0/image-max"] = high

    bytes_ = volume.astype("u1")
    write_minc("slices.mnc", bytes_, "zspace,yspace,xspace", numpy.arange(5.0), 239 + 3 * numpy.arange(5.0))
    slopes = (239 + 2 * numpy.arange(5.0)) / 239
    read("minc2-scales-of-slices", folder / "slices.mnc", volume * slopes[:, None, None] + numpy.arange(5.0)[:, None, None], **lps)
    write_minc("irregular.mnc", bytes_, "zspace,yspace,xspace", 0.0, 239.0)
    import h5py
    with h5py.File(folder / "irregular.mnc", "a") as file:
        file["minc-2.0/dimensions/zspace"].attrs["spacing"] = numpy.bytes_(b"irregular")
    for name, axes in (("cm", "zyx"), ("mixed", "z")):
        write_minc(f"{name}.mnc", bytes_, "zspace,yspace,xspace", 0.0, 239.0)
        with h5py.File(folder / f"{name}.mnc", "a") as file:
            for axis in axes:
                file[f"minc-2.0/dimensions/{axis}space"].attrs["units"] = numpy.bytes_(b"cm")
        read(f"minc2-{name}", folder / f"{name}.mnc", volume, notice="several units; cm is used" if name == "mixed" else "!units", **{**lps, "unit": "cm"})
    read("minc2-irregular", folder / "irregular.mnc", volume, notice="positions along zspace are irregular; its step is used", **lps)
    write_minc("one.mnc", bytes_, "zspace,yspace,xspace", -1.0, 3.78)
    read("minc2-one-scale", folder / "one.mnc", volume * 4.78 / 239 - 1, **lps)
    # Coronal slices, turned about x.
    write_minc("coronal.mnc", bytes_.transpose(1, 0, 2), "yspace,zspace,xspace", 0.0, 239.0,
               cosines=numpy.array([[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]]))
    origin = numpy.array([-10, -20 * 0.8 + 30 * 0.6, -20 * 0.6 - 30 * 0.8])
    read("minc2-coronal", folder / "coronal.mnc", volume.transpose(1, 0, 2), origin=(-origin[0], -origin[1], origin[2]),
         steps=((-0.5, 0, 0), (0, 1.2, 1.6), (0, -1.2, 0.9)), unit="mm")
    if not shutil.which("rawtominc"):
        return
    for version, more in (("1", []), ("2", ["-2"])):
        for sign, data in (("-unsigned", volume + 30000), ("-signed", volume - 100)):
            path = folder / f"tools{version}{sign}.mnc"
            kind = "<u2" if sign == "-unsigned" else "<i2"
            command = ["rawtominc", *more, "-short", sign, "-xstep", "0.5", "-ystep", "1.5", "-zstep", "2", "-xstart", "-10",
                       "-ystart", "-20", "-zstart", "-30", path, "5", "6", "8"]
            subprocess.run(command, input=data.astype(kind).tobytes(), check=True, stderr=subprocess.DEVNULL)
            read(f"minc{version}{sign}", path, data, **lps)


def vtkhdf():
    with hdf5_file("image.vtkhdf") as file:
        group = file.create_group("VTKHDF")
        group.attrs.update({"Type": numpy.bytes_(b"ImageData"), "Version": [1, 0], "Origin": [1.0, 2, 3], "Spacing": [0.5, 1.5, 2.0],
                            "WholeExtent": [2, 9, 0, 5, 0, 4], "Direction": [0.0, -1, 0, 1, 0, 0, 0, 0, 1]})
        group["PointData/s"] = volume
        group["CellData/c"] = volume[1:, 1:, 1:]
    steps = ((0, 0.5, 0), (-1.5, 0, 0), (0, 0, 2))
    read("vtkhdf-points", f"{folder}/image.vtkhdf:/VTKHDF/PointData/s", volume, origin=(1, 3, 3), steps=steps)
    read("vtkhdf-cells", f"{folder}/image.vtkhdf:/VTKHDF/CellData/c", volume[1:, 1:, 1:], origin=(0.25, 3.25, 4), steps=steps)
    with hdf5_file("steps.vtkhdf") as file:
        group = file.create_group("VTKHDF")
        group.attrs.update({"Type": numpy.bytes_(b"ImageData"), "Version": [2, 0], "Origin": [1.0, 2, 3], "Spacing": [0.5, 1.5, 2.0],
                            "WholeExtent": [0, 7, 0, 5, 0, 4]})
        group["PointData/s"] = numpy.stack([volume, volume + 1000])
        group["PointData/joined"] = numpy.concatenate([volume, volume + 1000])
        group["Steps/Values"] = [0.0, 1.5]
    path = f"{folder}/steps.vtkhdf:/VTKHDF/PointData/"
    read("vtkhdf-steps", path + "s", volume + 1000, options="time=1", **PLACE)
    refuse("vtkhdf-joined-steps", path + "joined", "are not those of its WholeExtent")
    with hdf5_file("amr.vtkhdf") as file:
        file.create_group("VTKHDF").attrs.update({"Type": numpy.bytes_(b"OverlappingAMR")})
        file["VTKHDF/Level0/PointData/s"] = volume
    read("vtkhdf-other-type", folder / "amr.vtkhdf", volume, notice="this is VTKHDF of type OverlappingAMR; its geometry is not read")
    refuse("vtkhdf-several", folder / "image.vtkhdf", "2 arrays: /VTKHDF/PointData/s, /VTKHDF/CellData/c")


def nexus():
    for name, order in (("zyx", "zyx"), ("xyz", "xyz")):
        with hdf5_file(f"{name}.nxs") as file:
            file.attrs["default"] = "entry"
            entry = file.create_group("entry")
            entry.attrs.update({"NX_class": "NXentry", "default": "data"})
            data = entry.create_group("data")
            data.attrs.update({"NX_class": "NXdata", "signal": "d", "axes": list(order)})
            data["d"] = volume if order == "zyx" else volume.transpose()
            entry["other"] = volume
            for axis, (values, unit) in AXES.items():
                data[axis] = values
                data[axis].attrs["units"] = unit
        read(f"nexus-{name}", folder / f"{name}.nxs", volume, unit="mm", **PLACE)
    for name, prefix in (("named", "d_"), ("of-signal", "")):
        with hdf5_file(f"scaled-{name}.nxs") as file:
            data = file.create_group("entry/data")
            data.attrs.update({"NX_class": "NXdata", "signal": "d", "axes": [".", "y", "x"]})
            data["d"], data[prefix + "scaling_factor"], data[prefix + "offset"] = volume, 0.5, 10.0
            for axis in "xy":
                data[axis] = AXES[axis][0]
        read(f"nexus-scaled-{name}", folder / f"scaled-{name}.nxs", volume / 2 + 10, origin=(1, 2, 0), steps=diagonal(0.5, 1.5, 1),
             notice="states no spacing along z")
    with hdf5_file("old.nxs") as file:  # Before 2014; edges of bins, two units of length.
        data = file.create_group("entry/data")
        data.attrs["NX_class"] = "NXdata"
        data["d"] = volume
        data["d"].attrs.update({"signal": 1, "axes": "a:b:c"})
        for axis, name in zip("zyx", "abc"):
            values = AXES[axis][0]
            step = values[1] - values[0]
            data[name] = numpy.append(values, values[-1] + step) - step / 2
            data[name].attrs["units"] = "mm"
        data["a"][:] = data["a"][:] * 1000
        data["a"].attrs["units"] = "um"
    read("nexus-old", folder / "old.nxs", volume, unit="mm", **PLACE)


def emd():
    for name, first, order in (("berkeley", 1, "zyx"), ("named", 1, "xyz"), ("one", 0, "zyx")):
        with hdf5_file(f"{name}.emd") as file:
            group = file.create_group("data/tomogram")
            group.attrs["emd_group_type"] = 1 if first else "array"
            group["data"] = volume if order == "zyx" else volume.transpose()
            for d, axis in enumerate(order):
                values = AXES[axis][0]
                group[f"dim{d + first}"] = values if first else values[:2]
                group[f"dim{d + first}"].attrs.update({"name": axis, "units": "[n_m]"})
        read(f"emd-{name}", folder / f"{name}.emd", volume, unit="nm", **PLACE)
    with hdf5_file("velox.emd") as file:
        file["Data/Image/0123/Data"] = volume.transpose(1, 2, 0)
    read("emd-velox", folder / "velox.emd", volume, notice="this is EMD of Velox; its geometry is not read")


def openpmd():
    for name, labels, order in (("x-slowest", "xyz", "C"), ("z-slowest", "zyx", "C"), ("fortran", "xyz", "F")):
        with hdf5_file(f"{name}.h5") as file:
            file.attrs.update({"openPMD": "1.1.0", "basePath": "/data/%T/", "meshesPath": "meshes/"})
            by_label = {"x": (0.5, 1), "y": (1.5, 2), "z": (2, 3)}
            field = file.create_group("data/1/meshes/E")
            field.attrs.update({
                "axisLabels": [n.encode() for n in labels], "dataOrder": order, "geometry": "cartesian", "gridUnitSI": 0.001,
                "gridSpacing": [by_label[n][0] for n in labels],
                "gridGlobalOffset": [by_label[n][1] - by_label[n][0] / 2 for n in labels]})
            x_first = labels == "xyz" and order == "C"
            field["x"] = (volume.transpose() if x_first else volume).astype("f4")
            field["x"].attrs.update({"position": [0.5, 0.5, 0.5], "unitSI": 2.0})
        read(f"openpmd-{name}", folder / f"{name}.h5", 2 * volume, origin=(0.001, 0.002, 0.003), steps=diagonal(5e-4, 15e-4, 2e-3), unit="m")


def axistags():
    def tagged(name, data, keys, resolutions=None):
        with hdf5_file(name) as file:
            file["exported_data"] = data
            file["exported_data"].attrs["axistags"] = json.dumps({"axes": [
                {"key": k, "typeFlags": 1 if k == "c" else 2, "resolution": (resolutions or {}).get(k, 0), "description": ""}
                for k in keys]})
        return folder / name

    assumed = "the file states no spacing along x, y and z; 1 is assumed. Give it with --spacing"
    read("axistags-xyz", tagged("xyz.h5", volume.transpose(), "xyz"), volume, notice=assumed)
    read("axistags-yxz", tagged("yxz.h5", volume.transpose(1, 2, 0), "yxz"), volume, notice=assumed)
    read("axistags-one-component", tagged("one.h5", volume[..., None], "zyxc"), volume, notice=assumed)
    two = numpy.stack([volume, volume + 1000], axis=-1)
    refuse("axistags-two-components", tagged("two.h5", two, "zyxc"), "--component")
    steps = {"x": 0.5, "y": 1.5, "z": 2}
    read("axistags-resolution", tagged("tzyx.h5", numpy.stack([volume, volume + 1000]), "tzyx", steps), volume + 1000, options="time=1",
         steps=diagonal(0.5, 1.5, 2))
    with hdf5_file("filter.h5") as file:
        file.create_dataset("v", data=volume, chunks=SHAPE, compression="gzip")
    data = (folder / "filter.h5").read_bytes()
    place = data.index(b"deflate\0") - 8  # Its number precedes its name.
    write("filter.h5", data[:place] + struct.pack("<H", 32999) + data[place + 2:])
    refuse("hdf5-other-filter", folder / "filter.h5", "packed with HDF5 filter 32999, whose sizes cannot be checked")
    with hdf5_file("last.h5") as file:
        file["v"] = volume[..., None]
    read("hdf5-last-dimension-of-one", folder / "last.h5", volume, notice=assumed)


def big_data_viewer():
    def write_bdv(name, **attributes):
        with hdf5_file(f"{name}.h5") as file:
            file["s00/resolutions"] = numpy.array([[1.0, 1, 1], [2, 2, 1]])
            file["s00/subdivisions"] = numpy.array([[8, 6, 5], [4, 3, 5]])
            file["t00000/s00/0/cells"] = (volume.astype("u2") * 200).view("<i2")
            file["t00000/s00/1/cells"] = volume[:, ::2, ::2]
            file["s00"].attrs.update(attributes)

    write_bdv("bdv")
    read("bdv-without-xml", folder / "bdv.h5", volume.astype("f8") * 200, notice="this is BigDataViewer; its geometry is not read")
    write_bdv("signed", dataType="int16")
    read("bdv-signed", folder / "signed.h5", (volume.astype("u2") * 200).view("<i2"))
    write_bdv("placed")
    write("placed.xml", b"""<SpimData><SequenceDescription><ViewSetups><ViewSetup><id>0</id><size>8 6 5</size>
        <voxelSize><unit>um</unit><size>0.5 1.5 2</size></voxelSize></ViewSetup></ViewSetups></SequenceDescription></SpimData>""")
    read("bdv-xml", folder / "placed.h5", volume.astype("f8") * 200, steps=diagonal(0.5, 1.5, 2), unit="\u00b5m")
    read("bdv-level", folder / "placed.h5", volume[:, ::2, ::2], options="level=1", origin=(0.25, 0.75, 0), steps=diagonal(1, 3, 2),
         unit="\u00b5m")
    # Registrations: a calibration, applied first, then a turn about z; the XML has another name than the samples.
    def xml(name, loader, transforms, setups=(("", "0.5 1.5 2"),), points=(0,)):
        views = "".join(f"<ViewSetup><id>{i}</id><name>{name}</name><voxelSize><unit>micrometer</unit><size>{size}</size></voxelSize></ViewSetup>"
                        for i, (name, size) in enumerate(setups))
        affines = "".join(f'<ViewTransform type="affine"><Name/><affine>{text}</affine></ViewTransform>' for text in transforms)
        places = "".join(f'<ViewRegistration timepoint="{t}" setup="{i}">{affines}</ViewRegistration>'
                         for t in points for i in range(len(setups)))
        write(name, f"""<?xml version="1.0" encoding="UTF-8"?>
            <SpimData version="0.2"><BasePath type="relative">.</BasePath><SequenceDescription>{loader}<ViewSetups>{views}</ViewSetups>
            </SequenceDescription><ViewRegistrations>{places}</ViewRegistrations></SpimData>""".encode())
        return folder / name

    def hdf5(name):
        return f'<ImageLoader format="bdv.hdf5"><hdf5 type="relative">{name}</hdf5></ImageLoader>'

    calibration, turn = "0.5 0 0 0 0 1.5 0 0 0 0 2 0", "0 -1 0 10 1 0 0 20 0 0 1 30"
    turned = {"origin": (10, 20, 30), "steps": ((0, 0.5, 0), (-1.5, 0, 0), (0, 0, 2)), "unit": "\u00b5m"}
    write_bdv("samples")
    by_name = xml("dataset.xml", hdf5("samples.h5"), (turn, calibration))
    stored = volume.astype("f8") * 200
    read("bdv-registered", by_name, stored, **turned)
    read("bdv-xml-of-another-name", folder / "samples.h5", stored, **turned)
    read("bdv-registered-level", by_name, volume[:, ::2, ::2], options="level=1", origin=(10 - 0.75, 20.25, 30),
         steps=((0, 1, 0), (-3, 0, 0), (0, 0, 2)), unit="\u00b5m")
    # BigStitcher counts sides of voxels.
    write_bdv("stitched")
    xml("stitched.xml", hdf5("stitched.h5"), ("1 0 0 4 0 3 0 0 0 0 4 0",))
    read("bdv-in-voxels", folder / "stitched.xml", stored, origin=(2, 0, 0), steps=diagonal(0.5, 1.5, 2), unit="\u00b5m",
         notice="its registrations count voxels")
    # Several setups and times.
    with hdf5_file("views.h5") as file:
        for setup in range(2):
            file[f"s{setup:02}/resolutions"] = numpy.array([[1.0, 1, 1]])
            for time in range(2):
                file[f"t{time:05}/s{setup:02}/0/cells"] = volume + 1000 * setup + 2000 * time
    views = xml("all_views.xml", hdf5("views.h5"), (calibration,), (("left", "0.5 1.5 2"), ("right", "0.5 1.5 2")), (0, 1))
    place = {"steps": diagonal(0.5, 1.5, 2), "unit": "\u00b5m"}
    refuse("bdv-several-setups", views, "it has 2 setups. Choose one with --series", options="time=0")
    refuse("bdv-several-times", folder / "views.h5", "it has 2 volumes, one for each time. Choose one with --time")
    read("bdv-setup-and-time", views, volume + 3000, options="series=right,time=1", **place)
    refuse("bdv-other-loader", xml("other.xml", '<ImageLoader format="bdv.imaris"/>', ()), "the format 'bdv.imaris', which is not read")
    (folder / "outside").mkdir()
    write_bdv("outside/away")
    refuse("bdv-outside", xml("inner/away.xml", hdf5("../outside/away.h5"), (calibration,)), "outside the header's folder", remedy="follow")
    # N5, with a level.
    for level, data in enumerate((volume, volume[:, ::2, ::2])):
        at = f"views.n5/setup0/timepoint0/s{level}"
        factors = [[1, 1, 1], [2, 2, 1]][level]
        write(f"{at}/attributes.json", json.dumps({"dimensions": data.shape[::-1], "blockSize": data.shape[::-1], "dataType": "int16",
                                                   "compression": {"type": "raw"}, "downsamplingFactors": factors}).encode())
        write(f"{at}/0/0/0", struct.pack(">HHIII", 0, 3, *data.shape[::-1]) + data.astype(">i2").tobytes())
    write("views.n5/attributes.json", b'{"n5": "2.5.1"}')
    write("views.n5/setup0/attributes.json", b'{"downsamplingFactors": [[1,1,1],[2,2,1]], "dataType": "int16"}')
    in_n5 = xml("views.xml", '<ImageLoader format="bdv.n5" version="1.0"><n5 type="relative">views.n5</n5></ImageLoader>', (turn, calibration))
    read("bdv-n5", in_n5, volume, **turned)
    read("bdv-n5-level", in_n5, volume[:, ::2, ::2], options="level=1", origin=(10 - 0.75, 20.25, 30),
         steps=((0, 1, 0), (-3, 0, 0), (0, 0, 2)), unit="\u00b5m")
    read("bdv-n5-itself", folder / "views.n5", volume, **turned)


def dream3d():
    with hdf5_file("cells.dream3d") as file:
        file["DataContainers/Image/CellData/Phases"] = volume[..., None]
        file["DataContainers/Image/CellData/Phases"].attrs["ComponentDimensions"] = numpy.array([1], "u8")
        geometry = file.create_group("DataContainers/Image/_SIMPL_GEOMETRY")
        geometry["SPACING"], geometry["ORIGIN"] = numpy.float32([0.5, 1.5, 2]), numpy.float32([0.75, 1.25, 2])
    read("dream3d", folder / "cells.dream3d", volume, **PLACE)


def netcdf_axes():
    """Axes that attributes of coordinates name (CF conventions), and coordinates that are packed or rounded."""
    import netCDF4

    def variable(name, dimensions, data, **more):
        """`dimensions`: name, coordinates, and attributes of these."""
        with netCDF4.Dataset(folder / name, "w", format="NETCDF3_CLASSIC") as file:
            for axis, values, attributes in dimensions:
                file.createDimension(axis, len(values))
                along = file.createVariable(axis, attributes.pop("type_", "f8"), (axis,))
                along.set_auto_maskandscale(False)
                along[:] = values
                along.setncatts(attributes)
            file.createVariable("v", "i2", [axis for axis, *_ in dimensions])[:] = data
        return folder / name

    place = {"unit": "m", **PLACE}
    (xs, _), (ys, _), (zs, _) = (AXES[axis] for axis in "xyz")
    xyz = [("n1", xs, {"axis": "X", "units": "m"}), ("n2", ys, {"axis": "Y", "units": "m"}), ("n3", zs, {"axis": "Z", "units": "m"})]
    read("netcdf-axis-attributes", variable("axis.nc", xyz, volume.transpose()), volume, **place)
    # Longitudes, latitudes and levels in any order; times by their unit.
    earth = {"lon": ("a", xs, {"units": "degrees_east"}), "lat": ("b", ys, {"standard_name": "latitude"}), "lev": ("lev", zs, {"positive": "up"}),
             "time": ("when", [0, 1], {"units": "days since 2000-01-01"})}
    for order in ("time lev lat lon", "lev time lat lon", "time lon lat lev"):
        plain = numpy.stack([volume + 1000, volume])  # time, lev, lat, lon
        data = plain.transpose([("time", "lev", "lat", "lon").index(name) for name in order.split()])
        path = variable(f"earth-{order.replace(' ', '-')}.nc", [(n, v, dict(a)) for n, v, a in (earth[name] for name in order.split())], data)
        read(f"netcdf-{order}", path, volume, options="time=1", unit="degrees_east", **PLACE)
    packed = [("z", numpy.arange(5), {"units": "m", "type_": "i2", "scale_factor": 2.0, "add_offset": 3.0}), ("y", ys, {"units": "m"}),
              ("x", numpy.arange(8), {"units": "m", "type_": "i2", "scale_factor": 0.5, "add_offset": 1.0})]
    read("netcdf-packed-coordinates", variable("packed-coordinates.nc", packed, volume), volume, **place)
    fine = [("z", zs, {"units": "m"}), ("y", ys, {"units": "m"}), ("x", 170 + 0.005 * numpy.arange(8), {"units": "m", "type_": "f4"})]
    read("netcdf-rounded-coordinates", variable("rounded.nc", fine, volume), volume, notice="!evenly", unit="m", origin=(170, 2, 3),
         steps=diagonal(0.005, 1.5, 2))
    uneven = [("z", zs, {"units": "m"}), ("y", ys, {"units": "m"}), ("x", numpy.array([170, 170.005, 170.02, 170.025, 170.03, 170.035, 170.04, 170.045]), {"units": "m", "type_": "f4"})]
    read("netcdf-uneven-coordinates", variable("uneven.nc", uneven, volume), volume, notice="not evenly spaced", unit="m", origin=(0, 2, 3), steps=diagonal(1, 1.5, 2))


def netcdf_unlimited():
    """A variable with fewer records than another one."""
    import netCDF4
    for kind in ("NETCDF4", "NETCDF3_CLASSIC"):
        with netCDF4.Dataset(folder / f"short-{kind}.nc", "w", format=kind) as file:
            for axis, size in (("z", None), ("y", 6), ("x", 8)):
                file.createDimension(axis, size)
            v = file.createVariable("v", "f4", ("z", "y", "x"))
            v[:] = volume
            file.createVariable("w", "f4", ("z",))[:] = range(6)
        expected = numpy.concatenate([volume, numpy.full((1, 6, 8), numpy.nan)])
        read(f"netcdf-short-{kind}", folder / f"short-{kind}.nc", expected, options="array=v")


def unwritten():
    """Samples that no program wrote, and missing values of fewer digits than samples have."""
    with hdf5_file("stopped.h5") as file:
        file.create_dataset("v", SHAPE, "f4", chunks=(1, 6, 8), fillvalue=-1)[:3] = volume[:3]
    expected = volume.astype("f4")
    expected[3:] = -1
    read("hdf5-unwritten-chunks", folder / "stopped.h5", expected, notice="2 of 5 chunks were never written")
    with hdf5_file("empty.h5") as file:
        file.create_dataset("v", SHAPE, "f4")
    read("hdf5-unwritten", folder / "empty.h5", 0 * volume, notice="its samples were never written")
    with hdf5_file("digits.h5") as file:
        file["v"] = numpy.where(volume == 50, -9999.9, volume).astype("f4")
        file["v"].attrs.update({"_FillValue": -9999.9, "valid_max": 239.0})
    read("hdf5-missing-of-more-digits", folder / "digits.h5", numpy.where(volume == 50, numpy.nan, volume))


def netcdf():
    import netCDF4
    for kind in ("NETCDF4", "NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "NETCDF4_CLASSIC"):
        def variable(name, data, coordinates=True, type_="i2", group="", **attributes):
            fill = attributes.pop("fill", None)
            with netCDF4.Dataset(folder / name, "w", format=kind) as file:
                place = file.createGroup(group) if group else file
                for axis, size in zip("zyx", data.shape):
                    file.createDimension(axis, size)
                    if coordinates:
                        along = file.createVariable(axis, "f8", (axis,))
                        along[:], along.units = AXES[axis][0][:size], "m"
                v = place.createVariable("v", type_, ("z", "y", "x"), fill_value=fill)
                v.set_auto_maskandscale(False)
                v.setncatts(attributes)
                v[:] = data
            return folder / name

        tag = kind.lower()
        place = {"unit": "m", **PLACE}
        read(f"{tag}-unsigned", variable(f"{tag}1.nc", volume.astype("u1").view("i1"), type_="i1", _Unsigned="true", scale_factor=0.5),
             volume / 2, **place)
        masked = volume.astype("f4")
        masked[volume == 50] = numpy.nan
        read(f"{tag}-missing", variable(f"{tag}2.nc", volume, missing_value=numpy.int16(50)), masked, **place)
        both = masked.copy()
        both[(volume == 7) | (volume > 200)] = numpy.nan
        read(f"{tag}-fill-and-range", variable(f"{tag}3.nc", volume, fill=numpy.int16(7), missing_value=numpy.int16(50), valid_max=numpy.int16(200)),
             both, **place)
        packed = variable(f"{tag}4.nc", volume, scale_factor=0.5, add_offset=10.0, units="K")
        read(f"{tag}-packed", packed, volume / 2 + 10, **place)
        # Floats are a range of unpacked values.
        unpacked = volume / 2 + 10
        unpacked[unpacked < 20] = numpy.nan
        read(f"{tag}-packed-range", variable(f"{tag}-range.nc", volume, scale_factor=0.5, add_offset=10.0, valid_range=[20.0, 200.0]), unpacked, **place)
        tenths = volume * 0.1
        tenths[(volume < 7) | (volume > 203)] = numpy.nan  # 7 * 0.1f and 20.3 are not quite their multiples.
        limits = {"valid_min": numpy.float32(0.7), "valid_max": numpy.float64(20.3)}
        read(f"{tag}-packed-limits", variable(f"{tag}-limits.nc", volume, scale_factor=0.1, **limits), tenths, **place)
        unwritten = volume.astype("f4")
        unwritten[4] = netCDF4.default_fillvals["f4"]
        empty = unwritten.copy()
        empty[4] = numpy.nan
        read(f"{tag}-default-fill", variable(f"{tag}5.nc", unwritten, coordinates=False, type_="f4"), empty,
             notice="the file states no spacing along x, y and z; 1 is assumed")
        short = volume.copy()
        short[4] = netCDF4.default_fillvals["i2"]
        read(f"{tag}-default-fill-of-shorts", variable(f"{tag}6.nc", short), short, notice="some samples are -32767", **place)
        if kind == "NETCDF4":
            read(f"{tag}-group", variable(f"{tag}7.nc", volume, group="a/b"), volume, **place)
        if kind.startswith("NETCDF3"):
            refuse(f"{tag}-cut", write(f"{tag}-cut.nc", packed.read_bytes()[:-8]), "ends too early")
        elif kind == "NETCDF4":
            refuse(f"{tag}-cut", write(f"{tag}-cut.nc", packed.read_bytes()[:-8]), "libhdf5 cannot open it")
        # Beside missing_value the default fill holds, too.
        expected = unwritten.copy()
        expected[4] = numpy.nan
        expected[volume == 50] = numpy.nan
        read(f"{tag}-default-fill-and-missing", variable(f"{tag}8.nc", unwritten, type_="f4", missing_value=numpy.float32(50)), expected, **place)
    netcdf_axes()
    netcdf_unlimited()
    with netCDF4.Dataset(folder / "records.nc", "w", format="NETCDF3_CLASSIC") as file:
        file.createDimension("time", None)
        for axis, size in zip("zyx", SHAPE):
            file.createDimension(axis, size)
        time = file.createVariable("time", "f8", ("time",))
        v = file.createVariable("v", "i2", ("time", "z", "y", "x"))
        time[:], v[:] = [0, 10, 20], numpy.stack([volume, volume + 1000, volume + 2000])
    read("netcdf-records", folder / "records.nc", volume + 2000, options="time=2")


# ---- Zarr and N5

def zarr_array(path, data, attributes=None, chunks=None, fill=0):
    """Zarr 2 without compression, in one chunk."""
    write(f"{path}/.zarray", json.dumps({
        "zarr_format": 2, "shape": data.shape, "chunks": chunks or data.shape, "dtype": data.dtype.str, "compressor": None,
        "fill_value": fill, "order": "C", "filters": None}).encode())
    write(f"{path}/" + ".".join("0" * data.ndim), data.tobytes())
    if attributes is not None:
        write(f"{path}/.zattrs", json.dumps(attributes).encode())
    return folder / path


def xarray():
    write("packed.zarr/.zgroup", b'{"zarr_format": 2}')
    for axis, (values, unit) in AXES.items():
        zarr_array(f"packed.zarr/{axis}", values, {"_ARRAY_DIMENSIONS": [axis], "units": unit})
    zarr_array("packed.zarr/v", volume, {"_ARRAY_DIMENSIONS": ["z", "y", "x"], "scale_factor": 0.5, "add_offset": 10.0, "_FillValue": 7})
    expected = volume / 2 + 10
    expected[volume == 7] = numpy.nan
    read("xarray", folder / "packed.zarr", expected, unit="mm", **PLACE)
    read("xarray-array", folder / "packed.zarr", expected, options="array=v", unit="mm", **PLACE)
    write("depth.zarr/.zgroup", b'{"zarr_format": 2}')
    for name, axis in (("depth", "z"), ("y", "y"), ("x", "x")):
        zarr_array(f"depth.zarr/{name}", AXES[axis][0], {"_ARRAY_DIMENSIONS": [name], "units": "mm"})
    zarr_array("depth.zarr/v", volume, {"_ARRAY_DIMENSIONS": ["depth", "y", "x"]})
    metadata = json.loads((folder / "depth.zarr/v/.zarray").read_text())
    write("depth.zarr/v/.zarray", json.dumps({**metadata, "fill_value": 7}).encode())
    read("xarray-other-name-of-z", folder / "depth.zarr", numpy.where(volume == 7, numpy.nan, volume), unit="mm", **PLACE)
    zarr_array("delta.zarr/v", volume)
    metadata = json.loads((folder / "delta.zarr/v/.zarray").read_text())
    write("delta.zarr/v/.zarray", json.dumps({**metadata, "filters": [{"id": "delta", "dtype": "<i2"}]}).encode())
    write("delta.zarr/.zgroup", b'{"zarr_format": 2}')
    refuse("zarr-filter-of-only-array", folder / "delta.zarr", "its chunks use the filters")
    write("hexadecimal.zarr/zarr.json", json.dumps({
        "zarr_format": 3, "node_type": "array", "shape": SHAPE, "data_type": "float32", "fill_value": "0x40490fdb",
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": SHAPE}}, "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}],
        "chunk_key_encoding": {"name": "default"}}).encode())
    # As xarray writes the fill value of floats in Zarr 3.
    encoded = base64.b64encode(struct.pack("<d", 50)).decode()
    write("base64.zarr/zarr.json", json.dumps({
        "zarr_format": 3, "node_type": "array", "shape": SHAPE, "data_type": "float32", "fill_value": 0, "attributes": {"_FillValue": encoded},
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": SHAPE}}, "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}],
        "chunk_key_encoding": {"name": "default"}}).encode())
    write("base64.zarr/c/0/0/0", volume.astype("<f4").tobytes())
    read("zarr-missing-in-base64", folder / "base64.zarr", numpy.where(volume == 50, numpy.nan, volume))
    read("zarr-fill-in-hexadecimal", folder / "hexadecimal.zarr", numpy.full(SHAPE, numpy.pi), notice="1 of 1 chunks are missing")


def axes_of(unit, names="zyx"):
    return [{"name": n, "type": "space", "unit": unit} for n in names]


def ome():
    scale = [{"type": "scale", "scale": [2, 1.5, 0.5]}]
    def image(path, datasets, axes=None, **more):
        write(f"{path}/.zgroup", b'{"zarr_format": 2}')
        write(f"{path}/.zattrs", json.dumps({"multiscales": [{"axes": axes or axes_of("micrometer"), "datasets": datasets, **more}]}).encode())
        return folder / path

    levels = [{"path": "half", "coordinateTransformations": [{"type": "scale", "scale": [2, 3, 1]}]},
              {"path": "full", "coordinateTransformations": scale}]
    unordered = image("unordered.zarr", levels)
    zarr_array("unordered.zarr/full", volume)
    zarr_array("unordered.zarr/half", volume[:, ::2, ::2].copy())
    place = {"steps": diagonal(0.5, 1.5, 2), "unit": "\u00b5m"}
    read("ome-levels-in-any-order", unordered, volume, **place)
    read("ome-second-level", unordered, volume[:, ::2, ::2], options="level=1", steps=diagonal(1, 3, 2), unit="\u00b5m")
    units = [{"name": n, "type": "space", "unit": u} for n, u in (("z", "micrometer"), ("y", "nanometer"), ("x", "nanometer"))]
    by_axis = image("units.zarr", [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [0.002, 1.5, 0.5]}]}], units)
    zarr_array("units.zarr/0", volume)
    read("ome-units-by-axis", by_axis, volume, steps=diagonal(0.5, 1.5, 2), unit="nm")
    # Version 0.6: named systems, affine maps.
    systems = [{"name": "physical", "axes": axes_of("micrometer")}]
    affine = {"type": "affine", "affine": [[2, 0, 0, 3], [0, 0, 0.5, 2], [0, -1.5, 0, 1]], "input": "0", "output": "physical"}
    newest = image("six.zarr", [{"path": "0", "coordinateTransformations": [affine]}], coordinateSystems=systems)
    zarr_array("six.zarr/0", volume)
    read("ome-affine", newest, volume, origin=(1, 2, 3), steps=((0, 0.5, 0), (-1.5, 0, 0), (0, 0, 2)), unit="\u00b5m")
    image("nowhere.zarr", [{"path": "0", "coordinateTransformations": [{**affine, "output": "stage"}]}], coordinateSystems=systems)
    zarr_array("nowhere.zarr/0", volume)
    refuse("ome-unknown-system", folder / "nowhere.zarr", "the coordinate system 'stage', which it does not describe")
    sequence = {"type": "sequence", "input": "0", "output": "physical",
                "transformations": scale + [{"type": "translation", "translation": [3, 2, 1]}]}
    image("sequence.zarr", [{"path": "0", "coordinateTransformations": [sequence]}], coordinateSystems=systems)
    zarr_array("sequence.zarr/0", volume)
    read("ome-sequence", folder / "sequence.zarr", volume, unit="\u00b5m", **PLACE)
    image("displaced.zarr", [{"path": "0", "coordinateTransformations": [{"type": "displacements", "path": "d"}]}])
    zarr_array("displaced.zarr/0", volume)
    refuse("ome-displacements", folder / "displaced.zarr", "of type 'displacements'")
    read("ome-displacements-settled", folder / "displaced.zarr", volume, options="spacing=0.5:1.5:2,origin=1:2:3", **PLACE)
    write("several.zarr/.zgroup", b'{"zarr_format": 2}')
    write("several.zarr/.zattrs", json.dumps({"multiscales": [
        {"name": name, "axes": axes_of("micrometer"), "datasets": [{"path": name, "coordinateTransformations": scale}]}
        for name in ("raw", "deconvolved")]}).encode())
    zarr_array("several.zarr/raw", volume)
    zarr_array("several.zarr/deconvolved", volume + 1000)
    read("ome-first-of-several", folder / "several.zarr", volume, notice="2 images", **place)
    for chosen in ("2", "deconvolved"):
        read(f"ome-{chosen}-of-several", folder / "several.zarr", volume + 1000, options=f"series={chosen}", **place)
    refuse("ome-unknown-image", folder / "several.zarr", "2 images, but none '3'", options="series=3")
    # bioformats2raw: one image, and two.
    for name, count in (("one", 1), ("two", 2)):
        write(f"{name}.raw.zarr/.zgroup", b'{"zarr_format": 2}')
        write(f"{name}.raw.zarr/.zattrs", b'{"bioformats2raw.layout": 3}')
        for i in range(count):
            image(f"{name}.raw.zarr/{i}", [{"path": "0", "coordinateTransformations": scale}])
            zarr_array(f"{name}.raw.zarr/{i}/0", volume + 1000 * i)
    read("bioformats2raw-one", folder / "one.raw.zarr", volume, **place)
    refuse("bioformats2raw-two", folder / "two.raw.zarr", "it has 2 images: 0, 1")
    read("bioformats2raw-second", folder / "two.raw.zarr", volume + 1000, options="array=1", **place)


def n5():
    def array(path, **attributes):
        write(f"{path}/attributes.json", json.dumps({
            "dimensions": SHAPE[::-1], "blockSize": SHAPE[::-1], "dataType": "int16", "compression": {"type": "raw"}, **attributes}).encode())
        write(f"{path}/0/0/0", struct.pack(">HHIII", 0, 3, *SHAPE[::-1]) + volume.astype(">i2").tobytes())
        return folder / path

    transform = {"axes": ["z", "y", "x"], "scale": [2, 1.5, 0.5], "translate": [3, 2, 1], "units": ["nm"] * 3}
    read("n5-transform", array("transform.n5", transform=transform), volume, unit="nm", **PLACE)
    read("n5-reduced", array("reduced.n5", pixelResolution={"unit": "um", "dimensions": [0.25, 0.75, 2]}, downsamplingFactors=[2, 2, 1]),
         volume, origin=(0.125, 0.375, 0), steps=diagonal(0.5, 1.5, 2), unit="\u00b5m")
    read("n5-offset", array("offset.n5", resolution=[0.5, 1.5, 2], offset=[1, 2, 3]), volume, **PLACE)
    write("group.n5/attributes.json", b'{"n5": "2.5.1"}')
    write("group.n5/em/attributes.json", json.dumps({"resolution": [0.5, 1.5, 2]}).encode())
    array("group.n5/em/s0")
    read("n5-only-array", folder / "group.n5", volume, steps=diagonal(0.5, 1.5, 2))


run_with_packages(itk, minc, vtkhdf, nexus, emd, openpmd, axistags, big_data_viewer, dream3d, netcdf, unwritten)
xarray()
ome()
n5()
