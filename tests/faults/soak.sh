#!/usr/bin/env bash
# A mixed soak test of a server, and of a gateway in front of two servers. Good clients, whose meshes are all checked,
# and readers of slices, values, 3D Tiles and sample shells run together with all kinds of misbehaving clients, while
# tokens are revoked, certificates and tokens reloaded, datasets replaced, and servers killed and restarted. Another
# server reads its dataset from a web server and keeps blocks in a folder, which others damage; one client's connections
# are cut. Fails when a good client fails, when a process ends by itself, when there are more open files or threads at the end than halfway
# (with caches already full), or when memory grows in the second half: the mean over the last quarter of the rounds is
# compared with that over the quarter before. Prints a row of a table. Run it on an otherwise idle machine.
#
#   bash tests/faults/soak.sh MINUTES            with the programs of the release preset
#   --programs DIR                               with those in DIR, also of the asan and tsan presets
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
minutes=
programs=
while [ $# -gt 0 ]; do
  case "$1" in
    --programs) programs=$(realpath "${2:?--programs needs a folder}"); shift ;;
    -h | --help) sed -n '2,12s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *[!0-9.]*) echo "Unknown word $1; see --help." >&2; exit 2 ;;
    *) minutes=$1 ;;
  esac
  shift
done
[ -n "$minutes" ] || { echo "For how many minutes? See --help." >&2; exit 2; }
if [ -z "$programs" ]; then
  cmake --preset release -S "$project" >/dev/null
  cmake --build "$project/build/release" --target multitetra_server_program multitetra_client_program \
    multitetra_load_program multitetra_gateway_program
  programs=$project/build/release/bin
fi
source "$project/tests/support/programs.sh"
value() { python3 "$project/tests/faults/json_value.py" "$@"; }

# The sanitizer's quarantine of freed memory, 256 MiB by default, would look like a leak.
export ASAN_OPTIONS=${ASAN_OPTIONS:-quarantine_size_mb=16}

server=$programs/multitetra-server
end=$(awk "BEGIN { printf \"%d\", $(date +%s) + 60 * $minutes }")
halfway=$(awk "BEGIN { printf \"%d\", $(date +%s) + 30 * $minutes }")
round_seconds=20

# --- the datasets: two, one of which is repeatedly replaced by an identical one

"$server" generate head --size 64 --noise 20 -o head.nrrd --quiet
mkdir served
for name in head other; do "$server" prepare head.nrrd -o served/$name.mtd --name $name --quiet; done
"$server" token alice --append tokens >alice.token
"$server" token eve --append tokens >eve.token
grep -v '^eve ' tokens >tokens.without

limits=(--max-connections 400 --max-connections-per-address 350 --mesh-cache-bytes 16MiB --handshake-seconds 3
  --write-seconds 5 --log-level warning)
limits_of_workers=(--queue-bytes 128MiB --cache-bytes 64MiB --max-waiting-seconds 120)
a_port=$(free_port) b_port=$(free_port) gateway_port=$(free_port) http_port=$(free_port) remote_port=$(free_port)
serve() { start "$1" "$server" serve served --tcp "127.0.0.1:$2" --http "$3" --tokens tokens "${limits[@]}" \
  "${limits_of_workers[@]}"; }
serve steady "$(free_port)" "127.0.0.1:$http_port"; steady=$pid
serve a "$a_port" off; a=$pid
serve b "$b_port" off; b=$pid
start gateway "$programs/multitetra-gateway" --upstream "tcp://127.0.0.1:$a_port" --upstream "tcp://127.0.0.1:$b_port" \
  --tcp off --http "127.0.0.1:$gateway_port" "${limits[@]}"
gateway=$pid
mkdir stored
cp served/head.mtd stored/
start store python3 "$project/tests/support/serve_folder.py" stored
until [ -s store.log ]; do sleep 0.1; done
start remote "$server" serve "$(cut -d ' ' -f 1 store.log)/head.mtd" --cache-dir blocks --brick-bytes 256KiB --cache-bytes 1MiB \
  --tcp off --http "127.0.0.1:$remote_port" --tokens tokens "${limits[@]}"
