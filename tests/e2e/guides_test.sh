#!/usr/bin/env bash
# Runs the commands of README.md, client/FETCHING.md, server/volume/FORMATS.md and server/operations/DEPLOYMENT.md
# unchanged, on small generated volumes, and checks that all options named in guides exist.
# Usage: guides_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"
export PATH=$bin:$PATH

# commands_of PAGE: its indented lines with smaller sizes, without those that set up a shell or a server.
commands_of() {
  sed -n 's/^    //p' "$root/$1" | grep -v '^PATH=\|^bash \|^docker run \|/multitetra view \| serve .*&' |
    sed 's/--size 128/--size 48/; s/--min-component 12/--min-component 2/; s/1920x1080/192x108/; s/at=64,64,64/at=24,24,24/
         s/box:40,60,20,90,110,70/box:4,6,2,30,40,40/; s/at=64/at=24/; s/--max-bytes 100000/--max-bytes 50000/'
}

commands_of client/FETCHING.md >fetching
sed '/generate gyroid/q' fetching >setup
sed '1,/generate gyroid/d' fetching >commands
grep -q 'threshold-grid importance.nrrd' commands || fail "client/FETCHING.md has no commands: $(cat fetching)"
bash -euo pipefail setup >out 2>&1 || fail "client/FETCHING.md up to serving: $(tail -n 3 out)"
start server multitetra-server serve head.nrrd warmth.nrrd --volume-cache cache --tcp 127.0.0.1:0 --http 127.0.0.1:0
MULTITETRA_SERVER=$(url_of server tcp)
export MULTITETRA_SERVER
page=$(url_of server http)
sed -i "s|http://127.0.0.1:7480|${page%/}|" commands
bash -euo pipefail commands >out 2>&1 || fail "client/FETCHING.md from serving on: $(tail -n 5 out)"
for file in head.ply both.glb head.vtu head.svg head.png slice.png; do
  [ -s "$file" ] || fail "client/FETCHING.md made no $file"
done

commands_of README.md >commands
grep -q 'certify head.ply' commands || fail "README.md has no commands: $(cat commands)"
bash -euo pipefail commands >out 2>&1 || fail "README.md: $(tail -n 5 out)"

# Runs every command of the formats guide whose input tests/e2e/guide_volumes.py can write.
commands_of server/volume/FORMATS.md >formats
mkdir formats_work
cp head.nrrd head.mtd formats_work/
(cd formats_work && python3 "$root/tests/e2e/guide_volumes.py") || fail "guide_volumes.py"
runs=0
while IFS= read -r line; do
  input=$(sed "s/^multitetra-server [a-z]* //; s/ .*//; s/'//g" <<<"$line")
  compgen -G "formats_work/$input" >/dev/null || continue
  runs=$((runs + 1))
  (cd formats_work && bash -euo pipefail -c "$line") >out 2>&1 || fail "server/volume/FORMATS.md: $line ($(tail -n 3 out))"
done < <(sed 's/  *#.*//' formats)
[ "$runs" -ge 14 ] || fail "server/volume/FORMATS.md: only $runs commands were run"

level=$(multitetra-server info formats_work/map.mtd --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["suggested_isovalues"][0])')
[ "$level" = 12.5 ] || fail "the first isovalue is $level, not the contour level of emd-1234.xml"

# Deployment guide: tokens, a certificate, a configuration, and a server that uses them.
mkdir deployment volumes
cp head.mtd volumes/
commands_of server/operations/DEPLOYMENT.md | sed 's|/srv/volumes|../volumes|; s/0\.0\.0\.0:[0-9]*/127.0.0.1:0/g' >commands
{ grep '^multitetra-server token\|^openssl\|--print-config' commands | sed 's/  *#.*//'; } >setup
[ "$(wc -l <setup)" = 6 ] || fail "server/operations/DEPLOYMENT.md has other commands: $(cat setup)"
(cd deployment && bash -euo pipefail ../setup) >out 2>&1 || fail "server/operations/DEPLOYMENT.md: $(tail -n 5 out)"
grep -m 1 -o '^mt_[^ ]*' out >deployment/token || fail "no token is printed: $(cat out)"
cd deployment
serve=$(grep -- '--tls-cert' ../commands)
start guarded $serve
guarded=$(url_of guarded tls | sed 's/127\.0\.0\.1/localhost/')
guarded_page=$(url_of guarded https | sed 's/127\.0\.0\.1/localhost/')
list=$(grep '^multitetra-client list' ../commands | sed "s|tls://volumes.example.org|$guarded --ca tls.pem|")
$list >out 2>&1 || fail "server/operations/DEPLOYMENT.md: $list ($(cat out))"
grep -q head out || fail "$list does not list the dataset: $(cat out)"
fetch=$(grep '^curl' ../commands | sed "s|mt_\.\.\.|$(cat token)|; s|https://volumes.example.org:7480/|${guarded_page%/}/|")
bash -c "$fetch -sf --cacert tls.pem" >out 2>&1 || fail "server/operations/DEPLOYMENT.md: $fetch ($(cat out))"
grep -q '"head"' out || fail "the list over HTTPS has no dataset: $(cat out)"
start configured $(grep -- '--config server.toml' ../commands)
url_of configured http >/dev/null || fail "server.toml does not start a server: $(cat configured.log)"
cd ..

# The addresses for other viewers: of an entry file, or of a folder that contains "info".
grep -o 'http://127.0.0.1:7480/v1/\(3dtiles\|neuroglancer\)/[^ `]*' "$root/client/paraview/README.md" | sed 's|");||' | sort -u >addresses
[ -s addresses ] || fail "client/paraview/README.md has no addresses"
python3 - "$page" <<'EOT' || fail "client/paraview/README.md has an address that does not answer"
import json, sys, urllib.request

for line in open("addresses"):
    address = line.strip().replace("http://127.0.0.1:7480/", sys.argv[1].rstrip("/") + "/")
    json.load(urllib.request.urlopen(address if address.endswith(".json") else address + "/info"))
EOT

# Every option of a command in a guide is in that command's help.
for guide in README.md client/FETCHING.md server/volume/FORMATS.md server/operations/DEPLOYMENT.md client/paraview/README.md \
  client/web/PAGES.md docker/parts/README.md docker/serving/README.md; do
  sed -e ':join' -e '/\\$/{N;s/\\\n//;b join' -e '}' "$root/$guide" | grep -o '^ *multitetra-[a-z]* .*' |
    sed 's/ # .*//; s/  *#.*//' | while read -r program rest; do
    command=${rest%% *}
    [ "$program" = multitetra-load ] || [ "$program" = multitetra-gateway ] || help=$("$program" "$command" --help-all 2>&1) || true
    case "$program" in multitetra-load | multitetra-gateway) help=$("$program" --help-all 2>&1) || true ;; esac
    for option in $(grep -oE ' --[a-z][a-z-]+' <<<"$rest"); do
      grep -qE -- "(^|[ ,])$option\b" <<<"$help" || echo "$guide: $program $command has no option $option"
    done
  done
done >unknown_options
[ ! -s unknown_options ] || fail "$(cat unknown_options)"
