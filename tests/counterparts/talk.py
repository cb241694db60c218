"""Receives a whole stream over a WebSocket, with message classes made by protoc.

    talk.py URL TOKEN CERTIFICATE
"""
import asyncio
import ssl
import sys

import websockets

from multitetra.v1 import conversation_pb2 as pb
from multitetra.v1 import request_pb2


async def receive(socket, awaited):
    message = pb.ServerMessage.FromString(await socket.recv())
    kind = message.WhichOneof("kind")
    assert awaited in ("", kind), f"{kind} came instead of {awaited}: {message}"
    return kind, getattr(message, kind)


async def talk(url, token, certificate):
    trust = ssl.create_default_context(cafile=certificate) if url.startswith("wss:") else None
    options = {"subprotocols": ["multitetra.v1"], "ssl": trust, "max_size": None}

    async def send(socket, **message):
        await socket.send(pb.ClientMessage(**message).SerializeToString())

    async with websockets.connect(url, **options) as socket:
        assert socket.subprotocol == "multitetra.v1"
        await send(socket, hello=pb.Hello(min_version=1, max_version=1, codecs=[1], token=token, agent="websockets"))
        await receive(socket, "welcome")
        await send(socket, list_datasets=pb.ListDatasets(request_id=1))
        _, datasets = await receive(socket, "dataset_list")
        heads = [info for info in datasets.datasets if info.name == "head"]
        assert len(heads) == 1, [info.name for info in datasets.datasets]
        request = request_pb2.IsosurfaceRequest(
            isovalue=heads[0].suggested_isovalues[0], threshold=request_pb2.ThresholdMap(error=1)
        )
        await send(socket, open_stream=pb.OpenStream(request_id=2, dataset="head", request=request))
        tiles, steps, kind = 0, 0, ""
        while kind != "stream_end":
            kind, message = await receive(socket, "")
            assert kind in ("step_begin", "tile", "step_end", "stream_end"), kind
            tiles += kind == "tile"
            steps += kind == "step_end"
        assert tiles > 0 and message.steps == steps, message

    async with websockets.connect(url, **options) as socket:
        await send(socket, hello=pb.Hello(min_version=1, max_version=1, codecs=[1], token="mt_wrong"))
        _, refusal = await receive(socket, "error")
        assert "token" in refusal.text, refusal
    try:
        async with websockets.connect(url, ssl=trust):
            raise AssertionError("a WebSocket without subprotocol was let in")
    except websockets.InvalidHandshake as refusal:
        assert "HTTP 400" in str(refusal), refusal


asyncio.run(asyncio.wait_for(talk(*sys.argv[1:]), 60))
