"""Checks that meshes have the same world coordinates as in VTK: compares bounding box and centroid with those of VTK's
flying edges, each with the affine map that its own reader finds in the file, oblique ones included.

    space_test.py FOLDER-OF-PROGRAMS FOLDER-OF-PUBLIC-VOLUMES

Exits with 77 if VTK's Python module is missing.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
except ImportError:
    print("!! VTK's Python (python3-vtk9) is missing: places in the world are NOT TESTED against VTK.", file=sys.stderr)
    sys.exit(77)

LPS_OF_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
OBLIQUE = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])

# Public volumes that VTK reads, with an isovalue. The large ones run when MULTITETRA_ALL_TESTS is set.
SMALL = 1 << 20  # In samples.
PUBLIC = {
    "HeadMRVolume/HeadMRVolume.mhd": 25, "Brain_float/Brain.mhd": 60, "ironProt.vtk": 80, "hydrogen.vti": 0.1,
    "hydrogen.vtk": 0.1, "viscousfingers_060_density_064.vti": 35, "avg152T1_RL_nifti.nii.gz": 175,
    "bonsai_small/bonsai_small.mhd": 110, "engine/engine.mhd": 180, "frogtissue/frogtissue.mhd": 0.5,
    "embryo_256x256x256.vti": 80, "Iguana.nii.gz": 40, "chris_t1.nii.gz": 105,
}


def read_by_vtk(path):
    """Returns the samples and their map to the world (4 x 4), in LPS for medical files."""
    name = path.name
    reader = {".mhd": vtk.vtkMetaImageReader, ".vtk": vtk.vtkStructuredPointsReader, ".vti": vtk.vtkXMLImageDataReader,
              ".nii": vtk.vtkNIFTIImageReader}[".nii" if ".nii" in name else path.suffix]()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    affine = np.diag([*image.GetSpacing(), 1.0])
    affine[:3, 3] = image.GetOrigin()
    direction = image.GetDirectionMatrix()
    turn = np.array([[direction.GetElement(i, j) for j in range(3)] for i in range(3)])
    affine[:3, :3] = turn @ affine[:3, :3]
    if ".nii" in name:
        matrix = reader.GetSFormMatrix() or reader.GetQFormMatrix()
        scale = np.diag([*image.GetSpacing(), 1.0])
        turn = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
        affine = LPS_OF_RAS @ turn @ scale
    return image, affine


def flying_edges(image, isovalue, affine):
    """Returns vertices in world coordinates, and triangles; uses only the samples of `image`."""
    plain = vtk.vtkImageData()
    plain.SetDimensions(image.GetDimensions())
    plain.GetPointData().SetScalars(image.GetPointData().GetScalars())
    edges = vtk.vtkFlyingEdges3D()
    edges.SetInputData(plain)
    edges.SetValue(0, isovalue)
    edges.ComputeNormalsOff()
    edges.Update()
    points, triangles = arrays_of(edges.GetOutput())
    return points @ affine[:3, :3].T + affine[:3, 3], triangles


def arrays_of(surface):
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    return points, vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def our_surface(server, path, isovalue, folder):
    dataset, mesh = folder / "dataset.mtd", folder / "mesh.ply"
    subprocess.run([server, "prepare", path, "-o", dataset, "--quiet"], check=True)
    info = json.loads(subprocess.run([server, "info", dataset, "--json"], check=True, capture_output=True).stdout)
    subprocess.run([server, "extract", dataset, "--isovalue", str(isovalue), "--error", "0", "-o", mesh, "--quiet"],
                   check=True)
    reader = vtk.vtkPLYReader()
    reader.SetFileName(str(mesh))
    reader.Update()
    return *arrays_of(reader.GetOutput()), info


def measures(points, triangles):
    """Returns the low and the high corner of the bounding box, the centroid and the area."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    centroid = (areas[:, None] * (a + b + c)).sum(axis=0) / (3 * areas.sum())
    used = points[np.unique(triangles)]
    return used.min(axis=0), used.max(axis=0), centroid


