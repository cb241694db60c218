#!/usr/bin/env bash
# Trials of a server under load and faults, over loopback. Each prints its figures and one row of a table, and fails
# when a guarantee is broken. Run it on an otherwise idle machine; all trials take about ten minutes.
#
#   bash tests/faults/run.sh                     all trials
#   bash tests/faults/run.sh many nuisances      some of those below
#   bash tests/faults/run.sh --quick             seconds of each with a small volume, to test the trials themselves
#   --programs DIR                               uses the programs in DIR instead of building the release preset
#
# many         1000 WebSocket clients, 60 s: no error, memory constant after the first half
# nginx        cached tiles over HTTP, compared with nginx serving the same bytes: at least half of its throughput
# nuisances    50 good clients among 800 that stall, send slowly, disconnect or send garbage: at most twice their times alone
# greedy       a good client and 250 connections with the most work per request: its first preview in 0.5 s, its final
#              step in at most three times its time alone, and cached results immediately
# hoarding     a good client and 250 connections with the most memory per request that read nothing: memory stays within
#              the documented bound, and is freed afterwards
# hoarding-http the same for HTTP responses of all routes, from four addresses, at a server and at a gateway
# many-addresses  a small surface among 200 addresses with long final steps, without tokens: complete within 1 s
# idle-addresses  idle connections from six addresses fill the server: a newcomer is served within 1 s
# changed-file one served file is overwritten, another truncated: only their datasets fail, a third one is served
# cuts         the connection is cut 200 times at random places: the right mesh, and no tile is sent twice
# lost-server  kill -9 of one of two servers behind the gateway: no client loses its result
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$project/tests/faults
quick=false
programs=
trials=()
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) quick=true ;;
    --programs) programs=$(realpath "${2:?--programs needs a folder}"); shift ;;
    -h | --help) sed -n '2,24s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    many | nginx | nuisances | greedy | hoarding | hoarding-http | many-addresses | idle-addresses | changed-file | cuts | lost-server)
      trials+=("$1") ;;
    *) echo "Unknown word $1; see --help." >&2; exit 2 ;;
  esac
  shift
