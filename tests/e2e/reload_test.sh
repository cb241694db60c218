#!/usr/bin/env bash
# A served folder whose datasets are added, removed and replaced: after SIGHUP the server serves the current ones, and
# running streams continue with their original dataset. Usage: reload_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
server=$bin/multitetra-server
client=$bin/multitetra-client
support=$(cd "$(dirname "${BASH_SOURCE[0]}")/../support" && pwd)
source "$support/programs.sh"

# dataset KIND FILE [OPTIONS]: prepares a dataset named "volume" of that shape.
dataset() {
  local kind=$1 file=$2
  shift 2
  "$server" generate "$kind" --size 33 -o volume.nrrd --quiet
  "$server" prepare volume.nrrd -o "$file" --force --quiet "$@"
}
# reload: sends SIGHUP and waits until the server has reread the folder.
looks=0
reload() {
  looks=$((looks + 1))
  kill -HUP "$pid"
  for _ in $(seq 600); do
    [ "$(grep -c 'datasets reloaded\|datasets stay' server.log)" -lt "$looks" ] || return 0
    sleep 0.05
  done
  fail "SIGHUP was ignored: $(cat server.log)"
}
digest() { sed -n 's/^ *"content_digest": "\([0-9a-f]*\)",\{0,1\}$/\1/p' "$1" | tail -n 1; }
names() { "$client" list --server "$url" | tail -n +2 | cut -d' ' -f1 | tr '\n' ' '; }
fetched() {  # fetched NAME: prints the digest of its surface.
  "$client" fetch --server "$url" --dataset "$1" --isovalue 0 --normals 8 -o mesh.ply --report mesh.json --quiet
  digest mesh.json
}
reload_failed() { curl -s "$http/metrics" | sed -n 's/^multitetra_last_reload_failed{what="datasets"} //p'; }
tag() { curl -sI "$http/v1/datasets/$1/isosurface?isovalue=0" | tr -d '\r' | sed -n 's/^ETag: //Ip'; }

# SIGHUP while it waits for a store, before it has begun to serve, does not end it.
store=$(free_port)
start silent python3 -c 'import socket, sys, time; s = socket.create_server(("127.0.0.1", int(sys.argv[1]))); print("ready", flush=True); time.sleep(60)' "$store"
for _ in $(seq 200); do grep -q ready silent.log && break; sleep 0.05; done
start waiting "$server" serve "http://127.0.0.1:$store/v.mtd" --store-seconds 60 --tcp 127.0.0.1:0 --http off
sleep 1
kill -HUP "$pid"
sleep 0.2
kill -0 "$pid" || fail "SIGHUP ended a server that was starting"
kill -9 "$pid"

mkdir served
dataset sphere served/a.mtd

