#!/usr/bin/env bash
# Options of `multitetra-server serve` from flags, environment and file, and its errors.
#   serve_options_test.sh FOLDER-OF-PROGRAMS
set -euo pipefail
server=$(realpath "$1")/multitetra-server
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

"$server" generate gradient --size 9 -o v.nrrd >/dev/null 2>&1 || "$server" generate head --size 16 -o v.nrrd >/dev/null 2>&1
"$server" prepare v.nrrd -o v.mtd >/dev/null 2>&1

# Flags override the environment, which overrides the file.
cat >server.toml <<'TOML'
datasets = ["v.mtd"]
max-connections = 11
max-regions = 12
max-queries = 13
allow-origin = ["https://a.example", "https://b.example"]
TOML
MULTITETRA_MAX_REGIONS=22 MULTITETRA_MAX_QUERIES=23 \
  "$server" serve --config server.toml --max-queries 33 --print-config >config
for line in max-connections=11 max-regions=22 max-queries=33; do
  grep -qx "$line" config || fail "$line is not in: $(cat config)"
done
grep -q 'b.example' config || fail "a list in the file is not taken: $(cat config)"

for key in tls-cert tls-key tokens trusted-proxy base-path allow-host cache-dir volume-cache; do
  grep -B 1 -x "# $key=\"\"" config | head -n 1 | grep -q '^# ..' || fail "$key and its help are not in: $(cat config)"
done

# The printed configuration reads back unchanged.
"$server" serve --config config --print-config >again
cmp config again || fail "--print-config does not read what it prints"

grep -qx "datasets=\"$PWD/v.mtd\"" config || grep -qxF "datasets=[\"$PWD/v.mtd\"]" config || fail "a relative path: $(grep datasets config)"
"$server" serve s3://b/v.mtd --tokens sub/../tokens --print-config >paths
grep -q 's3://b/v.mtd' paths || fail "an address is no path: $(grep datasets paths)"
grep -qx "tokens=\"$PWD/tokens\"" paths || fail "a relative path: $(grep tokens paths)"

# Errors end with one clear line and a specific exit code.
echo 'max-conections = 1' >typo.toml
ends 2 'no option "max-conections"' "$server" serve v.mtd --config typo.toml
printf 'threads = 1\nmax-regions = 5\nthreads = 2\n' >twice.toml
ends 2 'is set twice' "$server" serve v.mtd --config twice.toml
echo 'max-connections = "many"' >word.toml
ends 2 'max-connections' "$server" serve v.mtd --config word.toml
ends 2 'cannot be read' "$server" serve v.mtd --config nowhere.toml
ends 2 'give both: a certificate and its key' "$server" serve v.mtd --tls-cert server.pem
ends 2 'datasets' "$server" serve
ends 2 'both are off' "$server" serve v.mtd --tcp off --http off
ends 4 'nowhere.pem does not exist' "$server" serve v.mtd --tls-cert nowhere.pem --tls-key nowhere.key
ends 4 'tokens file' "$server" serve v.mtd --tokens nowhere
ends 5 'no dataset' "$server" serve nowhere.mtd
ends 1 'No dataset can be read from its store' "$server" serve http://127.0.0.1:1/v.mtd --store-seconds 1
ends 1 'HTTP servers do not list folders' "$server" serve http://127.0.0.1:1/volumes/

# With a log in JSON, they are lines of it.
for options in "v.mtd --tokens nowhere" nowhere.mtd; do
  # shellcheck disable=SC2086
  "$server" serve $options --log-format json 2>fatal || true
  tail -n 1 fatal | python3 -c 'import json, sys; assert json.loads(sys.stdin.read())["level"] == "error"' || fail "$(cat fatal)"
done

# A damaged dataset is logged and skipped; the others are served until SIGTERM, with exit code 0.
head -c 100 v.mtd >damaged.mtd
cp v.mtd twice.mtd
start server "$server" serve damaged.mtd v.mtd twice.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0
url=$(url_of server tcp)
curl -s "$(url_of server http)/metrics" | grep -q 'last_reload_failed{what="datasets"} 1' || fail "metrics do not show it"
grep -q 'skipped: ' server.log || fail "the damaged dataset is not logged: $(cat server.log)"
grep -q 'skipped: .*twice.mtd' server.log || fail "a second dataset of a name is not logged: $(cat server.log)"
[ "$(grep -c ' serving ' server.log)" = 1 ] || fail "a dataset that is left out is said to be served: $(cat server.log)"
ends 7 'Cannot listen on' "$server" serve v.mtd --tcp "${url#tcp://}" --http off
kill -HUP "$pid"
ends_well server "$pid"