def check(name, server, path, isovalue, affine=None):
    """`affine` is for files whose map VTK's reader does not return."""
    image, file_affine = read_by_vtk(path)
    if image.GetNumberOfPoints() > SMALL and not os.environ.get("MULTITETRA_ALL_TESTS"):
        print(f"!! {name} is large: NOT TESTED (tests/run.sh --all).", file=sys.stderr)
        return True
    affine = file_affine if affine is None else affine
    theirs = measures(*flying_edges(image, isovalue, affine))
    with tempfile.TemporaryDirectory() as folder:
        points, triangles, info = our_surface(server, path, isovalue, pathlib.Path(folder))
    ours = measures(points, triangles)
    voxel = np.linalg.norm(affine[:3, :3], axis=0).min()
    # Both surfaces cross the edges of the grid, ours also its diagonals: in noise it has more area.
    corner = max(np.abs(theirs[0] - ours[0]).max(), np.abs(theirs[1] - ours[1]).max()) / voxel
    center = np.abs(theirs[2] - ours[2]).max() / voxel
    print(f"{name}: corners of the box {corner:.3f} voxels apart, centroids {center:.3f} ({info.get('space', 'no space')})")
    return corner < 0.5 and center < 0.5


def write_oblique(folder):
    """Writes an asymmetric blob with rotated axes: a .vti, a .mhd, and a .nii with another slice thickness."""
    nx, ny, nz = 24, 20, 16
    z, y, x = np.mgrid[0:nz, 0:ny, 0:nx].astype(np.float32)
    field = np.exp(-((x - 9) ** 2 / 30 + (y - 12) ** 2 / 14 + (z - 6) ** 2 / 9)).astype(np.float32)
    image = vtk.vtkImageData()
    image.SetDimensions(nx, ny, nz)
    image.GetPointData().SetScalars(numpy_to_vtk(field.ravel(), deep=True))
    image.GetPointData().GetScalars().SetName("field")
    spacing, origin = (0.5, 0.75, 1.25), (-7.0, 11.0, 100.0)
    affine = np.eye(4)
    affine[:3, :3] = OBLIQUE @ np.diag(spacing)
    affine[:3, 3] = origin
    image.SetSpacing(spacing)
    image.SetOrigin(origin)
    image.SetDirectionMatrix(OBLIQUE.ravel().tolist())
    writer = vtk.vtkXMLImageDataWriter()
    writer.SetFileName(str(folder / "oblique.vti"))
    writer.SetInputData(image)
    writer.Write()
    axes = " ".join(str(number) for number in OBLIQUE.T.ravel())  # Column by column.
    (folder / "oblique.mhd").write_text(
        f"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nTransformMatrix = {axes}\n"
        f"Offset = {' '.join(map(str, origin))}\nElementSpacing = {' '.join(map(str, spacing))}\nDimSize = {nx} {ny} {nz}\n"
        "ElementType = MET_FLOAT\nElementDataFile = oblique.raw\n")
    (folder / "oblique.raw").write_bytes(field.tobytes())
    writer = vtk.vtkNIFTIImageWriter()
    writer.SetFileName(str(folder / "oblique.nii"))
    plain = vtk.vtkImageData()
    plain.DeepCopy(image)
    plain.SetOrigin(0, 0, 0)
    plain.SetDirectionMatrix(np.eye(3).ravel().tolist())
    writer.SetInputData(plain)
    turn = vtk.vtkMatrix4x4()
    for i in range(3):
        for j in range(3):
            turn.SetElement(i, j, OBLIQUE[i][j])
        turn.SetElement(i, 3, origin[i])
    writer.SetSFormMatrix(turn)
    writer.SetQFormMatrix(turn)
    writer.Write()
    return affine


def main(programs, public):
    server = pathlib.Path(programs) / "multitetra-server"
    good = True
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        affine = write_oblique(folder)
        for file, known in (("oblique.vti", None), ("oblique.mhd", affine), ("oblique.nii", None)):
            good &= check(file, server, folder / file, 0.4, known)
    public = pathlib.Path(public)
    if not public.is_dir():
        print(f"!! {public} is missing: places of public volumes are NOT TESTED.", file=sys.stderr)
        return good
    for name, isovalue in PUBLIC.items():
        good &= check(name, server, public / name, isovalue)
    return good


if __name__ == "__main__":
    sys.exit(0 if main(*sys.argv[1:3]) else 1)
