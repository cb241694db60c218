"""Surfaces of an array in Python: multitetra beside scikit-image and VTK's flying edges, in alternation.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/bench/python_surfaces.py [--size 256] [--rounds 3]

Each run is a process of its own. Seconds, and CPU seconds of all threads, are medians over the rounds, from the array to arrays of
vertices and faces; memory is what the call adds at its peak. Holes, topology and the worst distance are those that multitetra.certify finds, against the isosurface of
the samples on tetrahedra, for a corner of the array with at most 96 samples a side. PyMCubes is measured where it is installed.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import time

import numpy as np

ISOVALUE = 0.1


def gyroid(size, period=80):
    """float32 with 2 million triangles by marching cubes at 256 samples a side."""
    sine, cosine = (f(2 * np.pi / period * np.arange(size, dtype=np.float32)) for f in (np.sin, np.cos))
    x, y, z = np.s_[:, None, None], np.s_[None, :, None], np.s_[None, None, :]
    return (sine[x] * cosine[y] + sine[y] * cosine[z] + sine[z] * cosine[x]).astype(np.float32)


def with_multitetra(array, **how):
    import multitetra

    return tuple(multitetra.isosurface(array, ISOVALUE, **how))


def with_scikit_image(array):
    from skimage.measure import marching_cubes

    return marching_cubes(array, ISOVALUE)[:2]


def with_flying_edges(array):
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    image = vtkImageData()
    image.SetDimensions(array.shape[::-1])  # x varies fastest.
    image.GetPointData().SetScalars(numpy_to_vtk(array.ravel()))
    edges = vtkFlyingEdges3D()
    edges.SetInputData(image)
    edges.SetValue(0, ISOVALUE)
    edges.ComputeNormalsOff()
    edges.Update()
    surface = edges.GetOutput()
    faces = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return vtk_to_numpy(surface.GetPoints().GetData())[:, ::-1], faces[:, ::-1]


def with_pymcubes(array):
    import mcubes

    return mcubes.marching_cubes(array, ISOVALUE)


METHODS = {
    "multitetra, exact": lambda array: with_multitetra(array, error=0, simplify=False),
    "multitetra, error 0.25": lambda array: with_multitetra(array, error=0.25),
    "multitetra, error 0.25, not simplified": lambda array: with_multitetra(array, error=0.25, simplify=False),
    "scikit-image": with_scikit_image,
    "VTK flying edges": with_flying_edges,
    "PyMCubes": with_pymcubes,
}
LIBRARIES = {"multitetra": ["multitetra.volume"], "scikit-image": ["skimage.measure"],
             "PyMCubes": ["mcubes"], "VTK": ["vtkmodules.util.numpy_support", "vtkmodules.vtkFiltersCore"]}  # fmt: skip


def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def one_run(name, size):
    array = gyroid(size)
    for library in LIBRARIES[name.split()[0].rstrip(",")]:
        __import__(library)
    before, start, cpu = peak(), time.perf_counter(), time.process_time()
    vertices, faces = METHODS[name](array)
    seconds, cpu, after = time.perf_counter() - start, time.process_time() - cpu, peak()
    found = {"seconds": seconds, "cpu": cpu, "memory": max(0, after - before) / array.nbytes, "triangles": len(faces)}
    print(json.dumps(found))


def compared(name, size):
    import multitetra

    array = gyroid(min(size, 96))
    vertices, faces = METHODS[name](array)
    volume = multitetra.Volume(array)
    for is_inside_out in (False, True):  # Programs differ in the side that triangles face.
        best = multitetra.certify((vertices, faces), volume, ISOVALUE, inside_out=is_inside_out)
        if best.topology_kept:
            break
    mesh = best.report["mesh"]
    found = {"distance": best.distance, "holes": mesh["open_edges"] + mesh["nonmanifold_edges"], "topology": best.topology_kept}
    print(json.dumps(found))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", choices=METHODS)
    parser.add_argument("--compare", action="store_true")
    arguments = parser.parse_args()
    if arguments.only:
        return (compared if arguments.compare else one_run)(arguments.only, arguments.size)
    runs = {name: [] for name in METHODS}

    def run(name, *options):
        """What a process finds; None if it fails, as without the library."""
        words = [sys.executable, __file__, "--only", name, "--size", str(arguments.size), *options]
        made = subprocess.run(words, capture_output=True, text=True, env=os.environ)
        if not made.returncode:
            return json.loads(made.stdout)
        print(f"{name}: {made.stderr.strip().splitlines()[-1]}", file=sys.stderr)

    compare = {name: run(name, "--compare") for name in METHODS}
    for _ in range(arguments.rounds):
        for name, found in runs.items():
            if compare[name] and (one := run(name)):
                found.append(one)
    print("| | seconds | CPU seconds | memory (arrays) | triangles | holes | topology kept | worst distance (voxels) |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | --- | ---: |")
    for name, found in runs.items():
        if found:
            seconds, cpu, memory = (statistics.median(one[key] for one in found) for key in ("seconds", "cpu", "memory"))
            other = compare[name]
            print(f"| {name} | {seconds:.2f} | {cpu:.2f} | {memory:.1f} | {found[0]['triangles']:,} | {other['holes']} | "
                  f"{'yes' if other['topology'] else 'no'} | {other['distance']:.3f} |")  # fmt: skip


if __name__ == "__main__":
    main()