# Volumes are prepared into a cache while they are served, beside datasets.
mkdir scans
cp v.nrrd scans/head.nrrd
start volumes "$server" serve v.mtd scans --volume-cache cache --tcp off --http 127.0.0.1:0
volumes_http=$(url_of volumes http)
listed() { curl -s "$volumes_http/v1/datasets" | python3 -c 'import json, sys; print(*sorted(d["name"] + ": " + str(d["missing"]) for d in json.load(sys.stdin)["datasets"]))'; }
for _ in $(seq 200); do [ "$(listed)" = "head: None v: None" ] && break; sleep 0.05; done
[ "$(listed)" = "head: None v: None" ] || fail "served are $(listed): $(cat volumes.log)"
ends_well volumes "$pid"
"$server" prepare scans/head.nrrd -o head.mtd --quiet
cmp head.mtd cache/datasets/head-*/head.mtd || fail "serve makes another dataset than prepare"
head -c 100 v.nrrd >broken.nrrd
ends 2 'broken.nrrd' "$server" serve broken.nrrd --volume-cache cache
ends 2 'nowhere.nrrd' "$server" serve nowhere.nrrd --volume-cache cache

# A new token is in the list that it was appended to, and only its owner can read the file.
token=$("$server" token alice --datasets 'v*' --append tokens)
[ "$(stat -c %a tokens)" = 600 ] || fail "others may read the tokens file"
grep -q "^alice $(printf %s "$token" | sha256sum | cut -d' ' -f1) v\*$" tokens || fail "$(cat tokens)"
printf %s "$(cat tokens)" >tokens  # Without the final line break.
"$server" token bob --append tokens >/dev/null
[ "$(wc -l <tokens)" = 2 ] || fail "a line was glued to another: $(cat tokens)"

# The log warns about insecure settings when other machines can connect.
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=other.example \
  -addext subjectAltName=DNS:other.example -keyout tls.key -out tls.pem 2>/dev/null
chmod 644 tls.key
start open "$server" serve v.mtd --tcp 0.0.0.0:0 --http off
start guarded "$server" serve v.mtd --tcp 0.0.0.0:0 --http off --tokens tokens --tls-cert tls.pem --tls-key tls.key
start alone "$server" serve v.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0
port=$(url_of guarded tls 2>/dev/null || url_of guarded tcp)
alone_tcp=$(url_of alone tcp)
alone_http=$(url_of alone http)
url_of open tcp >/dev/null
grep -q 'every client may see all datasets' open.log || fail "no warning about an open server: $(cat open.log)"
grep -q 'traffic is not encrypted' open.log || fail "no warning about missing TLS"
grep -q 'the TLS key is readable by all users' guarded.log || fail "no warning about a readable key: $(cat guarded.log)"
! grep -q 'every client may\|not encrypted' guarded.log || fail "a warning about a guarded server"
# DNS rebinding is prevented: pages of other sites cannot read a local server under their own host name.
status_as() { curl -s -o /dev/null -w '%{http_code}' -H "Host: $1" "$alone_http/v1/datasets"; }
[ "$(status_as localhost) $(status_as evil.example)" = "200 421" ] || fail "a server for this machine answers to any name"
ends 2 'not a host name' "$server" serve v.mtd --allow-host https://example.org
! grep -q 'warning' alone.log || fail "a warning about a local server: $(cat alone.log)"

# Errors print the correct port and scheme.
client=$(realpath "$(dirname "$server")")/multitetra-client
ends 1 'port uses HTTP: write ws://' "$client" list --server "tcp://${alone_http#http://}"
ends 1 "write $alone_tcp" "$client" list --server "ws://${alone_tcp#tcp://}"
ends 1 'does this port use TLS' "$client" list --server "tls://${alone_tcp#tcp://}"
ends 1 'write tls://' "$client" list --server "tcp://localhost:${port##*:}"
ends 1 'is not valid for the name localhost' "$client" list --server "tls://localhost:${port##*:}" --ca tls.pem
ends 7 '--http HOST:PORT' "$server" serve v.mtd --tcp off --http "${alone_http#http://}"
