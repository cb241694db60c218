"""Users of a Multi-Tetra server for Locust: streams over WebSockets and HTTP requests, side by side.

    PYTHONPATH=build/release/python locust -f client/load/locust/locustfile.py --host http://127.0.0.1:7480 \\
        --headless --users 50 --spawn-rate 10 --run-time 60s

Times in Locust's table: "first step" and "surface" of streams, and those of HTTP requests. A step that does not pass the
checks of the package is a failure. Environment: MULTITETRA_TOKEN, MULTITETRA_DATASET, MULTITETRA_CA (a PEM file).
"""

import os
import random
import time

import multitetra
from gevent import get_hub
from locust import FastHttpUser, User, between, events, task

TOKEN = os.environ.get("MULTITETRA_TOKEN", "")
DATASET = os.environ.get("MULTITETRA_DATASET", "")
CA = os.environ.get("MULTITETRA_CA")
ERRORS = (0.5, 1.0, 2.0, 4.0)
ISOVALUES = 32

# The package waits in C++, unseen by gevent, so each user waits in its own thread.
get_hub().threadpool.maxsize = 1000


def isovalue_of(low, high):
    """One of a few, so that users meet in the server's cache."""
    return low + (high - low) * (0.25 + 0.5 * (random.randrange(ISOVALUES) + 0.5) / ISOVALUES)


def in_thread(function, *arguments):
    return get_hub().threadpool.apply(function, arguments)


def connect(host):
    server = multitetra.connect(host.replace("http", "ws", 1), token=TOKEN, ca=CA)
    return server, [info for info in server.datasets() if DATASET in ("", info.name)]


def surface(server, info, isovalue, error):
    """Seconds until the first step, and bytes of payload of one stream."""
    began, first, size = time.perf_counter(), None, 0
    for step in server.steps(info.name, isovalue, error=error):
        first = first or time.perf_counter() - began
        size += step.payload_bytes
    return first, size


class Viewer(User):
    """Looks at surfaces over a WebSocket."""

    weight = 3
    wait_time = between(0.5, 3)

    def on_start(self):
        self.server = None

    def on_stop(self):
        if self.server:
            self.server.close()

    @task
    def look(self):
        began = time.perf_counter()

        def report(name, seconds=None, size=0, failure=None):
            events.request.fire(
                request_type="WS",
                name=name,
                response_time=1000 * (time.perf_counter() - began if seconds is None else seconds),
                response_length=size,
                exception=failure,
                context={},
            )

        try:
            if self.server is None:
                self.server, self.datasets = in_thread(connect, self.host)
                report("connect")
                began = time.perf_counter()
            info = random.choice(self.datasets)
            isovalue = isovalue_of(info.min, info.max)
            first, size = in_thread(surface, self.server, info, isovalue, random.choice(ERRORS))
            report("first step", first)
            report("surface", size=size)
        except (multitetra.CheckError, multitetra.ServerError, OSError, IndexError) as failure:
            report("surface", failure=failure)
            self.on_stop()
            self.server = None


class Script(FastHttpUser):
    """Fetches whole meshes over HTTP, as scripts and pipelines do."""

    weight = 1
    wait_time = between(1, 5)

    @property
    def headers(self):
        return {"Authorization": f"Bearer {TOKEN}"} if TOKEN else {}

    def on_start(self):
        self.mesh()  # Every script gets its result, however short the run is.

    @task(1)
    def datasets(self):
        self.client.get("/v1/datasets", headers=self.headers)

    @task(4)
    def mesh(self):
        listed = self.client.get("/v1/datasets", headers=self.headers).json()
        infos = [info for info in listed["datasets"] if DATASET in ("", info["name"])]
        info = random.choice(infos)
        isovalue, error = isovalue_of(info["min"], info["max"]), random.choice(ERRORS[1:])
        self.client.get(
            f"/v1/datasets/{info['name']}/isosurface?isovalue={isovalue}&error={error}&format=glb",
            name="/v1/datasets/NAME/isosurface",
            headers=self.headers,
        )
