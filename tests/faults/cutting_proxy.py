"""A proxy between clients and a server that cuts each connection after a random number of the server's bytes.

    cutting_proxy.py HOST:PORT --cuts 200 --largest 100000 --count FILE

After --cuts cuts it relays everything. Writes the number of cuts to the file.
"""
import argparse
import asyncio
import random


class CuttingProxy:
    def __init__(self, options):
        self.host, self.port = options.upstream.rsplit(":", 1)
        self.options = options
        self.random = random.Random(options.seed)
        self.cuts = 0

    async def serve(self, reader, writer):
        upstream_reader, upstream_writer = await asyncio.open_connection(self.host, int(self.port))
        limit = self.random.randint(1, self.options.largest) if self.cuts < self.options.cuts else None
        requests = asyncio.create_task(self.pass_on(reader, upstream_writer, None))
        if await self.pass_on(upstream_reader, writer, limit):
            self.cuts += 1
            with open(self.options.count, "w") as file:
                file.write(f"{self.cuts}\n")
        for end in (writer, upstream_writer):
            end.transport.abort()
        requests.cancel()

    async def pass_on(self, reader, writer, limit):
        """Returns whether it was cut."""
        passed = 0
        try:
            while data := await reader.read(16384):
                if limit is not None and passed + len(data) >= limit:
                    writer.write(data[: limit - passed])
                    await asyncio.wait_for(writer.drain(), 5)
                    return True
                passed += len(data)
                writer.write(data)
                await writer.drain()
        except (ConnectionError, asyncio.TimeoutError):
            pass
        return False


async def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("upstream")
    parser.add_argument("--cuts", type=int, default=200)
    parser.add_argument("--largest", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", required=True)
    options = parser.parse_args()
    proxy = CuttingProxy(options)
    server = await asyncio.start_server(proxy.serve, "127.0.0.1", 0)
    print(f"listening on tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}", flush=True)
    await server.serve_forever()


asyncio.run(main())
