"""A plugin of napari: opens the viewer's address as a surface and, with dask, the samples as an image that is fetched lazily.

    napari --plugin multitetra "http://127.0.0.1:7480/#dataset=head&isovalue=500.5&error=1"

    viewer = napari.Viewer(ndisplay=3)
    for data, options, kind in multitetra.napari_reader.layers("http://127.0.0.1:7480/#dataset=head"):
        viewer._add_layer_from_data(data, options, kind)

Layers are in world coordinates of the dataset, in napari's order of axes: z, y, x.
"""

import re
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
    error = float(chosen.get("error", 0.25))
    infos = chosen_datasets(server.datasets(), chosen, url)
    surfaces = []
    for info in infos:
        is_label = info.member is not None and info.member.label is not None
        if "isovalue" in chosen and not is_label:
            isovalue = float(chosen["isovalue"])
        elif len(info.suggested_isovalues) == 0:
            continue  # All samples are equal: no surface to show.
        else:
            isovalue = info.suggested_isovalues[0]
        mesh = server.isosurface(info.name, isovalue, error=error)
        surfaces.append(surface_layer(mesh, label_name(info) if is_label else f"{info.name} at {isovalue:g}"))
    try:
        import dask.array
    except ImportError:
        return surfaces
    if infos[0].member is not None and infos[0].member.label is not None:
        return surfaces
    samples = dask.array.from_array(server.array(infos[0].name), chunks=(128, 128, 128), lock=True)
    return [image_layer(samples, infos[0]), *surfaces]


def chosen_datasets(infos, chosen, url):
    """The datasets that an address shows: that of its name or the first of the series of that name, or the named labels."""
    name = chosen.get("dataset", infos[0].name if infos else "")
    named = [info for info in infos if info.name == name] or [info for info in infos if info.member and info.member.series == name]
    if not named:
        known = list(dict.fromkeys(info.member.series if info.member else info.name for info in infos))
        some = ", ".join(known[:10]) + (", ..." if len(known) > 10 else "")
        raise ValueError(f"There is no dataset '{name}' at {url}; there are {some}.")
    if "labels" not in chosen:
        return named[:1]
    labels = {
        info.member.label.value: info
        for info in infos
        if named[0].member and info.member and info.member.label and info.member.series == named[0].member.series
    }
    found = [labels[value] for value in labels_of_ranges(chosen["labels"], sorted(labels))]
    if not found:
        raise ValueError(f"'{name}' has no labels {chosen['labels']}.")
    return found


def labels_of_ranges(text, values):
    """The ones among `values` that the text of a viewer's address names: "1-322,-17" (1 to 322 without 17), "-17" (all but 17) or "none"."""
    shown = set(values) if text.startswith("-") else set()
    for word in text.split(","):
        found = re.fullmatch(r"(-?)(\d+)(?:-(\d+))?", word)
        if not found:
            continue
        first, last = int(found[2]), int(found[3] or found[2])
        inside = {value for value in values if first <= value <= last}
        shown = shown - inside if found[1] else shown | inside
    return sorted(shown)


def label_name(info):
    label = info.member.label
    return label.name or f"label {label.value:.0f}"


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
