#!/usr/bin/env bash
# Tests haproxy.cfg and caching_proxy.conf, with changed ports and folders, in front of three servers whose dataset is
# served by another nginx. Takes half a minute; prints the results and fails if a check fails.
#
#   bash docker/serving/try.sh FOLDER-OF-PROGRAMS
#
# repeats      nginx answers repeated requests from its cache and merges concurrent ones
# hashing      through HAProxy as many meshes come from caches as with one server; files that are computed
#              together are on one server
# streams      a WebSocket through each proxy gives the mesh that `extract` gives
# lost server  kill -9 of one of three servers under load: no client loses a result, no HTTP request fails
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
project=$(cd "$here/../.." && pwd)
bin=$(cd "${1:?name the folder of the programs}" && pwd)
for program in haproxy nginx curl; do
  command -v "$program" >/dev/null || { echo "!! $program is not installed: NOT TRIED (docker/install.sh tests bench)." >&2; exit 77; }
done
source "$project/tests/support/programs.sh"

# ---- a store, three servers, two proxies

"$bin/multitetra-server" generate head --size 64 --noise 20 -o head.nrrd --quiet
"$bin/multitetra-server" prepare head.nrrd -o head.mtd --name head --quiet
mkdir -p store temporary cache
cp head.mtd store/

run_nginx() {  # run_nginx NAME PORT: starts it with NAME.conf and waits until it listens.
  start "$1" nginx -p "$work" -c "$work/$1.conf" -g \
    "daemon off; pid $work/$1.pid; user $(id -un) $(id -gn); error_log $work/$1.errors;"
  for _ in $(seq 200); do curl -s -o /dev/null "http://127.0.0.1:$2/" && return; sleep 0.05; done
  fail "nginx: $(cat "$1.log" "$1.errors")"
}
temporary="client_body_temp_path temporary/body; proxy_temp_path temporary/proxy; fastcgi_temp_path temporary/fastcgi; \
uwsgi_temp_path temporary/uwsgi; scgi_temp_path temporary/scgi; access_log off;"
store=$(free_port)
echo "events {} http { $temporary server { listen 127.0.0.1:$store; root $work/store; } }" >store.conf
run_nginx store "$store"

names=(one two three)
servers=()
server_pids=()
for name in "${names[@]}"; do
  start "$name" "$bin/multitetra-server" serve "http://127.0.0.1:$store/head.mtd" --tcp off --http 127.0.0.1:0 \
    --cache-dir cache --max-requests-per-second 100000 --trusted-proxy 127.0.0.1
  server_pids+=("$pid")
  servers+=("$(url_of "$name" http)")
done
start alone "$bin/multitetra-server" serve head.mtd --tcp off --http 127.0.0.1:0 --max-requests-per-second 100000
alone=$(url_of alone http)

ports=()
for at in 0 1 2; do ports+=(-e "s#127.0.0.1:748$((at + 1))#${servers[at]#http://}#"); done
haproxy_port=$(free_port)
sed "${ports[@]}" -e "s#bind :8080#bind 127.0.0.1:$haproxy_port#" "$here/haproxy.cfg" >haproxy.cfg
start haproxy haproxy -f haproxy.cfg
nginx_port=$(free_port)
sed "${ports[@]}" -e "s#listen 8081#listen 127.0.0.1:$nginx_port#" -e "s#/var/cache/nginx#$work/nginx_cache#" \
  -e "s#^http {#http { $temporary#" "$here/caching_proxy.conf" >nginx.conf
mkdir -p nginx_cache
run_nginx nginx "$nginx_port"
haproxy=http://127.0.0.1:$haproxy_port
nginx=http://127.0.0.1:$nginx_port
for _ in $(seq 200); do curl -sf -o /dev/null "$haproxy/v1/datasets" && break; sleep 0.05; done

# metric NAME SERVER...: prints the sum over the servers.
metric() {
  local name=$1 one
  shift
  for one in "$@"; do curl -sf "$one/metrics"; done | awk -v name="$name" '$1 == name { sum += $2 } END { print sum + 0 }'
}
mesh() { echo "/v1/datasets/head/isosurface?isovalue=$1&error=2&format=glb"; }
computed=multitetra_step_seconds_count  # Counts requests that no cache answered.
made='multitetra_requests_total{kind="isosurface",outcome="complete",transport="http"}'

for listener in "$haproxy" "$nginx"; do
  status=$(curl -s -o /dev/null -w '%{http_code}' "$listener/metrics")
  [ "$status" = 403 ] || fail "$listener/metrics is public: $status"
done

# ---- repeats

for isovalue in 100.5 200.5 300.5; do
  curl -sf -o first.glb "$nginx$(mesh $isovalue)" || fail "nginx: no mesh at $isovalue"
  curl -sf -o again.glb -D headers "$nginx$(mesh $isovalue)" || fail "nginx: no mesh at $isovalue"
  cmp -s first.glb again.glb || fail "nginx: another mesh at $isovalue"
  grep -qiE '^X-Cache: (HIT|REVALIDATED)' headers || fail "nginx did not keep the mesh at $isovalue: $(cat headers)"
done
sleep 2.1  # Longer than nginx caches, in whole seconds.
curl -sf -o again.glb -D headers "$nginx$(mesh 300.5)" && cmp -s first.glb again.glb && grep -qi '^X-Cache: REVALIDATED' headers ||
  fail "nginx does not revalidate a mesh: $(cat headers)"
