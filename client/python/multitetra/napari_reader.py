"""A plugin of napari: opens the viewer's address as a surface and, with dask, the samples as an image that is fetched lazily.

    napari --plugin multitetra "http://127.0.0.1:7480/#dataset=head&isovalue=500.5&error=1"

    viewer = napari.Viewer(ndisplay=3)
    for data, options, kind in multitetra.napari_reader.layers("http://127.0.0.1:7480/#dataset=head"):
        viewer._add_layer_from_data(data, options, kind)

Layers are in world coordinates of the dataset, in napari's order of axes: z, y, x.
"""

from urllib.parse import parse_qs, urldefrag

import numpy as np

from .connection import connect

SCHEMES = ("http://", "https://", "ws://", "wss://", "tcp://", "tls://")
REVERSED = [2, 1, 0]  # x, y, z <-> z, y, x


def napari_get_reader(path):
    """The reader of an address; None for what is none, such as a file."""
    is_address = isinstance(path, str) and path.startswith(SCHEMES)
    return layers if is_address else None


def layers(address):
    """Layers as napari takes them from readers: (data, options, kind) each."""
    url, settings = urldefrag(address)
    chosen = {name: values[-1] for name, values in parse_qs(settings).items()}
    server = connect(url)  # Stays open: the image requests its chunks later.
    infos = {info.name: info for info in server.datasets()}
    if "dataset" in chosen and chosen["dataset"] not in infos:
        raise ValueError(f"There is no dataset {chosen['dataset']} at {url}; the datasets are {', '.join(infos)}.")
    info = infos[chosen["dataset"]] if "dataset" in chosen else next(iter(infos.values()))
    isovalue = float(chosen["isovalue"]) if "isovalue" in chosen else info.suggested_isovalues[0]
    mesh = server.isosurface(info.name, isovalue, error=float(chosen.get("error", 0.25)))
    name = f"{info.name} at {isovalue:g}"
    found = [surface_layer(mesh, name)]
    try:
        import dask.array
    except ImportError:
        return found
    return [image_layer(dask.array.from_array(server.array(info.name), chunks=(128, 128, 128), lock=True), info), *found]


def surface_layer(mesh, name):
    values = np.zeros(len(mesh.vertices), np.float32) if mesh.scalars is None else mesh.scalars
    data = (mesh.vertices[:, REVERSED], mesh.faces[:, REVERSED].astype(np.int64), values)
    return data, {"name": name, "shading": "smooth"}, "surface"


def image_layer(samples, info):
    """`samples` are an array by x, y, z."""
    affine = np.eye(4)
    affine[:3, :3] = info.affine[:3, :3][np.ix_(REVERSED, REVERSED)]
    affine[:3, 3] = info.affine[REVERSED, 3]
    return samples.T, {"name": info.name, "affine": affine, "contrast_limits": (info.min, info.max)}, "image"
