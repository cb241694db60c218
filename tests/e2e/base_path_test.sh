#!/usr/bin/env bash
# A server below a path of an nginx site, with and without the proxy stripping the path: page, files, meshes and
# conversations work. Usage: base_path_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
server=$bin/multitetra-server
client=$bin/multitetra-client
recipe=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/docker/nginx.conf
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"
for needed in nginx curl; do
  command -v "$needed" >/dev/null || { echo "!! $needed is missing: base paths are NOT TESTED."; exit 77; }
done

"$server" generate gyroid --size 17 -o gyroid.nrrd --quiet
"$server" prepare gyroid.nrrd -o gyroid.mtd --quiet
mkdir -p page/assets nginx
echo '<script src="./assets/page-12345678.js"></script>' >page/index.html
echo 'let page;' >page/assets/page-12345678.js
start server "$server" serve gyroid.mtd --tcp off --http 127.0.0.1:0 --viewer page --base-path volumes/ \
  --trusted-proxy 127.0.0.1
http=$(url_of server http)
port=$(free_port)
# The recipe's commented example at its end, split into its two places.
sed -n '/^# Below a path/,$s/^#   //p' "$recipe" | sed "s|http://127.0.0.1:7480|$http|" >below
sed -n '/^map/,/^}/p' below >map
sed '/^map/,/^}/d' below >locations
grep -q 'location /volumes' locations || fail "docker/nginx.conf ends without a location"
cat >nginx.conf <<CONF
events {}
http {
  client_body_temp_path nginx/body; proxy_temp_path nginx/proxy; fastcgi_temp_path nginx/fastcgi;
  uwsgi_temp_path nginx/uwsgi; scgi_temp_path nginx/scgi; access_log off;
  $(cat map)
  server {
    listen 127.0.0.1:$port;
    $(cat locations)
    location / { return 410; }  # The rest of the site.
    location /elsewhere/ {
      $(sed -n '/location .volumes. {/,/}/{/proxy_[hs]/p}' locations)
      proxy_pass $http/;
    }
  }
}
CONF
start nginx nginx -p "$work" -c "$work/nginx.conf" -g "daemon off; pid $work/nginx/pid; error_log $work/nginx/errors.log;"
site=http://127.0.0.1:$port
for _ in $(seq 200); do curl -s -o /dev/null "$site/volumes/livez" && break; sleep 0.05; done

for path in volumes elsewhere; do
  curl -sf "$site/$path/" | grep -q 'src="./assets' || fail "no page at /$path/"
  [ "$(curl -sf "$site/$path/assets/page-12345678.js")" = "let page;" ] || fail "no file of the page below /$path/"
  curl -sf "$site/$path/v1/datasets" | grep -q '"gyroid"' || fail "no datasets below /$path/"
  curl -sf -o mesh.glb "$site/$path/v1/datasets/gyroid/isosurface?isovalue=0" || fail "no mesh below /$path/"
  "$client" list --server "ws://127.0.0.1:$port/$path/" | grep -q gyroid || fail "no conversation below /$path/"
  "$client" fetch --server "ws://127.0.0.1:$port/$path/v1/stream" --isovalue 0 -o mesh.ply --quiet || fail "no stream below /$path/"
done
[ "$(curl -s -o /dev/null -w '%{http_code}' "$site/volumes/metrics")" = 404 ] || fail "nginx exposes the metrics"
[ "$(curl -s -o /dev/null -w '%{http_code} %{redirect_url}' "$site/volumes")" = "301 $site/volumes/" ] ||
  fail "/volumes does not lead to /volumes/"
[ "$(curl -s -o /dev/null -w '%{http_code}' "$site/volumesother")" = 410 ] || fail "another folder of the site is taken"
ends 1 "it redirects to $site/volumes/; connect there" "$client" list --server "ws://127.0.0.1:$port/volumes"
ends 1 "it redirects to /volumes/; connect there" "$client" list --server "ws://${http#http://}/volumes"
curl -sf -o /dev/null "$http/livez" || fail "the server itself does not answer without the path"
ends 2 "/volumes" "$server" serve gyroid.mtd --base-path 'https://example.org/volumes'
