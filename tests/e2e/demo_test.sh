#!/usr/bin/env bash
# Runs server/demo.sh, the first command of new users, with this build's programs. Usage: demo_test.sh
# DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"

# --- for scripts: everything is made and checked, and nothing keeps running
bash "$project/server/demo.sh" --no-serve --programs "$bin" --output "$work/demo" >demo.log 2>&1 || fail "demo.sh ended with $?: $(cat demo.log)"
for file in demo.mtd demo.ply demo.png demo.svg report.json; do
  [ -s "demo/$file" ] || fail "there is no $file"
done
[ -n "$(ls demo/steps)" ] || fail "there are no previews"
python3 - demo/report.json <<'END' || fail "the report does not promise the requested surface: $(cat demo/report.json)"
import json, sys
report = json.load(open(sys.argv[1]))
assert report["parameters"]["isovalue"] == -300.5 and "error" not in report and report["steps"][-1]["open_edges"] == 0
END
! grep -q "Serving until" demo.log || fail "--no-serve serves"
tail -n 1 demo.log | grep -qE 'Certified +within 0\.[0-9]+ of 0\.25 voxels .*topology kept, [1-9][0-9]* components' ||
  fail "the last line does not say what was certified: $(tail -n 1 demo.log)"
page=$(sed -n 's/^ *\(http:[^ ]*\) in a browser.*/\1/p' demo.log)
! curl -s -o /dev/null --max-time 5 "${page%%#*}" || fail "--no-serve leaves a server"

# --- for users: the address is printed last and serves the page until Ctrl-C
start serving bash "$project/server/demo.sh" --serve --programs "$bin" --output "$work/demo"
for _ in $(seq 1200); do
  grep -q "Serving until" serving.log && break
  kill -0 "$pid" 2>/dev/null || break
  sleep 0.1
done
page=$(tail -n 5 serving.log | sed -n 's/^ *\(http:[^ ]*\)$/\1/p')
[ -n "$page" ] || fail "the last lines have no address: $(tail -n 5 serving.log)"
case "$page" in
  *'/#dataset=visible_female_head&isovalue=-300.5&'*'surfaces=300.5,'*) ;;
  *) fail "the page does not show skin over bone: $page" ;;
esac
curl -s -o datasets.json "${page%%#*}v1/datasets" || true
grep -q '"visible_female_head"' datasets.json || fail "the server at $page does not list its dataset: $(cat datasets.json)"
status=0
kill -TERM "$pid"
wait "$pid" || status=$?
[ "$status" = 0 ] || fail "exit code $status when it is ended: $(cat serving.log)"

# --- in a terminal it serves by default, elsewhere it ends; programs that do nothing suffice for that
mkdir stubs
cat >stubs/multitetra-server <<'END'
#!/bin/sh
[ "$1" = serve ] || exit 0
echo "listening on tcp://127.0.0.1:1 listening" >&2
echo "listening on http://127.0.0.1:2" >&2
exec sleep 60
END
cat >stubs/multitetra-client <<'END'
#!/bin/sh
case "$1" in
  view) echo "http://127.0.0.1:2/" ;;
  fetch) echo '{"isovalue": 1}' >"$(dirname "$0")/../stubbed/report.json" ;;
esac
END
chmod +x stubs/*
demo="bash '$project/server/demo.sh' --programs stubs --output stubbed"
timeout 60 bash -c "$demo" >elsewhere.log 2>&1 || fail "demo.sh ended with $? without a terminal: $(cat elsewhere.log)"
! grep "Serving until" elsewhere.log || fail "it serves without a terminal"
if ! command -v script >/dev/null; then
  echo "!! script is not installed: demo.sh is NOT TESTED in a terminal." >&2
  exit 0
fi
timeout 60 script -qec "$demo --no-serve" /dev/null </dev/null >no_serve.log 2>&1 || fail "--no-serve ended with $? in a terminal: $(cat no_serve.log)"
! grep "Serving until" no_serve.log || fail "--no-serve serves in a terminal"
start terminal script -qefc "exec $demo" /dev/null
for _ in $(seq 200); do
  grep "Serving until" terminal.log >/dev/null && break
  kill -0 "$pid" 2>/dev/null || break
  sleep 0.05
done
grep "Serving until" terminal.log >/dev/null || fail "it does not serve in a terminal: $(cat terminal.log)"
