#!/usr/bin/env bash
# Tests the listeners with other programs: see README.md.
#   run.sh FOLDER-OF-PROGRAMS [COUNTERPART...]     client curl websockets browser gltf wrk locust tiles neuroglancer paraview
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
project=$(cd "$here/../.." && pwd)
[ $# -gt 0 ] || { sed -n '2,3s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
bin=$(cd "$1" && pwd)
shift
all=(client curl websockets browser gltf wrk locust tiles neuroglancer paraview)
[ $# -gt 0 ] || set -- "${all[@]}"

source "$project/tests/support/programs.sh"
tested=0
leave_out() { echo "!! LEFT OUT: $1: NOT TESTED (docker/install.sh tests bench)." >&2; }
source "$here/viewers/talk.sh"

# ---- the servers

openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=localhost \
  -addext subjectAltName=DNS:localhost,IP:127.0.0.1 -keyout tls.key -out tls.pem 2>/dev/null
token=$("$bin/multitetra-server" token alice --append tokens)
few=$("$bin/multitetra-server" token bob --datasets 'none-*' --append tokens)
echo "$token" >token
"$bin/multitetra-server" generate head --size 64 --noise 20 -o head.nrrd --quiet
"$bin/multitetra-server" prepare head.nrrd -o head.mtd --quiet
datasets=(head.mtd)
if [[ " $* " =~ \ (tiles|neuroglancer|paraview)\  ]]; then
  prepare_trees
  datasets+=(tree.mtd lump.mtd)
fi

if [[ " $* " =~ " websockets " ]]; then  # The client must choose one of several datasets.
  for name in another third; do
    "$bin/multitetra-server" prepare head.nrrd -o $name.mtd --name $name --quiet
    datasets+=($name.mtd)
  done
fi

# The address with the host name of the certificate.
named() { local url; url=$(url_of "$@"); echo "${url/127.0.0.1/localhost}"; }

room=(--max-requests-per-second 100000 --allow-origin "http://127.0.0.1:$pages_port")
start server "$bin/multitetra-server" serve "${datasets[@]}" --tcp 127.0.0.1:0 --http 127.0.0.1:0 --tls-cert tls.pem \
  --tls-key tls.key --tokens tokens "${room[@]}"
start plain "$bin/multitetra-server" serve "${datasets[@]}" --tcp 127.0.0.1:0 --http 127.0.0.1:0 --tokens tokens \
  --trusted-proxy 127.0.0.1 --log-level debug "${room[@]}"
tls=$(named server tls)
start gateway "$bin/multitetra-gateway" --upstream "$tls" --upstream-ca tls.pem --tcp 127.0.0.1:0 --http 127.0.0.1:0 \
  --tls-cert tls.pem --tls-key tls.key --tokens tokens "${room[@]}"
plain=$(named plain http)
https=("$(named server https)" "$(named gateway https)")

if command -v nginx >/dev/null; then
  port=$(free_port)
  mkdir nginx
  sed -e "s#server server:7480#server ${plain#http://}#" -e "s#listen 443 ssl#listen 127.0.0.1:$port ssl#" \
    -e "s#/etc/nginx/certificates#$work#" -e "s#^http {#http {\n  client_body_temp_path nginx/body; proxy_temp_path nginx/proxy;\
 fastcgi_temp_path nginx/fastcgi; uwsgi_temp_path nginx/uwsgi; scgi_temp_path nginx/scgi;#" \
    "$project/docker/nginx.conf" >nginx.conf
  start nginx nginx -p "$work" -c "$work/nginx.conf" -g \
    "daemon off; pid $work/nginx/pid; user $(id -un) $(id -gn); error_log $work/nginx/errors.log;"
  for _ in $(seq 200); do curl -s --cacert tls.pem -o /dev/null "https://localhost:$port/livez" && break; sleep 0.05; done
  https+=("https://localhost:$port")
else
  leave_out "nginx as a proxy"
fi

# ---- counterparts

talk_client() {
  local url digest='' one
  for url in "$tls" "${https[@]/https:/wss:}" "$(named gateway tls)"; do
    rm -f report.json
    "$bin/multitetra-client" fetch --server "$url" --ca tls.pem --token-file token --dataset head --error 1 --quiet \
      --report report.json -o mesh.ply || { fail "client: $url"; continue; }
    one=$(python3 -c 'import json; print(json.load(open("report.json"))["steps"][-1]["content_digest"])')
    [ -z "$digest" ] || [ "$digest" = "$one" ] || fail "client: $url: another mesh"
    digest=$one
    ! "$bin/multitetra-client" list --server "$url" --ca tls.pem >out 2>&1 || fail "client: $url: let in without a token"
    grep -qi 'token' out || fail "client: $url: $(cat out)"
    ! "$bin/multitetra-client" list --server "$url" --token "$token" >out 2>&1 ||
      fail "client: $url: accepts an unknown certificate"
    "$bin/multitetra-client" list --server "$url" --ca tls.pem --token "$few" >out 2>&1 || fail "client: $url: bob"
    ! grep -q head out || fail "client: $url: bob sees what is not his"
  done
}

talk_curl() {
  command -v curl >/dev/null || { leave_out curl; return 1; }
  "$bin/multitetra-server" extract head.mtd --error 1 -o extracted.ply --quiet
  local url mesh etag auth="Authorization: Bearer $token"
  for url in "${https[@]}"; do
    status() { curl -sS --cacert tls.pem -o body -w '%{http_code}' "$@"; }
    [ "$(status "$url/livez")" = 200 ] || fail "curl: $url: livez"
    [ "$(status "$url/")" = 200 ] || fail "curl: $url: the page"
    [ "$(status "$url/v1/datasets")" = 401 ] || fail "curl: $url: no token"
    [ "$(status "$url/v1/datasets" -H 'Authorization: Bearer mt_wrong')" = 401 ] || fail "curl: $url: a wrong token"
    [ "$(status "$url/v1/datasets" -H "$auth")" = 200 ] || fail "curl: $url: the list"
    grep -q '"name": *"head"' body || fail "curl: $url: what the list says"
    mesh="$url/v1/datasets/head/isosurface?error=1&format=glb"
    [ "$(status "$mesh" -H "Authorization: Bearer $few")" = 404 ] || fail "curl: $url: bob's token"
    [ "$(status "$mesh" -H "$auth" -D headers)" = 200 ] || fail "curl: $url: a mesh"
    cp body mesh.glb
    [ "$(status "${mesh/glb/ply}" -H "$auth")" = 200 ] || fail "curl: $url: a PLY file"
    # The order of vertices may differ; then the files have the same size.
    [ "$(stat -c %s body)" = "$(stat -c %s extracted.ply)" ] || fail "curl: $url: not the mesh that is extracted"
    etag=$(sed -n 's/^ETag: \(.*\)\r$/\1/Ip' headers)
    [ "$(status "$mesh" -H "$auth" -H "If-None-Match: $etag")" = 304 ] || fail "curl: $url: no 304"
    head -c 1000 mesh.glb >part.glb
    curl -sSf --cacert tls.pem -H "$auth" -C - -o part.glb "$mesh" && cmp -s part.glb mesh.glb ||
      fail "curl: $url: a download that goes on"
    [ "$(status --path-as-is "$url/../../etc/passwd")" != 200 ] || fail "curl: $url: a way out"
  done
  if [ "${#https[@]}" = 3 ]; then
    [ "$(status "${https[2]}/metrics")" = 404 ] || fail "curl: nginx shows the metrics"
    # The log has the address of the client, not the forwarded one.
    status "${https[2]}/v1/none" -H 'X-Forwarded-For: 203.0.113.9' >/dev/null
    ! grep -q 203.0.113.9 plain.log || fail "curl: a client chooses its own address"
  fi
}

talk_websockets() {
  local python=python3 url
  for python in python3 /usr/bin/python3 ''; do
    [ -z "$python" ] || ! $python -c 'import websockets, google.protobuf' 2>/dev/null || break
  done
  [ -n "$python" ] && command -v protoc >/dev/null || { leave_out "Python's websockets"; return 1; }
  mkdir -p python
  (cd "$project/proto" && protoc -I . --python_out="$work/python" multitetra/v1/*.proto)
  for url in "${https[@]/https:/wss:}" "${plain/http:/ws:}"; do
    PYTHONPATH=$work/python $python "$here/talk.py" "$url/v1/stream" "$token" tls.pem || fail "Python's websockets: $url"
  done
}

node_with() {
  command -v node >/dev/null && node -e "require('module').createRequire('$project/client/web/package.json')('$1')" 2>/dev/null
}

talk_browser() {
  local chromium=${CHROMIUM:-/usr/bin/chromium}
  [ -x "$chromium" ] && node_with playwright-core || { leave_out "Chromium with playwright-core"; return 1; }
  CHROMIUM=$chromium node "$here/browser.mjs" "$token" "${https[@]}" || fail "Chromium"
}

talk_gltf() {
  node_with gltf-validator && node_with three || { leave_out "gltf-validator and three.js"; return 1; }
  local url form
  for url in "${https[@]}"; do
    for form in normals=0 normals=8 codec=meshopt; do
      curl -sSf --cacert tls.pem -H "Authorization: Bearer $token" -D headers -o mesh.glb \
        "$url/v1/datasets/head/isosurface?error=1&format=glb&$form" || { fail "gltf: $url"; continue; }
      node "$here/gltf.mjs" mesh.glb "$(sed -n 's/^Multitetra-Triangles: \([0-9]*\).*/\1/Ip' headers)" ||
        fail "gltf: $url, $form"
    done
  done
}

talk_wrk() {
  command -v wrk >/dev/null || { leave_out wrk; return 1; }
  local url
  for url in "${https[@]}"; do
    wrk -t1 -c16 -d1s -H "Authorization: Bearer $token" "$url/v1/datasets" >wrk.txt
    grep -q '^Requests/sec: *[1-9]' wrk.txt || fail "wrk: $url: $(cat wrk.txt)"
    ! grep -qE 'Non-2xx|Socket errors' wrk.txt || fail "wrk: $url: $(cat wrk.txt)"
  done
}

talk_locust() {
  command -v locust >/dev/null && [ -d "$bin/../python/multitetra" ] && /usr/bin/python3 -c 'import locust, numpy' 2>/dev/null ||
    { leave_out Locust; return 1; }
  MULTITETRA_TOKEN=$token MULTITETRA_CA=$work/tls.pem PYTHONPATH=$bin/../python timeout 120 /usr/bin/python3 -m locust \
    -f "$project/client/load/locust/locustfile.py" --host "${https[0]}" --headless --users 6 --spawn-rate 6 --run-time 4s \
    --stop-timeout 30 --csv locust --only-summary >locust.txt 2>&1 || fail "Locust: $(cat locust.txt)"
  for kind in surface isosurface; do
    grep -q "$kind" locust_stats.csv || fail "Locust: no $kind was requested: $(cat locust.txt)"
  done
}

for counterpart in "$@"; do
  echo "== $counterpart"
  if "talk_$counterpart"; then tested=$((tested + 1)); fi
done
[ "$tested" -gt 0 ] || exit 77
