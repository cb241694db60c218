#!/usr/bin/env python3
"""A surface from a server, step by step, as in a notebook.

    PYTHONPATH=build/release/python python3 client/python/examples/surface.py ws://127.0.0.1:7480 [DATASET [ISOVALUE]]
"""

import sys

import numpy as np

import multitetra

# %% Connect and list the datasets.
url = sys.argv[1] if len(sys.argv) > 1 else "ws://127.0.0.1:7480"
server = multitetra.connect(url)
datasets = {info.name: info for info in server.datasets()}
for info in datasets.values():
    print(f"{info.name}: {list(info.dims)} samples, values {info.min:g} to {info.max:g}")

# %% Estimate the size of a surface before it is computed.
info = datasets[sys.argv[2]] if len(sys.argv) > 2 else next(iter(datasets.values()))
isovalue = float(sys.argv[3]) if len(sys.argv) > 3 else info.suggested_isovalues[0]
for error in (4, 1, 0.25):
    size = server.estimate(info.name, isovalue, error=error)
    print(f"at an error of {error} voxels: about {size.triangles} triangles, {size.bytes} bytes")

# %% Stream the surface, coarse steps first. Every step is complete and watertight.
for step in server.steps(info.name, isovalue, error=1.0):
    mesh = step.mesh
    accuracy = f"one sample in {step.spacing}" if step.spacing > 1 else f"error at most {step.error_bound_world:g}"
    print(
        f"step {step.number}{' (final)' if step.is_final else ''}: {len(mesh.faces)} triangles, "
        f"{step.payload_bytes} bytes, {accuracy}, {step.border_edges} border edges"
    )

# %% Fetch it again, finer in a ball in the middle. Cached tiles are not sent again.
center = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2
radius = 0.2 * np.linalg.norm(np.ptp(mesh.vertices, axis=0))
fine = server.isosurface(info.name, isovalue, error=1.0, regions=[multitetra.ball(center, radius, error=0.25)])
print(f"with a finer ball: {len(fine.faces)} triangles, Euler characteristic {fine.euler_characteristic}")

# %% Compute with the arrays.
corners = fine.vertices[fine.faces]
areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
print(f"its area: {areas.sum():.6g}")

# %% With pyvista installed, fine.to_pyvista().plot() shows the surface.
server.close()
