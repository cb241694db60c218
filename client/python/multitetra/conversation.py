"""A conversation with a server: lists, and surfaces step by step."""

import inspect
import warnings
from dataclasses import dataclass

import numpy as np

from .border import data_border, edges_inside
from .mesh import DamagedTile, Mesh, count_edges, decode_tile, positioned, weld, with_scalars
from .request import isosurface_request, scalar_request, takes_a_request
from .samples import ProbedPlace, SampledSlice, probe_message, slice_message
from .transport import open_transport
from .v1 import conversation_pb2 as pb

PROTOCOL_VERSION = 1


class ServerError(Exception):
    """The server says no; `code` is the name of its ErrorCode."""

    def __init__(self, reply):
        self.code = pb.ErrorCode.Name(reply.code).removeprefix("ERROR_CODE_").lower()
        super().__init__(f"{reply.text} ({self.code})")


class CheckError(Exception):
    """What came contradicts itself or the request."""


class EmptySurfaceWarning(UserWarning):
    """The surface that was asked for has no triangle."""


@dataclass
class Step:
    number: int
    is_final: bool
    error_bound_world: float  # Of the distance to the full surface, where spacing is 1; see StepBegin.
    spacing: int  # Of a preview: it looks at one sample in so many along each axis, and has no bound. Else 1.
    mesh: Mesh
    digest: str  # Of all triangles, as reports of multitetra-client have it.
    border_edges: int  # Edges of one triangle, all of them where the data ends.
    euler_characteristic: int
    preserves_topology: bool  # Of the full-resolution surface.
    tiles_received: int
    payload_bytes: int
    scalar_deviation: float = 0.0  # How far colours between vertices may be off, in values of color_by.


@dataclass
class Estimate:
    """About how large a surface will be."""

    triangles: int
    bytes: int
    error_world: float  # The largest that is allowed anywhere.


# What an estimate is asked with; colours do not count.
ESTIMATED = inspect.signature(isosurface_request).parameters
MAX_HELD_TILES = 4096
MAX_HELD_TRIANGLES = 20_000_000


def connect(url, token="", ca=None, insecure=False, timeout=60.0):
    """Connects to ws://HOST:PORT, wss://, tcp:// or tls://; `ca` is a PEM file to trust instead of the system's."""
    transport = open_transport(url, ca, insecure, timeout)
    try:
        return Connection(transport, token)
    except BaseException:
        transport.close()
        raise


