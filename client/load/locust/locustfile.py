"""Users of a Multi-Tetra server for Locust: WebSocket conversations and HTTP requests, side by side.

    PYTHONPATH=build/release/python locust -f client/load/locust/locustfile.py --host http://127.0.0.1:7480 \\
        --headless --users 50 --spawn-rate 10 --run-time 60s

Times in Locust's table: "first tile" and "surface" of conversations, and those of HTTP requests. A step whose tiles,
counts or digests are not what its manifest says is a failure. Environment: MULTITETRA_TOKEN, MULTITETRA_DATASET.
"""

import os
import random
import time
from urllib.parse import urlsplit

import websocket
from locust import FastHttpUser, User, between, events, task

from multitetra.v1 import conversation_pb2 as pb
from multitetra.v1 import request_pb2

TOKEN = os.environ.get("MULTITETRA_TOKEN", "")
DATASET = os.environ.get("MULTITETRA_DATASET", "")
ERRORS = (0.5, 1.0, 2.0, 4.0)
ISOVALUES = 32


def isovalue_of(low, high):
    """One of a few, so that users meet in the server's cache."""
    return low + (high - low) * (0.25 + 0.5 * (random.randrange(ISOVALUES) + 0.5) / ISOVALUES)


class BrokenPromise(Exception):
    pass


class Conversation:
    """One WebSocket. websocket-client is blocking, which Locust's gevent turns into waiting."""

    def __init__(self, host):
        parts = urlsplit(host)
        scheme = "wss" if parts.scheme == "https" else "ws"
        self._socket = websocket.create_connection(
            f"{scheme}://{parts.netloc}/v1/stream", subprotocols=["multitetra.v1"], timeout=120
        )
        self._last_id = 0
        self.send(hello=pb.Hello(min_version=1, max_version=1, token=TOKEN, agent="locust"))
        self.receive("welcome")
        self.send(list_datasets=pb.ListDatasets(request_id=1))
        datasets = self.receive("dataset_list").datasets
        self.datasets = [info for info in datasets if DATASET in ("", info.name)]

    def send(self, **message):
        self._socket.send_binary(pb.ClientMessage(**message).SerializeToString())

    def receive(self, awaited=None):
        _, content = self._socket.recv_data()
        message = pb.ServerMessage.FromString(content)
        kind = message.WhichOneof("kind")
        if kind == "error":
            raise BrokenPromise(message.error.text)
        if awaited is not None and kind != awaited:
            raise BrokenPromise(f"{kind} came instead of {awaited}")
        return getattr(message, kind) if awaited else (kind, getattr(message, kind))

    def surface(self, info, isovalue, error, on_first_tile):
        """Bytes of payload of one stream, of which everything but the tiles' content is checked."""
        self._last_id += 1
        request = request_pb2.IsosurfaceRequest(isovalue=isovalue, threshold=request_pb2.ThresholdMap(everywhere=error))
        self.send(open_stream=pb.OpenStream(request_id=self._last_id, dataset=info.name, request=request))
        held, total, manifest, came = set(), 0, None, 0
        while True:
            kind, message = self.receive()
            if kind == "step_begin":
                manifest, came = [(tile.digest_high, tile.digest_low, tile.bytes) for tile in message.tiles], 0
            elif kind == "tile":
                high, low, size = manifest[message.index]
                if size != len(message.payload) or (high, low) in held:
                    raise BrokenPromise("a tile comes twice or with other bytes than promised")
                if not held:
                    on_first_tile()
                held.add((high, low))
                total += size
                came += 1
            elif kind == "step_end":
                if came != message.tiles_sent or any((high, low) not in held for high, low, _ in manifest):
                    raise BrokenPromise("a step ends without all its tiles")
                if sum(low for _, low, _ in manifest) % 2**64 != message.digest_low:
                    raise BrokenPromise("a step's digest is not that of its tiles")
            elif kind == "stream_end":
                return total

    def close(self):
        self._socket.close()


class Viewer(User):
    """Looks at surfaces over a WebSocket."""

    weight = 3
    wait_time = between(0.5, 3)

    def on_start(self):
        self.conversation = None

    def on_stop(self):
        if self.conversation:
            self.conversation.close()

    @task
    def look(self):
        began = time.perf_counter()

        def report(name, size=0, trouble=None):
            events.request.fire(
                request_type="WS",
                name=name,
                response_time=(time.perf_counter() - began) * 1000,
                response_length=size,
                exception=trouble,
                context={},
            )

        try:
            if self.conversation is None:
                self.conversation = Conversation(self.host)
                report("connect")
                began = time.perf_counter()
            info = random.choice(self.conversation.datasets)
            size = self.conversation.surface(
                info, isovalue_of(info.min, info.max), random.choice(ERRORS), lambda: report("first tile")
            )
            report("surface", size)
        except (BrokenPromise, OSError, websocket.WebSocketException, IndexError) as trouble:
            report("surface", trouble=trouble)
            if self.conversation:
                self.conversation.close()
            self.conversation = None


class Script(FastHttpUser):
    """Fetches whole meshes over HTTP, as scripts and pipelines do."""

    weight = 1
    wait_time = between(1, 5)

    @property
    def headers(self):
        return {"Authorization": f"Bearer {TOKEN}"} if TOKEN else {}

    def on_start(self):
        self.mesh()  # However short the run is, every script has what it came for.

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
