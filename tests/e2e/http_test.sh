#!/usr/bin/env bash
# The doors for HTTP and WebSockets as others speak to them: curl, and Python's websockets. Needs the folder of the
# programs; works in a temporary folder.
set -euo pipefail
bin=$(cd "$1" && pwd)
work=$(mktemp -d)
pids=()
cleanup() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap cleanup EXIT
cd "$work"
failed=0
fail() { echo "FAILED: $1" >&2; failed=1; }
if ! command -v curl >/dev/null; then
  echo "SKIPPED, and nothing was tested: curl is not installed (docker/install.sh tests)." >&2
  exit 77
fi

# url_of LOG SCHEME: the address that a program says it listens on.
url_of() {
  local url
  for _ in $(seq 200); do
    url=$(sed -n "s/.*listening on \($2:[^ ]*\).*/\1/p" "$1" 2>/dev/null || true)
    [ -n "$url" ] && { echo "$url"; return; }
    sleep 0.05
  done
  cat "$1" >&2
  return 1
}

"$bin/multitetra-server" generate head --size 48 -o head.nrrd --quiet
"$bin/multitetra-server" prepare head.nrrd -o head.mtd --quiet
for i in 1 2; do
  "$bin/multitetra-server" serve head.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 2>"server$i.log" &
  pids+=($!)
done
"$bin/multitetra-gateway" --upstream "$(url_of server1.log tcp)" --upstream "$(url_of server2.log tcp)" \
  --http 127.0.0.1:0 2>gateway.log &
pids+=($!)
server=$(url_of server1.log http)
gateway=$(url_of gateway.log http)

"$bin/multitetra-server" extract head.mtd --error 0.5 -o extracted.ply --quiet
for url in "$server" "$gateway"; do
  curl -sSf "$url/v1/datasets" | grep -q '"name": "head"' || fail "$url: the list of datasets"
  mesh="$url/v1/datasets/head/isosurface?error=0.5&format=ply"
  curl -sSf -D headers -o fetched.ply "$mesh"
  # Vertices may come in another order: the files are equally long, and the digest names the mesh.
  [ "$(stat -c %s fetched.ply)" = "$(stat -c %s extracted.ply)" ] || fail "$url: the mesh's size"
  etag=$(sed -n 's/^ETag: \(.*\)\r$/\1/p' headers)
  [ "$(curl -sS -o /dev/null -w '%{http_code}' -H "If-None-Match: $etag" "$mesh")" = 304 ] || fail "$url: no 304"
  head -c 1000 fetched.ply >part.ply
  curl -sSf -C - -o part.ply "$mesh"
  cmp -s part.ply fetched.ply || fail "$url: a download that goes on"
  [ "$(curl -sS -o /dev/null -w '%{http_code}' --path-as-is "$url/../../etc/passwd")" = 404 ] || fail "$url: a way out"
done
curl -sSf -o /dev/null "$server/" || fail "the page at /"

python=python3
$python -c 'import websockets' 2>/dev/null || python=/usr/bin/python3  # The one that Debian's packages are for.
if $python -c 'import websockets' 2>/dev/null; then
  $python - "$server" "$gateway" <<'PYTHON' || fail "Python's websockets"
import asyncio
import sys
import websockets

HELLO = bytes.fromhex("0a0d080110011a01012a0464656d6f")  # The example of proto/README.md.
PING = bytes.fromhex("2a020805")


async def talk(url):
    uri = url.replace("http", "ws", 1) + "/v1/stream"
    async with websockets.connect(uri, subprotocols=["multitetra.v1"], max_size=None) as socket:
        assert socket.subprotocol == "multitetra.v1"
        await socket.send(HELLO)
        assert (await socket.recv())[0] == 0x0A  # Welcome.
        await socket.send(PING)
        assert (await socket.recv()) == bytes.fromhex("42020805")  # Pong.
    try:
        async with websockets.connect(uri):
            raise AssertionError("a WebSocket without subprotocol was let in")
    except websockets.InvalidStatusCode as refusal:
        assert refusal.status_code == 400


for address in sys.argv[1:]:
    asyncio.run(asyncio.wait_for(talk(address), 30))
PYTHON
else
  echo "SKIPPED: Python's websockets is not installed (docker/install.sh tests)." >&2
fi
exit $failed
