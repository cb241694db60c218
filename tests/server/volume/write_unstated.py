"""Writes a volume in each format that states no spacing, and prints the name of the format, its path and what is known of values, or
why a file of this format cannot be without."""
import json
import struct

import numpy

from volume_writing import folder, write

volume = numpy.arange(24, dtype="<i2").reshape(2, 3, 4)
samples = volume.tobytes()


def nrrd():
    return write("v.nrrd", b"NRRD0005\ntype: int16\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: raw\n\n" + samples)


def meta_image():
    return write("v.mha", b"NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" + samples)


def nifti():
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 4, 3, 2, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<f", header, 108, 352)
    header[344:348] = b"n+1\0"
    return write("v.nii", bytes(header) + samples)


def tiff():
    import tifffile
    tifffile.imwrite(folder / "v.tif", volume.astype("u2"), photometric="minisblack", metadata=None)
    return folder / "v.tif"


def image_stack():
    from PIL import Image
    (folder / "stack").mkdir()
    for z in range(2):
        Image.fromarray(volume[z].astype("u1")).save(folder / f"stack/{z}.png")
    return folder / "stack"


def zarr():
    write("v.zarr/.zarray", json.dumps({
        "zarr_format": 2, "shape": volume.shape, "chunks": volume.shape, "dtype": "<i2", "compressor": None, "fill_value": 0, "order": "C",
        "filters": None}).encode())
    return write("v.zarr/0.0.0", samples).parent


def hdf5():
    import h5py
    with h5py.File(folder / "v.h5", "w") as file:
        file["v"] = volume
    return folder / "v.h5"


def netcdf():
    import netCDF4
    with netCDF4.Dataset(folder / "v.nc", "w", format="NETCDF3_CLASSIC") as file:
        for name, size in zip("zyx", volume.shape):
            file.createDimension(name, size)
        file.createVariable("v", "i2", tuple("zyx"))[:] = volume
    return folder / "v.nc"


def npy():
    numpy.save(folder / "v.npy", volume)
    return folder / "v.npy"


def mgh():
    return write("v.mgh", struct.pack(">7ih", 1, 4, 3, 2, 1, 4, 0, 0).ljust(284, b"\0") + volume.astype(">i2").tobytes())


def mrc():
    header = bytearray(1024)
    struct.pack_into("<4i", header, 0, 4, 3, 2, 1)
    struct.pack_into("<3i", header, 64, 1, 2, 3)
    header[208:216] = b"MAP DD\0\0"
    return write("v.mrc", bytes(header) + samples)


def raw_description():
    write("described.raw", samples)
    return write("v.dat", b"ObjectFileName: described.raw\nResolution: 4 3 2\nFormat: SHORT\n")


def raw():
    return write("v_4x3x2_int16.raw", samples)


def dicom():
    from volume_writing import dicom_image, dicom_save
    data = dicom_image(1, 3, 4)
    data.PixelData = volume[0].tobytes()
    return dicom_save(data, "v.dcm")


def vti():
    return write("v.vti", b"""<VTKFile type="ImageData" byte_order="LittleEndian"><ImageData WholeExtent="0 3 0 2 0 1" Origin="0 0 0"
        Spacing="1 1 1"><Piece Extent="0 3 0 2 0 1"><PointData><DataArray type="Int16" Name="v" format="ascii">"""
                 + " ".join(map(str, volume.ravel())).encode() + b"</DataArray></PointData></Piece></ImageData></VTKFile>")


def vtk():
    return write("v.vtk", b"# vtk DataFile Version 3.0\n\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nORIGIN 0 0 0\nSPACING 1 1 1\n"
                 b"POINT_DATA 24\nSCALARS v short\nLOOKUP_TABLE default\n" + " ".join(map(str, volume.ravel())).encode() + b"\n")


def big_data_viewer():
    import h5py
    with h5py.File(folder / "bdv.h5", "w") as file:
        file["s00/resolutions"] = numpy.array([[1.0, 1, 1]])
        file["t00000/s00/0/cells"] = volume
    return write("bdv.xml", b"""<SpimData><SequenceDescription><ImageLoader format="bdv.hdf5"><hdf5>bdv.h5</hdf5></ImageLoader>
        <ViewSetups><ViewSetup><id>0</id></ViewSetup></ViewSetups></SequenceDescription></SpimData>""")


def cube():
    return write("v.cube", b"a\nb\n0 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n" + " ".join(map(str, volume.ravel())).encode() + b"\n")


# How scaling, sign and missing values are known; "values" for files that cannot be without a spacing.
DEFINED, TYPED, OPEN = ("by format",) * 3, ("by format", "stated", "by format"), ("assumed", "stated", "assumed")
FORMATS = [
    ("file", "NRRD", nrrd, TYPED), ("file", "MetaImage", meta_image, TYPED), ("file", "NIfTI 1 and 2, Analyze", nifti, TYPED),
    ("file", "MGH", mgh, TYPED), ("values", "DICOM", dicom, ("assumed", "stated", "by format")), ("file", "OME-Zarr 0.1 to 0.6", zarr, OPEN),
    ("reason", "Zarr 2 and 3, N5", "is recognized as OME-Zarr", ()), ("values", "VTK image data", vti, TYPED),
    ("values", "legacy VTK", vtk, TYPED), ("file", "TIFF", tiff, DEFINED), ("file", "PNG, JPEG", image_stack, DEFINED),
    ("file", "HDF5", hdf5, OPEN), ("reason", "Imaris", "states its extent", ()),
    ("file", "BigDataViewer", big_data_viewer, ("by format", "assumed", "by format")), ("file", "NetCDF 3 and 4", netcdf, OPEN),
    ("file", "NumPy", npy, TYPED), ("file", "MRC and CCP4", mrc, DEFINED), ("values", "cube", cube, DEFINED),
    ("file", "raw", raw_description, TYPED), ("file", "raw", raw, TYPED)]
for kind, name, writer, values in FORMATS:
    try:
        print(kind, name, writer if kind == "reason" else writer(), *values, sep="\t")
    except ImportError as problem:
        print("missing", problem.name, sep="\t")
        print("reason", name, "not tested", sep="\t")
