"""Prepares datasets on the workers of a Dask cluster: a LocalCluster, or one of Slurm, LSF or Kubernetes by Dask's own classes.

    from dask.distributed import Client
    import multitetra.dask

    multitetra.dask.prepare(Client(cluster), array, "/shared/big.mtd", spacing=(1, 1, 2))
    multitetra.dask.prepare_series(Client(cluster), "/shared/heart4d.nii.gz", "/shared/heart", "--all-times")

The workers and this process share the folder or the bucket of the output, and import multitetra.
"""

from __future__ import annotations

import os
import subprocess
from typing import Any, Optional

import dask
import numpy as np

from . import VolumeError, _engine
from .programs import server_program
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
        A file in a folder that all workers share, or ``s3://bucket/big.mtd``, whose parts go through the bucket and are merged on
        one worker's disk.
    parts : int, optional
        Two for each worker by default.
    pad_value, pad, **how
        As of `multitetra.Volume`: where samples lie and how they are read.

    Returns
    -------
    str
        The path of the file, or its address.
    """
    output = _whole(output)
    if parts is None:
        parts = max(1, 2 * len(client.scheduler_info()["workers"]))
    if isinstance(data, np.ndarray):
        # Under a key of its own: Dask loses data that is sent again while what had the same hash is being released.
        data = client.scatter(data, broadcast=True, hash=False)
    elif isinstance(data, (str, os.PathLike)):
        data = _whole(data)
    notices = client.submit(_plan, data, output, parts, pad_value, pad, how, pure=False).result()
    client.gather([client.submit(_part, data, output, part, how, pure=False) for part in range(parts)])
    client.submit(_merge, output, pure=False).result()
    _warn(notices)
    return output


def prepare_series(client: Any, source: Any, output: Any, *options: str, parts: Optional[int] = None) -> str:
    """Writes a dataset for each of a file's times, labels or fields: the files that `multitetra-server prepare` writes on one machine.

    Parameters
    ----------
    client : dask.distributed.Client
    source : path
        A file, folder or address that all workers read.
    output : path
        A folder that all workers share, or ``s3://bucket/folder``. Datasets that are up to date stay.
    *options
        Of ``multitetra-server prepare``, such as ``"--all-times"``, ``"--label", "all"`` or ``"--field", "pressure,temperature"``.
    parts : int, optional
        The datasets are divided among so many tasks; two for each worker by default.

    Returns
    -------
    str
        The path of the folder.

    Raises
    ------
    VolumeError
        If a dataset cannot be prepared; those of other tasks stay.
    """
    source, output = _whole(source), _whole(output)
    command = ("prepare", source, "-o", output, "--quiet", *options)
    if parts is None:
        parts = max(1, 2 * len(client.scheduler_info()["workers"]))
    shares = [(*command, "--part", f"{part}/{parts}") for part in range(1, parts + 1)]
    client.gather([client.submit(_run, share, pure=False) for share in shares])
    client.submit(_run, command, pure=False).result()  # Also removes times, labels and fields that the source no longer has.
    return output


def _whole(place):
    """Addresses as they are, paths from the root, since workers run in other folders."""
    place = os.fspath(place)
    return place if "://" in place else os.path.abspath(place)


def _run(command):
    program = server_program()
    if program is None:
        raise VolumeError("Series are prepared by multitetra-server, which this package lacks: build multitetra_server_program.")
    done = subprocess.run([program, *command], capture_output=True, text=True)
    if done.returncode != 0:
        raise VolumeError(done.stderr.strip())


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
