#!/usr/bin/env bash
# What README says step by step, done: from a generated volume to meshes of all kinds, without a word to change.
# Usage: readme_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
readme=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/README.md
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

# The commands of the section: indented lines, but those about the PATH, the serving, and volumes that only readers have.
sed -n '/^or step by step:/,/^Browsers and scripts/p' "$readme" | sed -n 's/^    //p' |
  grep -v '^PATH=\|^bash \|serve head.mtd ' | sed '/^multitetra-server prepare /{/ head\.\(nrrd\|mtd\) /!d}' >commands
grep -q 'threshold-grid importance.nrrd' commands || fail "README has no such section any more: $(cat commands)"
# The script of an image stands after its first use there: people read on, a shell does not.
sed -n "/^python3 - <<'EOF'/,/^EOF/p" commands >first
sed "/^python3 - <<'EOF'/,/^EOF/d" commands >rest

export PATH=$bin:$PATH
sed -i 's/--size 128/--size 48/' rest      # Quick; what is said of places holds for all of the head.
sed -i 's/--color-by warmth/--color-by head/' rest
sed -i 's/box:40,60,20,90,110,70/box:4,6,2,30,40,40/; s/1920x1080/192x108/; s/--min-component 12/--min-component 2/' rest
bash first
sed -n '1,/verify head.mtd/p' rest >before
sed '1,/verify head.mtd/d' rest >after
bash -euo pipefail before >out 2>&1 || fail "README up to serving: $(tail -n 3 out)"
start server multitetra-server serve head.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0
MULTITETRA_SERVER=$(url_of server tcp)
export MULTITETRA_SERVER
bash -euo pipefail after >out 2>&1 || fail "README from serving on: $(tail -n 5 out)"
# How many components are left out is told wherever some are.
! grep -i 'notice' out | grep -v ' components, those with a diagonal of ' ||
  fail "README asks for what it does not mean: $(grep -i notice out)"
for file in head.ply head.glb head.vtu head.svg head.png; do [ -s "$file" ] || fail "README made no $file"; done

# The addresses for viewers: of a first file, or of a folder that has one named info.
grep -o 'http://127.0.0.1:7480/v1/\(3dtiles\|neuroglancer\)/[^ ]*' "$readme" >addresses
[ "$(wc -l <addresses)" = 3 ] || fail "README tells of other addresses: $(cat addresses)"
python3 - "$(url_of server http)" <<'EOF' || fail "an address of README is none"
import json, sys, urllib.request

for line in open("addresses"):
    address = line.strip().replace("http://127.0.0.1:7480", sys.argv[1])
    json.load(urllib.request.urlopen(address if address.endswith(".json") else address + "/info"))
EOF