remote=$pid
is_there() {
  for _ in $(seq 600); do curl -sf "http://127.0.0.1:$1/readyz" >/dev/null && return; sleep 0.1; done
  fail "no server is ready at port $1"
}
is_there "$http_port"; is_there "$gateway_port"; is_there "$remote_port"
start proxy python3 "$project/tests/faults/cutting_proxy.py" "127.0.0.1:$http_port" --cuts 1000000000 --largest 30000 --count cuts
proxy=$(url_of proxy tcp)

# --- one round

# good NAME PORT: runs conversations whose meshes are all checked.
good() {
  "$programs/multitetra-load" --json --server "ws://127.0.0.1:$2" --token-file alice.token --clients 4 --threads 1 \
    --duration "$round_seconds" --grace 240 --script mixed --isovalues 16 --errors 0.5,2 --check full --pause 0.3 \
    --seed "$RANDOM" >"$1.json" 2>"$1.errors"
}
bad() {
  "$programs/multitetra-load" --json --server "ws://127.0.0.1:$2" --token-file eve.token --clients "$3" --threads 1 \
    --duration $((round_seconds - 2)) --ramp 1 --script "$1" --seed "$RANDOM" >"$1.json" 2>/dev/null
}
meshes() {
  local i
  for i in $(seq 8); do
    curl -s -m "$round_seconds" -H "Authorization: Bearer $(cat eve.token)" --limit-rate 20k -o /dev/null \
      "http://127.0.0.1:$http_port/v1/datasets/head/isosurface?isovalue=$((300 + RANDOM % 600))&error=1&format=obj" || true
  done
}
# HTTP responses that are never read: slices, meshes, cells of 3D Tiles, from four addresses.
unread() {
  python3 "$project/tests/faults/unread_answers.py" "127.0.0.1:$http_port" --clients 40 --addresses 4 \
    --seconds $((round_seconds - 2)) --token-file eve.token "/v1/datasets/head/slice?format=raw&width=1024&height=1024" \
    "/v1/datasets/head/isosurface?error=0.5&format=stl" /v1/3dtiles/head/iso/500/tileset.json \
    "/v1/datasets/head/probe?at=1,2,3" >unread.json 2>/dev/null
}
# Requests the path $2 into the file $1, again where the server says that it is busy (503).
get() {
  local status i
  for i in $(seq 6); do
    status=$(curl -sS -m 240 -o "$1" -w '%{http_code}' -H "Authorization: Bearer $(cat alice.token)" \
      "http://127.0.0.1:$http_port$2") || return 1
    [ "$status" = 503 ] || break
    sleep "$i"
  done
  [ "$status" = 200 ]
}
# Reads slices, values and surfaces of 3D Tiles with separate HTTP clients; the bytes are the same each time.
readers() {
  local i cell
  for i in $(seq 8); do
    get slice.raw "/v1/datasets/head/slice?format=raw&width=256&height=256&normal=0,1,1" || return 1
    [ ! -e slice.first ] || cmp slice.raw slice.first || return 1
    mv slice.raw slice.first
    get value.json "/v1/datasets/head/probe?at=1,2,3&coordinates=index" || return 1
    get tileset.json "/v1/3dtiles/head/iso/500/tileset.json" || return 1
    cell=$(value tileset.json root content uri)
    get cell.glb "/v1/3dtiles/head/iso/500/$cell" || return 1
    [ ! -e cell.first ] || cmp cell.glb cell.first || return 1
    mv cell.glb cell.first
    sleep 1
  done
}
# Fetches surfaces to display, sent as sample shells; the meshes are the same each time.
shells() {
  PYTHONPATH=$programs/../python /usr/bin/python3 - "ws://127.0.0.1:$http_port" alice.token shells.first <<'EOF'
import pathlib, sys
import multitetra
url, token, first = sys.argv[1], pathlib.Path(sys.argv[2]).read_text().strip(), pathlib.Path(sys.argv[3])
with multitetra.connect(url, token=token) as server:
    found = ""
    for isovalue in (400, 500, 600):
        for error in (0, 1):
            last = list(server.steps("head", isovalue, display=True, error=error))[-1]
            assert last.is_final and len(last.mesh.faces) > 0, last
            found += f"{isovalue} {error} {last.digest}\n"
if first.exists():
    assert first.read_text() == found, found
first.write_text(found)
EOF
}
# Writes one wrong byte into some of the cached blocks.
damage() {
  local i file
  for i in $(seq 8); do
    for file in $(find blocks -type f -size +9c | shuf -n 4); do
      printf '\252' | dd of="$file" bs=1 seek=$((RANDOM * RANDOM % $(stat -c %s "$file"))) conv=notrunc status=none 2>/dev/null || true
    done
    sleep 1
  done
}
# Fetches a surface over connections that are cut, and without cuts.
over_cuts() {
  local way isovalue=$((300 + RANDOM % 600))
  for way in "ws://${proxy#tcp://}" "ws://127.0.0.1:$http_port"; do
    "$programs/multitetra-client" fetch --server "$way" --token-file alice.token --dataset head --isovalue "$isovalue" --error 1 \
      --retries 1000 --quiet -o cut.ply --report "cut_${way##*:}.json" || return 1
  done
  [ "$(value "cut_${proxy##*:}.json" steps -1 content_digest)" = "$(value "cut_$http_port.json" steps -1 content_digest)" ]
}
shake() {
  sleep 2
  kill -HUP "$steady" "$a" "$b" "$gateway"
  sleep 2
  cp tokens tokens.all && cp tokens.without tokens.new && mv tokens.new tokens && kill -HUP "$steady"  # Disconnects Eve.
  "$server" prepare head.nrrd -o served/other.mtd --name other --quiet
  sleep 2
  mv tokens.all tokens && kill -HUP "$steady"
  sleep 2
}
# restart NAME: kills (-9) a server behind the gateway and starts another in its place.
restart() {
  local -n process=$1
  local port=$1_port
  kill -9 "$process" && { wait "$process" 2>/dev/null || true; }
  sleep 1
  serve "$1" "${!port}" off
  process=$pid
}

# MiB, open files, threads. Excludes unnamed files: these are cached meshes, bounded by --mesh-cache-bytes.
state_of() {
  echo "$(awk '/^VmRSS/ { printf "%d", $2 / 1024 }' "/proc/$1/status")" \
    "$(find "/proc/$1/fd" -mindepth 1 ! -lname '*/#* (deleted)' | wc -l)" \
    "$(awk '/^Threads/ { print $2 }' "/proc/$1/status")"
}
rest() { sleep 8; }  # Until lingering connections have closed and free memory is returned.

has_python=
if PYTHONPATH=$programs/../python /usr/bin/python3 -c 'import multitetra' 2>/dev/null; then
  has_python=yes
else
  echo "!! LEFT OUT: sample shells: there is no Python package beside the programs."
fi
round=0
streams=0
declare -A before memory  # The state at the end of the first half; MiB in the third and the last quarter.
while [ "$(date +%s)" -lt "$end" ] || [ "$round" -lt 2 ]; do
  round=$((round + 1))
  jobs_of_round=()
  good good_steady "$http_port" & steady_good=$!
  good good_gateway "$gateway_port" & gateway_good=$!
  good good_remote "$remote_port" & remote_good=$!
  damage & jobs_of_round+=($!)
  over_cuts >cut.log 2>&1 & cutting=$!
  for kind in stalled slow leaving garbage; do bad $kind "$http_port" 10 & jobs_of_round+=($!); done
  bad greedy "$http_port" 20 & jobs_of_round+=($!)
  bad hoarding "$http_port" 20 & jobs_of_round+=($!)
  meshes & jobs_of_round+=($!)
  unread & jobs_of_round+=($!)
  readers >readers.log 2>&1 & reading=$!
  showing=
  if [ -n "$has_python" ]; then shells >shells.log 2>&1 & showing=$!; fi
  shake & shaking=$!
  if [ $((round % 2)) = 0 ]; then sleep 5; restart "$([ $((round % 4)) = 0 ] && echo a || echo b)"; fi
  wait "$shaking" || fail "round $round: tokens or datasets could not be replaced"
  wait "$steady_good" || { fail "round $round: a client of the server failed"; cat good_steady.json good_steady.errors >&2; }
  wait "$gateway_good" || { fail "round $round: a client of the gateway failed"; cat good_gateway.json good_gateway.errors >&2; }
  wait "$remote_good" || { fail "round $round: a client of the remote dataset failed"; cat good_remote.json good_remote.errors >&2; }
  wait "$cutting" || { fail "round $round: a fetch over cut connections"; cat cut.log >&2; }
  wait "$reading" || { fail "round $round: slices, values or cells of HTTP"; cat readers.log >&2; }
  [ -z "$showing" ] || wait "$showing" || { fail "round $round: sample shells"; cat shells.log >&2; }
  for job in "${jobs_of_round[@]}"; do wait "$job" || true; done  # Their results do not matter.
  for name in steady a b gateway remote; do
    kill -0 "${!name}" 2>/dev/null || { fail "round $round: $name ended"; tail -50 $name.log >&2; }
  done
  [ "$failed" = 0 ] || exit 1
  streams=$((streams + $(value good_steady.json streams complete) + $(value good_gateway.json streams complete) + $(value good_remote.json streams complete)))
  rest
  for name in steady gateway remote; do
    now=$(state_of "${!name}")
    echo "${now%% *}" >>"$name.memory"
    if [ -z "${before[$name]:-}" ] || [ "$(date +%s)" -lt "$halfway" ]; then before[$name]=$now; fi
    echo "round $round, $name: $now (MiB, open files, threads); $streams surfaces so far"
  done
done

# --- the results

# Mean MiB of the third quarter of the rounds and of the last one.
late_means() {
  awk '{ mib[NR] = $1 }
    END {
      for (i = int(NR / 2) + 1; i <= NR; i++) if (i <= 3 * NR / 4) { third += mib[i]; n++ } else { last += mib[i]; m++ }
      printf "%.0f %.0f\n", n ? third / n : mib[1], last / m
    }' "$1.memory"
}
# Sanitizers' allocators retain freed memory for a while, and few rounds do not fill the caches.
growth=1.05 slack=4
if [ "$round" -lt 24 ] || grep -qE "MULTITETRA_SANITIZE:[A-Z]*=." "$programs/../CMakeCache.txt" 2>/dev/null; then growth=1.5 slack=64; fi

for name in steady gateway remote; do
  read -r _ files threads <<<"$(state_of "${!name}")"
  read -r _ files_before threads_before <<<"${before[$name]}"
  read -r third last <<<"$(late_means $name)"
  memory[$name]="$third, $last"
  awk "BEGIN { exit !($last <= $growth * $third + $slack) }" ||
    fail "$name: memory grows: $third MiB in the third quarter, $last in the last one"
  [ "$files" -le $((files_before + 16)) ] || fail "$name: $files open files, $files_before halfway"
  [ "$threads" -le $((threads_before + 2)) ] || fail "$name: $threads threads, $threads_before halfway"
done
for name in steady a b gateway remote; do
  grep -qE 'ERROR: AddressSanitizer|runtime error:|WARNING: ThreadSanitizer' $name.log &&
    { fail "$name: a sanitizer complains"; grep -A30 -E 'Sanitizer|runtime error:' $name.log | head -60 >&2; }
  ends_well $name "${!name}"
done
echo "$round rounds, $streams surfaces of good clients, every one checked."
echo
echo "| minutes | rounds | surfaces, all checked | server: MiB in the third quarter, in the last | gateway | remote dataset | cuts | failures |"
echo "| --- | --- | --- | --- | --- | --- | --- | --- |"
echo "| $minutes | $round | $streams | ${memory[steady]} | ${memory[gateway]} | ${memory[remote]} | $(cat cuts) | $failed |"
