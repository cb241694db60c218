"""Common parts of the scripts that write volumes for tests. Their first argument is the output folder."""
import pathlib
import sys

import numpy

folder = pathlib.Path(sys.argv[1])


def write(name, data):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def run_with_packages(*writers):
    """Runs the writers; prints a line for each whose Python package is missing."""
    for writer in writers:
        try:
            writer()
        except ImportError as problem:
            print("missing", problem.name, sep="\t")


def zarr_2_format():
    """The arguments that make the zarr package write format 2, in its versions 2 and 3."""
    import zarr
    return {"zarr_format": 2} if zarr.__version__ >= "3" else {}


# ---- expectations, read by odd_volumes_test.cpp

def expect_read(name, path, samples, origin=(0, 0, 0), steps=((1, 0, 0), (0, 1, 0), (0, 0, 1)), unit="", notice="", options="",
                labels=""):
    """`labels`: value:name:color:layer, separated by semicolons."""
    expected = write(f"expected/{name}", numpy.ascontiguousarray(samples).astype("<f4").tobytes())
    numbers = [*samples.shape[::-1], *origin, *(n for step in steps for n in step)]
    print("read", name, path, options, expected, *numbers, unit, notice, labels, sep="\t")


def expect_refused(name, path, sentence, options="", remedy=""):
    """With `remedy`, an option of VolumeChoice that the message names, the volume is read."""
    print("refuse", name, path, options, sentence, remedy, sep="\t")


def diagonal(sx, sy, sz):
    return ((sx, 0, 0), (0, sy, 0), (0, 0, sz))


# ---- DICOM

def dicom_image(number, rows, columns, kind="1.2.840.10008.5.1.4.1.1.2", syntax="1.2.840.10008.1.2.1"):
    """A signed 16-bit image without pixels and position."""
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import UID
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = kind
    meta.MediaStorageSOPInstanceUID = f"1.2.3.{number}"
    meta.TransferSyntaxUID = UID(syntax)
    data = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    data.is_little_endian, data.is_implicit_VR = True, False
    data.SOPClassUID, data.SOPInstanceUID = kind, meta.MediaStorageSOPInstanceUID
    data.SeriesInstanceUID, data.StudyInstanceUID, data.PatientID = "1.2.3.100", "1.2.3.200", "one"
    data.Modality, data.InstanceNumber = "CT", number
    data.Rows, data.Columns = rows, columns
    data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
    data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 1
    return data


def dicom_save(data, *path):
    import pydicom
    path = folder.joinpath(*path)
    path.parent.mkdir(parents=True, exist_ok=True)
    pydicom.dcmwrite(path, data, write_like_original=False)
    return path


def dicom_items(**elements):
    """A sequence of one item."""
    from pydicom.dataset import Dataset
    from pydicom.sequence import Sequence
    item = Dataset()
    for key, value in elements.items():
        setattr(item, key, value)
    return Sequence([item])
