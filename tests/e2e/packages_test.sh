#!/usr/bin/env bash
# Each section of docker/packages.txt can be installed on a minimal Debian 12 without removing packages. Simulated only;
# skipped (77) where apt has no package lists.
set -euo pipefail
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"
command -v apt-get >/dev/null && apt-cache show libdraco-dev >/dev/null 2>&1 || exit 77

: >status
for section in $(sed -n 's/^\[\(.*\)\]$/\1/p' "$project/docker/packages.txt"); do
  mapfile -t packages < <(bash "$project/docker/install.sh" --list "$section")
  apt-get -s -y -o Dir::State::status="$work/status" install --no-remove --no-install-recommends "${packages[@]}" >out 2>&1 ||
    fail "section [$section] cannot be installed: $(grep '^E:\|Depends:\|Conflicts:' out | head -n 5)"
  ! grep -q '^Remv' out || fail "section [$section] removes packages: $(grep '^Remv' out)"
done