before=$(metric "$made" "${servers[@]}")
waiting=()
for at in 1 2 3 4 5 6 7 8; do
  curl -sf -o "same$at.glb" "$nginx$(mesh 400.5)" & waiting+=($!)
done
for one in "${waiting[@]}"; do wait "$one" || fail "nginx: one of eight equal requests"; done
times=$(($(metric "$made" "${servers[@]}") - before))
[ "$times" = 1 ] || fail "a mesh requested by eight clients at once was made $times times"
echo "repeats: 3 of 3 meshes from nginx; a mesh requested by 8 clients at once was made $times time"

# ---- hashing: each mesh four times, in random order

requested=$(for isovalue in $(seq -300.5 100 800); do for _ in 1 2 3 4; do echo "$isovalue"; done; done |
  python3 -c 'import random, sys; all = sys.stdin.readlines(); random.Random(1).shuffle(all); sys.stdout.writelines(all)')
# rate_of WHERE SERVER...: requests all meshes from WHERE and prints the percentage that the servers had cached.
rate_of() {
  local where=$1 times isovalue
  shift
  times=$(metric "$computed" "$@")
  while read -r isovalue; do
    curl -sf -o out "$where$(mesh "$isovalue")" || fail "$where: no mesh at $isovalue"
  done <<<"$requested"
  times=$(($(metric "$computed" "$@") - times))
  echo $((100 - 100 * times / $(wc -l <<<"$requested")))
}
one_server=$(rate_of "$alone" "$alone")
three_servers=$(rate_of "$haproxy" "${servers[@]}")
shares=()
for one in "${servers[@]}"; do shares+=("$(metric "$computed" "$one")"); done
[ "$one_server" -gt 0 ] && [ $((10 * three_servers)) -ge $((9 * one_server)) ] ||
  fail "three servers had $three_servers % of the meshes in their caches, one alone $one_server %"
echo "hashing: $three_servers % of the meshes in the caches of three servers (${shares[*]} computed), $one_server % of one alone"

# A neuroglancer mesh is computed for its first file, and its other file is on the same server.
for listener in "$haproxy" "$nginx"; do
  for isovalue in 100.5 200.5 300.5; do
    segment=$(python3 -c 'import struct, sys; print(struct.unpack("<Q", struct.pack("<d", float(sys.argv[1])))[0])' "$isovalue")
    answered='multitetra_http_answers_total{kind="neuroglancer",status="200"}'
    before=()
    for one in "${servers[@]}"; do before+=("$(metric "$answered" "$one")"); done
    for file in .index ''; do
      # Replies during the computation have a retry delay.
      curl -sf --retry 60 -o out "$listener/v1/neuroglancer/head/surfaces,error=2/$segment$file" ||
        fail "$listener: no mesh for neuroglancer at $isovalue"
    done
    for at in 0 1 2; do
      more=$(($(metric "$answered" "${servers[at]}") - before[at]))
      [ "$more" != 1 ] || fail "$listener: the two files of a mesh for neuroglancer come from two servers"
    done
  done
done

# ---- streams

"$bin/multitetra-server" extract head.mtd --isovalue 100.5 --error 0.5 --quiet --json -o extracted.ply >extracted.json
digest() { python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["steps"][-1]["content_digest"])' "$1"; }
"$bin/multitetra-client" fetch --server "${alone/http:/ws:}" --dataset head --isovalue 100.5 --error 0.5 --quiet \
  --report alone.json -o alone.ply
for listener in "$haproxy" "$nginx"; do
  "$bin/multitetra-client" fetch --server "${listener/http:/ws:}" --dataset head --isovalue 100.5 --error 0.5 --quiet \
    --report report.json -o fetched.ply || { fail "a stream through $listener"; continue; }
  [ "$(digest report.json)" = "$(digest alone.json)" ] || fail "a stream through $listener is another mesh"
done
echo "streams: the same mesh over WebSockets through HAProxy and nginx"

# ---- a lost server

start load "$bin/multitetra-load" --server "ws://127.0.0.1:$haproxy_port" --clients 12 --duration 8 --pause 0.2 --threads 1 \
  --script random-isovalues --errors 2,4 --json
load=$pid
sleep 3
kill -9 "${server_pids[1]}"
wait "${server_pids[1]}" 2>/dev/null || true
lost=0
for isovalue in $(seq -290.5 100 700); do
  for listener in "$haproxy" "$nginx"; do
    curl -sf -o out "$listener$(mesh "$isovalue")" || { lost=$((lost + 1)); fail "$listener: no mesh at $isovalue while a server is lost"; }
  done
done
wait "$load" || fail "clients lost results: $(cat load.log)"
python3 - <<'END' || fail "the load was not what it should be: $(cat load.log)"
import json
report = json.load(open("load.log"))
streams, connections = report["streams"], report["connections"]
print(f"lost server: {streams['complete']} streams complete, {streams['failed']} failed, {streams['unfinished']} unfinished; "
      f"{connections['lost']} connections were lost with it")
assert connections["lost"] > 0, "no client was at that server"
assert streams["complete"] > 0 and streams["failed"] == streams["unfinished"] == 0
assert report["checks"]["failed"] == 0 and report["tiles_sent_twice"] == 0
END