class Connection:
    """One request at a time. Tiles that came are kept for later requests, and not sent again."""

    def __init__(self, transport, token):
        self._transport = transport
        self._last_id = 0
        self._held = {}  # Digest -> tile, the oldest first.
        self._held_triangles = 0
        self._infos = {}
        hello = pb.Hello(
            min_version=PROTOCOL_VERSION,
            max_version=PROTOCOL_VERSION,
            codecs=[pb.PAYLOAD_CODEC_DRACO_LATTICE],
            token=token,
            agent="multitetra-python",
        )
        self._send(hello=hello)
        self._receive("welcome")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._transport.close()

    def datasets(self):
        """DatasetInfo messages: name, dims, min, max, suggested_isovalues and so on."""
        self._send(list_datasets=pb.ListDatasets(request_id=1))
        datasets = list(self._receive("dataset_list").datasets)
        self._infos = {info.name: info for info in datasets}
        return datasets

    def family(self, name):
        """The DatasetInfo messages of a family's members (times, fields, labels), by field, time and label.

        What each is among them is in its `member`: field, time (if HasField("time")) and time_unit, label.
        """
        members = [info for info in self.datasets() if info.HasField("member") and info.member.family == name]
        return sorted(members, key=lambda info: (info.member.field, info.member.time, info.member.label.value))

    @takes_a_request
    def isosurface(self, dataset, isovalue, **request):
        """The surface as it was asked for, without previews: a Mesh."""
        for step in self.steps(dataset, isovalue, final_only=True, **request):
            mesh = step.mesh
        return mesh

    @takes_a_request
    def estimate(self, dataset, isovalue, **request):
        """How large the surface would be, without making it: an Estimate."""
        self._info(dataset)
        asked = isosurface_request(isovalue, **request)
        reply = self._answer("estimate", pb.Estimate(dataset=dataset, request=asked))
        return Estimate(reply.triangles, reply.bytes, reply.threshold_world)

    def slice(self, dataset, axis=None, at=None, **plane):
        """The samples on a plane: a SampledSlice, whose `values` are an array (height, width), NaN without a field.

        axis, at: the layer of samples across x, y or z with that index (default: the middle one across z), a pixel each
        or origin, right, down, width, height: the middle of the first pixel, the steps to the next one of its row and
            column, and how many there are; coordinates: world or index
        interpolation: nearest or linear; detail: auto, full (all samples) or coarse (every eighth)
        """
        message = slice_message(self._info(dataset), axis, at, **plane)
        reply = self._answer("slice", message)
        if (reply.width, reply.height) != (message.width, message.height):
            raise CheckError("The slice that came has other pixels than were asked for.")
        return SampledSlice(reply)

    def probe(self, dataset, places, coordinates="world"):
        """What the field is at places (n, 3): a ProbedPlace each, with value and gradient or None."""
        self._info(dataset)
        message = probe_message(dataset, places, coordinates)
        reply = self._answer("probe", message)
        if 3 * len(reply.places) != len(message.places):
            raise CheckError("The answer has other places than were asked for.")
        return [ProbedPlace(place) for place in reply.places]

    @takes_a_request
    def isosurfaces(self, dataset, isovalues, **request):
        """Several surfaces of a dataset: a Mesh for each isovalue. A budget is shared by all of them."""
        budgets = [dict(request) for _ in isovalues]
        for limit, size in (("max_triangles", "triangles"), ("max_bytes", "bytes")):
            budget = request.get(limit, 0)
            if budget == 0:
                continue
            if budget < len(isovalues):
                raise ValueError(f"{limit} is {budget}; {len(isovalues)} surfaces cannot share that.")
            alone = {name: value for name, value in request.items() if not name.startswith("max_") and name in ESTIMATED}
            sizes = [max(getattr(self.estimate(dataset, one, **alone), size), 1) for one in isovalues]
            for own, one in zip(budgets, sizes):
                own[limit] = 1 + (budget - len(isovalues)) * one // sum(sizes)
        return [self.isosurface(dataset, one, **own) for one, own in zip(isovalues, budgets)]

    @takes_a_request
    def steps(self, dataset, isovalue, final_only=False, color_by=None, color_range=None, **request):
        """Yields Steps, coarse first; the last one is the surface as it was asked for.

        color_by: a dataset in the same world, whose values at the vertices are `scalars` of the mesh; color_range:
            (low, high), which values they span, those of that dataset if None
        """
        info = self._info(dataset)
        self._last_id += 1
        asked = isosurface_request(isovalue, **request)
        held = self._held_for(asked)
        policy = pb.STEP_POLICY_FINAL_ONLY if final_only else pb.STEP_POLICY_PROGRESSIVE
        open_stream = pb.OpenStream(
            request_id=self._last_id, dataset=dataset, request=asked, steps=policy, held=b"".join(held),
            scalars=scalar_request(color_by, color_range),
        )  # fmt: skip
        self._send(open_stream=open_stream)
        tiles = {digest: self._held[digest] for digest in held}
        codes = {}  # Of tiles that are coloured.
        number = 0
        euler_characteristic = None  # Of all steps that preserve the topology.
        try:
            while True:
                kind, message = self._next_of_stream()
                if kind == "stream_end":
                    if message.outcome != pb.STREAM_OUTCOME_COMPLETE or message.steps != number:
                        raise CheckError("The stream ends without its final step.")
                    return
                if kind != "step_begin" or message.step != number:
                    raise CheckError(f"Step {number} was due.")
                step = self._step(info, message, tiles, codes, color_by is not None)
                if step.preserves_topology:
                    if euler_characteristic not in (None, step.euler_characteristic):
                        raise CheckError(f"Step {number} has another topology than a step before.")
                    euler_characteristic = step.euler_characteristic
                if step.is_final and len(step.mesh.faces) == 0:
                    warnings.warn(_empty_text(isovalue, info), EmptySurfaceWarning, stacklevel=2)
                yield step
                number += 1
        except GeneratorExit:  # Left by its user.
            self._send(cancel=pb.Cancel(request_id=self._last_id))
            raise

    def _step(self, info, begin, tiles, codes, is_coloured):
        """Receives the tiles of a step, and their codes, up to its end."""
        if begin.HasField("scalars") != is_coloured:
            raise CheckError(f"Step {begin.step}: its scalars are not those that were asked for.")
        request = begin.request
        names = [_digest_bytes(tile) for tile in begin.tiles]
        came = payload_bytes = 0
        while True:
            kind, message = self._next_of_stream()
            if kind == "step_end":
                break
            if kind == "tile_scalars" and is_coloured and message.step == begin.step and message.index < len(names):
                codes[names[message.index]] = message
                continue
            if kind != "tile" or message.step != begin.step or message.index >= len(names):
                raise CheckError(f"Step {begin.step}: a message that has no place there.")
            summary, name = begin.tiles[message.index], names[message.index]
            if name in tiles or len(message.payload) != summary.bytes:
                raise CheckError(f"Step {begin.step}: tile {message.index} comes twice or with other bytes.")
            try:
                tiles[name] = decode_tile(
                    message.payload, summary, request.lattice_resolution or 5, request.normal_bits
                )
            except DamagedTile as damage:
                raise CheckError(f"Step {begin.step}: tile {message.index}: {damage}") from None
            self._keep(name, tiles[name])
            came += 1
            payload_bytes += len(message.payload)
        if any(name not in tiles for name in names):
            raise CheckError(f"Step {begin.step} ends without all its tiles.")
        if (message.tiles_sent, message.payload_bytes) != (came, payload_bytes):
            raise CheckError(f"Step {begin.step}: the server counts other tiles or bytes than came.")
        high = sum(tile.digest_high for tile in begin.tiles) % 2**64
        low = sum(tile.digest_low for tile in begin.tiles) % 2**64
        if (high, low) != (message.digest_high, message.digest_low):
            raise CheckError(f"Step {begin.step}: its digest is not that of its tiles.")
        welded = weld([self._coloured(tiles[name], codes.get(name), begin) for name in names])
        resolution = request.lattice_resolution or 5
        edges = count_edges(welded.faces, len(welded.vertices))
        if edges.nonmanifold:
            raise CheckError(f"Step {begin.step}: {edges.nonmanifold} edges are shared by more than two triangles.")
        torn = edges_inside(welded.vertices, edges.open, data_border(info, begin, resolution))
        if torn:
            raise CheckError(f"Step {begin.step}: the surface is torn along {torn} edges inside the data.")
        return Step(
            number=begin.step,
            is_final=begin.is_final,
            error_bound_world=begin.error_bound_world,
            spacing=begin.finest_spacing or 1,
            mesh=positioned(welded, info, resolution),
            digest=f"{high:016x}{low:016x}",
            border_edges=len(edges.open),
            euler_characteristic=len(welded.vertices) - edges.distinct + len(welded.faces),
            preserves_topology=request.topology_tolerance == 0 and begin.finest_spacing in (0, 1),
            tiles_received=came,
            payload_bytes=payload_bytes,
            scalar_deviation=max((codes[name].largest_deviation for name in names if name in codes), default=0.0),
        )

    @staticmethod
    def _coloured(tile, scalars, begin):
        if not begin.HasField("scalars"):
            return tile
        if scalars is None:
            raise CheckError(f"Step {begin.step} ends without all its scalars.")
        try:
            return with_scalars(tile, scalars.codes, begin.scalars)
        except DamagedTile as damage:
            raise CheckError(f"Step {begin.step}: {damage}") from None

    def _answer(self, kind, question):
        """Asks what is answered with one message."""
        self._last_id += 1
        question.request_id = self._last_id
        self._send(**{kind: question})
        while True:
            came, message = self._next()
            if getattr(message, "request_id", None) not in (0, self._last_id):
                continue  # Of a stream that was left.
            if came == "error":
                raise ServerError(message)
            if came == kind + "_reply":
                return message

    def _info(self, dataset):
        if dataset not in self._infos:
            self.datasets()
        if dataset not in self._infos:
            raise KeyError(f'The server has no dataset "{dataset}"; it has {sorted(self._infos)}.')
        return self._infos[dataset]

    def _keep(self, name, tile):
        before = self._held.pop(name, None)
        self._held_triangles += len(tile.faces) - (len(before.faces) if before else 0)
        self._held[name] = tile
        while len(self._held) > MAX_HELD_TILES or self._held_triangles > MAX_HELD_TRIANGLES:
            oldest = self._held.pop(next(iter(self._held)))
            self._held_triangles -= len(oldest.faces)

    def _held_for(self, request):
        if request.normal_bits:
            return []
        return [name for name, tile in self._held.items() if tile.normals is None]

    def _send(self, **message):
        self._transport.send(pb.ClientMessage(**message).SerializeToString())

    def _next(self):
        message = pb.ServerMessage.FromString(self._transport.receive())
        kind = message.WhichOneof("kind")
        if kind is None:
            raise CheckError("A message of an unknown kind came.")
        return kind, getattr(message, kind)

    def _receive(self, awaited):
        while True:
            kind, message = self._next()
            if kind == awaited:
                return message
            if kind == "error":
                raise ServerError(message)

    def _next_of_stream(self):
        """Messages of earlier streams, cancelled by then, are passed over."""
        while True:
            kind, message = self._next()
            if kind == "error" and message.request_id in (0, self._last_id):
                raise ServerError(message)
            if getattr(message, "request_id", None) == self._last_id and kind in (
                "step_begin",
                "tile",
                "tile_scalars",
                "step_end",
                "stream_end",
            ):
                return kind, message


def _empty_text(isovalue, info):
    return f'The surface at isovalue {isovalue:g} is empty; values of "{info.name}" go from {info.min:g} to {info.max:g}.'


def _digest_bytes(tile):
    return np.array([tile.digest_high, tile.digest_low], "<u8").tobytes()