done
[ ${#trials[@]} -gt 0 ] || trials=(many nginx nuisances greedy hoarding hoarding-http many-addresses idle-addresses changed-file cuts lost-server)
if [ -z "$programs" ]; then
  cmake --preset release -S "$project" >/dev/null
  cmake --build "$project/build/release" --target multitetra_server_program multitetra_client_program \
    multitetra_load_program multitetra_gateway_program
  programs=$project/build/release/bin
fi

source "$project/tests/support/programs.sh"
rows=()
left_out=()
leave_out() { left_out+=("$1"); echo "!! LEFT OUT: $1"; }
row() { rows+=("| $1 | $2 | $3 |"); }
# expect WHAT CONDITION...: fails unless the condition, in awk's arithmetic, is true.
expect() { awk "BEGIN { exit !($2) }" || fail "$1: $2"; }
# value FILE KEY...: prints a value of a JSON report.
value() { python3 "$here/json_value.py" "$@"; }
choose() { if [ "$quick" = true ]; then echo "$1"; else echo "$2"; fi; }

# --- starting and measuring a server

"$programs/multitetra-server" generate head --size "$(choose 64 256)" --noise 20 -o head.nrrd --quiet
"$programs/multitetra-server" prepare head.nrrd -o head.mtd --name head --quiet

# Limits that allow a thousand clients from one address.
room=(--max-connections=5000 --max-connections-per-address=5000 --max-requests-per-second=1000000)

# begin NAME COMMAND...: starts it, and sets tcp and http to its listening addresses, if any.
begin() {
  start "$@"
  url_of "$1" '[a-z]*' >/dev/null
  sleep 0.2
  tcp=$(sed -n 's#.*listening on \(\(tcp\|tls\)://[^ "]*\).*#\1#p' "$1.log" | head -n 1)
  http=$(sed -n 's#.*listening on http://\([^ /"]*\).*#\1#p' "$1.log" | head -n 1)
}
begin_server() {
  begin "$1" "$programs/multitetra-server" serve head.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 "${room[@]}"
}
stop() { kill "$1" 2>/dev/null || true; wait "$1" 2>/dev/null || true; }

# Records the resident KiB of a process every half second, until it or this function is stopped.
watch_memory() {
  while kill -0 "$1" 2>/dev/null; do
    sed -n 's/^VmRSS:[^0-9]*\([0-9]*\).*/\1/p' "/proc/$1/status" 2>/dev/null >>"$2" || true
    sleep 0.5
  done
}
# largest FILE FROM TO: the maximum in MiB between two fractions of the time.
largest() {
  awk -v from="$2" -v to="$3" '{ a[NR] = $1 } END { for (i = 1; i <= NR; ++i) if (i > from * NR && i <= to * NR && a[i] > m) m = a[i];
    printf "%.0f", m / 1024 }' "$1"
}
# The resident MiB of a process.
resident() { awk '/^VmRSS/ { printf "%.0f", $2 / 1024 }' "/proc/$1/status"; }
# Prints the median of wrk's runs.
requests_a_second() {
  sed -n 's/^Requests\/sec: *//p' "$1" | sort -n | awk '{ a[NR] = $1 } END { print NR ? a[int((NR + 1) / 2)] : 0 }'
}
load() { "$programs/multitetra-load" --json "$@"; }
# begin_others FILE ARGUMENTS...: runs multitetra-load in the background until end_others. `others` is the process of
# the program itself, not of a shell, so that no client outlives its trial.
begin_others() { "$programs/multitetra-load" --json "${@:2}" >"$1" & others=$!; pids+=("$others"); }
end_others() {
  kill "$others" 2>/dev/null || fail "$1: the others had gone"
  wait "$others" || true
}

# --- the trials

trial_many() {
  local clients duration result=0
  clients=$(choose 20 1000)
  duration=$(choose 3 60)
  begin_server many
  watch_memory "$pid" many.memory &
  local watcher=$!
  load --server "ws://$http" --clients "$clients" --duration "$duration" --grace 120 --script mixed \
    --isovalues 8 --errors 1,2 --pause 4 >many.json || result=$?
  kill -0 "$pid" 2>/dev/null || fail "many: the server is gone"
  stop "$pid"
  stop "$watcher"
  [ "$result" -eq 0 ] || { fail "many: multitetra-load ended with $result"; cat many.json >&2; }
  expect "many: every client was welcomed once" "$(value many.json connections welcomed) == $clients"
  expect "many: no connection was lost" "$(value many.json connections lost) == 0"
  local middle end
  middle=$(largest many.memory 0.25 0.6)
  end=$(largest many.memory 0.6 1)
  [ "$quick" = true ] || expect "many: memory is flat" "$end <= 1.1 * $middle + 16"
  row "$clients WebSocket clients, mixed, $duration s" \
    "$(value many.json streams complete) surfaces, $(value many.json steps) steps, $(value many.json tiles) tiles; errors $(value many.json streams failed); memory $middle MiB until 60 % of the time, $end MiB after" \
    "first tile p50 $(value many.json seconds first_tile p50) s, p99 $(value many.json seconds first_tile p99) s; last tile p50 $(value many.json seconds last_tile p50) s"
}

trial_nuisances() {
  local good each duration phase
  good=$(choose 5 50)
  each=$(choose 10 200)
  duration=$(choose 3 30)
  for phase in alone among; do
    begin_server "nuisances_$phase"
    watch_memory "$pid" "$phase.memory" &
    local watcher=$! others=()
    if [ "$phase" = among ]; then
      for kind in stalled slow leaving garbage; do
        load --server "ws://$http" --script $kind --clients "$each" --ramp 1 --duration $((duration + 4)) --threads 1 >"$kind.json" &
        others+=($!)
      done
      sleep 2
    fi
    local result=0
    load --server "ws://$http" --clients "$good" --duration "$duration" --grace 120 --script random-isovalues --seed 5 >"$phase.json" || result=$?
    [ "$result" -eq 0 ] || { fail "nuisances: $phase, multitetra-load ended with $result"; cat "$phase.json" >&2; }
    for other in "${others[@]}"; do wait "$other" || fail "nuisances: one of them did not come in"; done
    kill -0 "$pid" 2>/dev/null || fail "nuisances: the server is gone"
    stop "$pid"
    stop "$watcher"
  done
  local before after memory
  before=$(value alone.json seconds whole p50)
  after=$(value among.json seconds whole p50)
  memory=$(largest among.memory 0 1)
  [ "$quick" = true ] || expect "nuisances: at most twice the time" "$after <= 2 * $before"
  expect "nuisances: memory is bounded" "$memory <= 2048"
  row "$good good clients among $each stalled, slow, leaving and garbage each" \
    "whole surface p50 $before s alone, $after s among them; p90 $(value alone.json seconds whole p90) s and $(value among.json seconds whole p90) s" \
    "memory $(largest alone.memory 0 1) MiB alone, $memory MiB among them; $(value leaving.json connections made) visits left, $(value garbage.json connections made) of garbage"
}

# Tokens for Alice and Eve: a share of the server each, as for two addresses.
make_tokens() {
  rm -f tokens
  "$programs/multitetra-server" token alice --append tokens >alice.token
  "$programs/multitetra-server" token eve --append tokens >eve.token
}
# one_good_client FILE SECONDS ISOVALUES: runs Alice's client with surfaces of that many isovalues.
one_good_client() {
  load --server "$tcp" --token-file alice.token --clients 1 --threads 1 --duration "$2" --grace 120 --pause 0.1 \
    --script random-isovalues --isovalues "$3" --errors 0.5 --simplify on --seed 7 >"$1" ||
    { fail "a good client ended badly"; cat "$1" >&2; }
}

trial_greedy() {
  local many duration phase others remembered=3
  many=$(choose 20 250)
  duration=$(choose 4 30)
  make_tokens
  for phase in alone among; do
    begin "greedy_$phase" "$programs/multitetra-server" serve head.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 --tokens tokens \
      --max-connections 5000 --max-connections-per-address 5000
    one_good_client "remembered_$phase.json" "$remembered" 1
    if [ "$phase" = among ]; then
      begin_others greedy.json --server "$tcp" --token-file eve.token --script greedy --clients "$many" --ramp 1 --threads 1 \
        --duration $((duration + remembered + 120))
      sleep 3
      one_good_client "remembered_$phase.json" "$remembered" 1
    fi
    one_good_client "$phase.json" "$duration" 100000
    if [ "$phase" = among ]; then
      end_others greedy
    fi
    kill -0 "$pid" 2>/dev/null || fail "greedy: the server is gone"
    stop "$pid"
  done
  expect "greedy: surfaces came" "$(value among.json streams complete) > 0 && $(value among.json streams failed) == 0"
  expect "greedy: what is remembered came" "$(value remembered_among.json streams complete) > 0"
  if [ "$quick" = false ]; then
    expect "greedy: the first preview" "$(value among.json seconds first_tile p50) <= 0.5"
    expect "greedy: the final step" "$(value among.json seconds whole p50) <= 3 * $(value alone.json seconds whole p50)"
    expect "greedy: what is remembered" "$(value remembered_among.json seconds whole p50) <= 0.5"
  fi
  row "one good client beside $many connections of another that ask for all they may" \
    "first tile p50 $(value alone.json seconds first_tile p50) s alone, $(value among.json seconds first_tile p50) s among them; whole surface $(value alone.json seconds whole p50) s and $(value among.json seconds whole p50) s" \
    "remembered surface p50 $(value remembered_alone.json seconds whole p50) s alone, $(value remembered_among.json seconds whole p50) s among them, at most $(value remembered_among.json seconds whole max) s"
}

trial_hoarding() {
  local many duration before peak after bound
  many=$(choose 40 250)
  duration=$(choose 4 20)
  make_tokens
  begin hoarding "$programs/multitetra-server" serve head.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 --tokens tokens \
    --max-connections 5000 --max-connections-per-address 5000 --queue-bytes 256MiB --cache-bytes 64MiB
  one_good_client before.json "$(choose 2 5)" 4
  sleep 4  # Free memory is returned meanwhile.
  before=$(resident "$pid")
  watch_memory "$pid" hoarding.memory &
  local watcher=$!
  load --server "$tcp" --token-file eve.token --script hoarding --clients "$many" --ramp 1 --threads 1 \
    --duration "$duration" >hoarding.json || fail "hoarding: they did not come in"
  one_good_client among.json "$(choose 2 5)" 4
  kill -0 "$pid" 2>/dev/null || fail "hoarding: the server is gone"
  # Running work ends at its next tile, and its memory is returned soon after.
  local seconds=0
  after=$(resident "$pid")
  while [ "$seconds" -lt 60 ] && awk "BEGIN { exit !($after > 1.5 * $before + 64) }"; do
    sleep 1
    seconds=$((seconds + 1))
    after=$(resident "$pid")
  done
  stop "$pid"
  stop "$watcher"
  peak=$(largest hoarding.memory 0 1)
  # Queue and cache, a message of 2 MiB and 64 KiB of buffers per connection, and the memory used before.
  bound=$(awk "BEGIN { printf \"%.0f\", 256 + 64 + $many * 2.1 + $before }")
  expect "hoarding: memory is within the documented bound" "$peak <= $bound"
  expect "hoarding: memory comes back" "$after <= 1.5 * $before + 64"
  row "$many connections that ask for what takes memory and read nothing" \
    "at most $peak MiB, where $bound MiB are documented; $before MiB before, $after MiB $seconds s after" \
    "a good client meanwhile: whole surface p50 $(value among.json seconds whole p50) s"
}

# hoards_http NAME: clients that do not read hold responses of the program at `http`, whose process is `pid`.
hoards_http() {
  local name=$1 many duration before peak after bound paths
  many=$(choose 40 400)
  duration=$(choose 4 20)
  curl -sf "http://$http/v1/datasets/head/isosurface?error=0.5&format=stl" -o mesh.stl || fail "$name: there is no surface"
  curl -sf "http://$http/v1/3dtiles/head/iso/500/tileset.json" -o tileset.json || fail "$name: there is no tileset"
  before=$(resident "$pid")
  watch_memory "$pid" hoarding_http.memory &
  local watcher=$!
  paths=(/v1/datasets/head/slice?format=raw\&width=2048\&height=1024 "/v1/datasets/head/probe?at=1,2,3" /v1/datasets/head
    /v1/datasets/head/thumbnail.png /v1/neuroglancer/head/surfaces/info /v1/neuroglancer/head/image/1_1_1/0-64_0-64_0-64
    "/v1/datasets/head/isosurface?error=0.5&format=stl" "/v1/3dtiles/head/iso/500/$(value tileset.json root content uri)")
  python3 "$here/unread_answers.py" "$http" --clients "$many" --addresses 4 --seconds "$duration" "${paths[@]}" >hoarding_http.json ||
    fail "$name: they did not come in"
  curl -sf --max-time 30 "http://$http/v1/datasets/head/slice?width=64&height=64" -o slice.png || fail "$name: others are not served"
  kill -0 "$pid" 2>/dev/null || fail "$name: the program is gone"
  sleep 4  # Free memory is returned meanwhile.
  after=$(resident "$pid")
  stop "$watcher"
  peak=$(largest hoarding_http.memory 0 1)
  # Queue and cache, 64 KiB and a chunk of a mesh file per connection, slices in progress, and the memory used before.
  bound=$(awk "BEGIN { printf \"%.0f\", 256 + 64 + 320 + $many * 0.4 + $before }")
  expect "$name: answers came" "$(value hoarding_http.json answered) > 0"
  expect "$name: memory is within the documented bound" "$peak <= $bound"
  row "$name: $many HTTP connections of four addresses that read nothing of what all routes send" \
    "at most $peak MiB, where $bound MiB are documented; $before MiB before, $after MiB after" \
    "$(value hoarding_http.json answered) answers begun, $(value hoarding_http.json refused) refused"
}

trial_hoarding_http() {
  local limits=(--max-connections 5000 --max-connections-per-address 5000 --max-requests-per-second 1000000
    --queue-bytes 256MiB --cache-bytes 64MiB)
  begin hoarding_http "$programs/multitetra-server" serve head.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 "${limits[@]}"
  hoards_http hoarding-http
  local server=$pid
  begin hoarding_gateway "$programs/multitetra-gateway" --upstream "$tcp" --tcp off --http 127.0.0.1:0 "${limits[@]}"
  hoards_http "hoarding-http at a gateway"
  stop "$pid"
  stop "$server"
}

# small_surfaces FILE SECONDS: a client at 127.0.0.1 that requests distinct surfaces of the small dataset.
small_surfaces() {
  load --server "$tcp" --dataset small --clients 1 --threads 1 --duration "$2" --grace 60 --pause 0.2 \
    --script random-isovalues --isovalues 100000 --errors 0.5 --seed 11 >"$1" || { fail "a client of another address ended badly"; cat "$1" >&2; }
}
begin_two_datasets() {
  if [ ! -e small.mtd ]; then
    "$programs/multitetra-server" generate head --size 32 --noise 20 -o small.nrrd --quiet
    "$programs/multitetra-server" prepare small.nrrd -o small.mtd --name small --quiet
  fi
  begin "$1" "$programs/multitetra-server" serve head.mtd small.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 "${@:2}"
}

trial_many_addresses() {
  local many duration others
  many=$(choose 20 200)
  duration=$(choose 3 20)
  begin_two_datasets many_addresses
  small_surfaces many_alone.json "$duration"
  begin_others many_addresses.json --server "$tcp" --dataset head --script greedy --clients "$many" --from 127.0.1.0/24 \
    --ramp 1 --threads 1 --duration $((duration + 60))
  sleep 5
  small_surfaces many_among.json "$duration"
  end_others many-addresses
  kill -0 "$pid" 2>/dev/null || fail "many-addresses: the server is gone"
  stop "$pid"
  expect "many-addresses: surfaces came" "$(value many_among.json streams complete) > 0 && $(value many_among.json streams failed) == 0"
  [ "$quick" = true ] || expect "many-addresses: within a second" "$(value many_among.json seconds whole p90) <= 1"
  row "a small surface beside $many addresses with long final steps" \
    "whole surface p50 $(value many_alone.json seconds whole p50) s alone, $(value many_among.json seconds whole p50) s among them" \
    "p90 $(value many_among.json seconds whole p90) s, at most $(value many_among.json seconds whole max) s of $(value many_among.json streams complete)"
}

trial_idle_addresses() {
  local connections=$((6 * 10)) others before took
  begin_two_datasets idle_addresses --max-connections "$connections" --max-connections-per-address 10
  begin_others idle_addresses.json --server "$tcp" --dataset small --clients 1 --idle $((connections - 1)) --from 127.0.1.0/29 \
    --ramp 1 --threads 1 --pause 3600 --duration 60 --script random-isovalues
  sleep 3
  before=$(date +%s%N)
  "$programs/multitetra-client" fetch --server "$tcp" --dataset small --isovalue 500 --error 0.5 --retries 0 --quiet -o mesh.ply ||
    fail "idle-addresses: a newcomer is not served"
  took=$(awk "BEGIN { printf \"%.2f\", ($(date +%s%N) - $before) / 1e9 }")
  end_others idle-addresses
  curl -sf "http://$http/metrics" >metrics.txt
  grep -q 'multitetra_refused_total.*limit="connections"' metrics.txt || fail "idle-addresses: none was sent away: $(cat metrics.txt)"
  stop "$pid"
  [ "$quick" = true ] || expect "idle-addresses: within a second" "$took <= 1"
  row "$connections idle connections of six addresses, which is all that the server takes" "a newcomer has its surface after $took s" \
    "the longest idle connection was sent away"
}

trial_changed_file() {
  local name
  for name in overwritten cut whole; do
    "$programs/multitetra-server" prepare head.nrrd -o $name.mtd --name $name --quiet
  done
  begin changed "$programs/multitetra-server" serve overwritten.mtd cut.mtd whole.mtd --tcp 127.0.0.1:0 --http off
  fetch_one() { "$programs/multitetra-client" fetch --server "$tcp" --dataset "$1" --isovalue "$2" --error 0.5 --retries 0 --quiet -o mesh.ply; }
  for name in overwritten cut whole; do fetch_one $name 500 || fail "changed-file: $name cannot be fetched before"; done
  dd if=/dev/urandom of=overwritten.mtd bs=4096 seek=1 count=16 conv=notrunc status=none
  truncate -s 5000 cut.mtd
  for name in overwritten cut; do
    ends 1 'damaged' fetch_one $name 600
    ends 1 'damaged' fetch_one $name 700
  done
  fetch_one whole 600 || fail "changed-file: the good one cannot be fetched after"
  grep -q 'overwritten.mtd.*was overwritten while it was open' changed.log || fail "changed-file: the log does not say what happened"
  ends_well changed "$pid"
  row "a served file overwritten, another one cut" "errors of these datasets, which the log explains" "a third one is served on"
}

trial_cuts() {
  local cuts number=0 done=0
  cuts=$(choose 10 200)
  begin_server cuts
  local upstream=${tcp#tcp://} server_pid=$pid
  begin proxy python3 "$here/cutting_proxy.py" "$upstream" --cuts "$cuts" --largest "$(choose 30000 150000)" --count proxy.count
  local proxy=$tcp proxy_pid=$pid
  while [ "$done" -lt "$cuts" ] && [ "$number" -lt 60 ]; do
    local isovalue=$((300 + 10 * number)) way
    for way in straight cut; do
      "$programs/multitetra-client" fetch --server "$([ $way = cut ] && echo "$proxy" || echo "tcp://$upstream")" \
        --dataset head --isovalue "$isovalue" --error 0.5 --retries 1000 --quiet -o mesh.ply --report "$way.json" ||
        fail "cuts: isovalue $isovalue, $way: no mesh"
    done
    [ "$(value cut.json steps -1 content_digest)" = "$(value straight.json steps -1 content_digest)" ] ||
      fail "cuts: isovalue $isovalue: another mesh"
    expect "cuts: isovalue $isovalue: no tile twice" "$(value cut.json tiles_received) == $(value straight.json tiles_received)"
    number=$((number + 1))
    done=$(cat proxy.count 2>/dev/null || echo 0)
  done
  stop "$proxy_pid"
  stop "$server_pid"
  expect "cuts: there were enough of them" "$done >= $cuts"
  row "the connection cut $done times at random places" "$number surfaces complete, each with the digest of an undisturbed fetch" \
    "no tile received twice"
}

trial_lost_server() {
  if [ ! -x "$programs/multitetra-gateway" ]; then
    leave_out "lost-server: there is no multitetra-gateway in $programs"
    return
  fi
  local clients duration result=0
  clients=$(choose 8 100)
  duration=$(choose 5 30)
  begin_server first
  local first=$pid first_at=$tcp
  begin_server second
  local second=$pid second_at=$tcp
  begin gateway "$programs/multitetra-gateway" --upstream "$first_at" --upstream "$second_at" --http 127.0.0.1:0 "${room[@]}"
  local gateway=$pid
  # Names determine the server of a dataset: the one with more processor time serves this one.
  ( sleep $((duration / 3)); 
    a=$(awk '{ print $14 + $15 }' "/proc/$first/stat"); b=$(awk '{ print $14 + $15 }' "/proc/$second/stat")
    victim=$first; [ "$a" -ge "$b" ] || victim=$second
    kill -9 "$victim"; echo "$victim" >victim ) &
  load --server "ws://$http" --clients "$clients" --duration "$duration" --grace 120 --script mixed --isovalues 16 >lost.json || result=$?
  [ "$result" -eq 0 ] || { fail "lost-server: multitetra-load ended with $result"; cat lost.json >&2; }
  [ -s victim ] || fail "lost-server: nothing was killed"
  kill -0 "$gateway" 2>/dev/null || fail "lost-server: the gateway is gone"
  expect "lost-server: no result was lost" "$(value lost.json streams failed) + $(value lost.json streams unfinished) == 0"
  stop "$gateway"; stop "$first"; stop "$second"
  row "kill -9 of the busy one of two servers behind the gateway, $clients clients" \
    "$(value lost.json streams complete) surfaces complete, none lost; $(value lost.json tiles_sent_twice) tiles twice" \
    "$(value lost.json connections lost) clients saw their connection lost; longest wait $(value lost.json seconds whole max) s"
}

trial_nginx() {
  if ! command -v nginx >/dev/null || ! command -v wrk >/dev/null; then
    leave_out "nginx: nginx-light and wrk are not installed"
    return
  fi
  begin_server tiles
  local server_pid=$pid
  "$programs/multitetra-client" fetch --server "$tcp" --dataset head --error 0.5 --resume kept --quiet -o mesh.ply >/dev/null
  mkdir -p www/v1/tiles
  local file path
  for file in kept/*.tile; do
    path=/v1/tiles/$(basename "$file" .tile)
    if curl -sf "http://$http$path" -o "www$path"; then echo "$path" >>paths; fi
  done
  if [ -z "$(ls www/v1/tiles)" ]; then
    stop "$server_pid"
    leave_out "nginx: the server gives no tiles over HTTP"
    return
  fi
  local port
  port=$(free_port)
  sed "s#FOLDER#$work#; s#PORT#$port#; s#USER#$(id -un)#; s#GROUP#$(id -gn)#" "$here/static_files.conf" >nginx.conf
  start nginx nginx -p "$work" -c "$work/nginx.conf"
  local nginx_pid=$pid
  for _ in $(seq 100); do
    if curl -sf "http://127.0.0.1:$port$path" -o same; then break; fi
    sleep 0.1
  done
  cmp same "www$path" || fail "nginx: it serves other bytes"
  local seconds round
  seconds=$(choose 1 10)
  for round in 1 2 3; do
    [ "$quick" = false ] || [ "$round" = 1 ] || continue
    wrk -t1 -c32 -d"${seconds}s" -s "$here/tiles.lua" "http://$http" >>wrk_server.txt
    wrk -t1 -c32 -d"${seconds}s" -s "$here/tiles.lua" "http://127.0.0.1:$port" >>wrk_nginx.txt
  done
  stop "$nginx_pid"
  stop "$server_pid"
  local ours theirs
  if grep -q 'Non-2xx' wrk_server.txt wrk_nginx.txt; then fail "nginx: some requests were refused"; fi
  ours=$(requests_a_second wrk_server.txt)
  theirs=$(requests_a_second wrk_nginx.txt)
  expect "nginx: something was served" "$ours > 0 && $theirs > 0"
  [ "$quick" = true ] || expect "nginx: at least half of its throughput" "$ours >= 0.5 * $theirs"
  row "cached tiles over HTTP, $(ls www/v1/tiles | wc -l) of them, 32 connections" "$ours requests a second, nginx $theirs" \
    "$(awk "BEGIN { printf \"%.2f\", $ours / $theirs }") of nginx, one thread each"
}

for trial in "${trials[@]}"; do
  echo "== $trial"
  "trial_${trial//-/_}"
done
echo
echo "| trial | result | figures |"
echo "| --- | --- | --- |"
printf '%s\n' "${rows[@]}"
for what in "${left_out[@]}"; do echo "!! LEFT OUT: $what"; done
