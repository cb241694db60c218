#!/usr/bin/env bash
# Each section of docker/packages.txt can be installed on a Debian of which nothing is installed. Only resolved, as
# simulating takes three times as long; skipped (77) where apt has no package lists.
set -euo pipefail
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"
command -v apt-get >/dev/null && apt-cache show libdraco-dev >/dev/null 2>&1 || exit 77

: >status
for section in $(sed -n 's/^\[\(.*\)\]$/\1/p' "$project/docker/packages.txt"); do
  mapfile -t packages < <(bash "$project/docker/install.sh" --list "$section")
  apt-get --print-uris -o Debug::NoLocking=1 -o Dir::State::status="$work/status" -y install --no-install-recommends \
    "${packages[@]}" >out 2>&1 ||
    fail "section [$section] cannot be installed: $(grep '^E:\|Depends:\|Conflicts:' out | head -n 5)"
done
