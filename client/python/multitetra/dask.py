"""Prepares datasets on the workers of a Dask cluster: a LocalCluster, or one of Slurm, LSF or Kubernetes by Dask's own classes.

    from dask.distributed import Client
    import multitetra.dask

    multitetra.dask.prepare(Client(cluster), array, "/shared/big.mtd", spacing=(1, 1, 2))

The workers and this process share the folder of the output, and import multitetra.
"""

from __future__ import annotations

import os
from typing import Any, Optional

import dask
import numpy as np

from . import _engine
from .volume import _call, _source, _warn

_PLACEMENT = {"spacing": None, "origin": None, "affine": None, "unit": "", "name": None, "subtract": 0.0, "allow_loss": False}


def prepare(client: Any, data: Any, output: Any, *, parts: Optional[int] = None, pad_value: Optional[float] = None, pad: Optional[int] = None, **how: Any) -> str:
    """Writes a prepared dataset in parts: bit for bit the file that `multitetra.prepare` writes on one machine.

    Parameters
    ----------
    client : dask.distributed.Client
    data : array_like or path
        As of `multitetra.Volume`; each worker reads the slabs that its parts need, so dask and Zarr arrays and paths are not copied
        to every worker.
    output : path
        A file in a folder that all workers share. Parts that an earlier, interrupted call has made with the same arguments stay.
    parts : int, optional
        Two for each worker by default.
    pad_value, pad, **how
        As of `multitetra.Volume`.

    Returns
    -------
    str
        The path of the file.
    """
    output = os.path.abspath(os.fspath(output))
    if parts is None:
        parts = max(1, 2 * len(client.scheduler_info()["workers"]))
    if isinstance(data, np.ndarray):
        data = client.scatter(data, broadcast=True)
    elif isinstance(data, (str, os.PathLike)):
        data = os.fspath(data) if "://" in os.fspath(data) else os.path.abspath(os.fspath(data))
    notices = client.submit(_plan, data, output, parts, pad_value, pad, how, pure=False).result()
    client.gather([client.submit(_part, data, output, part, how, pure=False) for part in range(parts)])
    client.submit(_merge, output, pure=False).result()
    _warn(notices)
    return output


def _opened(data, how):
    placement = {name: how.get(name, usual) for name, usual in _PLACEMENT.items()}
    reading = {name: value for name, value in how.items() if name not in _PLACEMENT}
    return _source(data, *placement.values(), reading)[0]


def _plan(data, output, parts, pad_value, pad, how):
    with dask.config.set(scheduler="threads"):  # Of slabs of dask arrays: a worker does not wait for others.
        source = _opened(data, how)
        _engine.plan_parts(source, output, parts, _call(pad_value, pad, 0, None))
        return source.notices


def _part(data, output, part, how):
    with dask.config.set(scheduler="threads"):
        _engine.prepare_part(_opened(data, how), output, part, 0)


def _merge(output):
    _engine.merge_parts(output)