# Passwords in addresses are not printed.
start store python3 "$support/serve_folder.py" served
for _ in $(seq 200); do [ -s store.log ] && break; sleep 0.05; done
store=$(cut -d' ' -f1 store.log)
secret=${store/\/\//\/\/reader:a%20secret@}/private
start private "$server" serve "$secret/a.mtd" "$secret/no.mtd" --tcp 127.0.0.1:0 --http off
url_of private tcp >/dev/null
kill -TERM "$pid"
wait "$pid" || true
{ "$server" info "$secret/a.mtd"; "$server" verify "$secret/a.mtd"; "$server" verify "$secret/a.mtd" --json; } >>private.log 2>&1
[ "$(grep -c '//\*\*\*@.*a.mtd' private.log)" -ge 3 ] || fail "the address is not printed: $(cat private.log)"
if grep secret private.log; then fail "the password is printed"; fi

start server "$server" serve served --tcp 127.0.0.1:0 --http 127.0.0.1:0
url=$(url_of server tcp)
http=$(url_of server http)
[ "$(names)" = "volume " ] || fail "not one dataset: $(names)"
sphere=$(fetched volume)
sphere_tag=$(tag volume)

# New datasets, replaced ones (also with the same samples elsewhere in the world), and removed ones.
dataset torus served/a.mtd
dataset gyroid served/b.mtd --name gyroid
[ "$(fetched volume)" = "$sphere" ] || fail "another dataset without SIGHUP"
reload
[ "$(names)" = "gyroid volume " ] || fail "the new dataset is not there: $(names)"
torus=$(fetched volume)
[ "$torus" != "$sphere" ] || fail "a replaced dataset still gives the old surface"
[ "$(tag volume)" != "$sphere_tag" ] || fail "a replaced dataset still has the old tag"
[ "$("$server" extract served/a.mtd --isovalue 0 -o x.ply --json --quiet | sed -n 's/.*content_digest": "\(.*\)",/\1/p')" = "$torus" ] ||
  fail "not the surface of the new file"
torus_tag=$(tag volume)
"$server" generate torus --size 33 -o volume.nrrd --quiet
python3 - <<'PY'
header, samples = open("volume.nrrd", "rb").read().split(b"\n\n", 1)
lines = [line for line in header.split(b"\n") if not line.startswith(b"space origin")]
open("moved.nrrd", "wb").write(b"\n".join(lines + [b"space origin: (70,0,0)"]) + b"\n\n" + samples)
PY
"$server" prepare moved.nrrd -o served/a.mtd --name volume --force --quiet
reload
[ "$(fetched volume)" = "$torus" ] || fail "the same samples elsewhere have another surface on the lattice"
[ "$(tag volume)" != "$torus_tag" ] || fail "a file of other coordinates has the old tag"

# Damaged files, one new and one served before, are logged and change nothing else.
head -c 2000 served/b.mtd >served/broken.mtd
head -c 2000 served/b.mtd >cut && mv cut served/b.mtd
reload
[ "$(names)" = "gyroid volume " ] || fail "a broken file took a dataset away: $(names)"
[ "$(reload_failed)" = 1 ] || fail "metrics do not show the broken file"
grep -q 'skipped: .*broken.mtd' server.log || fail "the broken file is not logged"
grep -q 'still serving the previous version' server.log || fail "the broken replacement is not logged"
fetched gyroid >/dev/null || fail "what was served before is not served any more"
rm served/b.mtd served/broken.mtd
reload
[ "$(names)" = "volume " ] || fail "what is gone is still offered: $(names)"
grep -q 'no longer served' server.log || fail "the removed dataset is not logged"
[ "$(reload_failed)" = 0 ] || fail "metrics show a broken file that is gone"

# An unreadable folder changes nothing.
mv served away
reload
[ "$(names)" = "volume " ] || fail "without its folder the server offers: $(names)"
mv away served

# Nor does an empty one, as of a file system that is not mounted.
mkdir away
mv served/*.mtd away/
reload
[ "$(names)" = "volume " ] || fail "with an empty folder the server offers: $(names)"
[ "$(reload_failed)" = 1 ] || fail "metrics do not show that all datasets are gone"
head -c 2000 away/a.mtd >served/half_copied.mtd
reload
[ "$(names)" = "volume " ] || fail "with nothing but a damaged file the server offers: $(names)"
rm served/half_copied.mtd
mv away/*.mtd served/
reload
[ "$(reload_failed)" = 0 ] || fail "metrics show a failure that is over"

# Running streams receive the surface of the dataset they began with, repeatedly.
for round in 1 2 3; do
  dataset head served/a.mtd --bins "$((round + 8))"
  reload
  begun=$(fetched volume)
  (
    for one in 1 2 3 4 5 6; do
      "$client" fetch --server "$url" --dataset volume --isovalue 0 --error "0.0$one" -o "under_way$one.ply" --quiet || exit 1
    done
  ) &
  fetching=$!
  dataset gyroid served/a.mtd
  reload
  dataset head served/a.mtd
  reload
  wait "$fetching" || fail "a fetch was harmed in round $round (began with $begun)"
done
ends_well server "$pid"
