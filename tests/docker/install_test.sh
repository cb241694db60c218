#!/usr/bin/env bash
# docker/install.sh installs the missing packages of a section and removes none, with a fake apt-get.
set -euo pipefail
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"

mkdir bin
cat >bin/dpkg-query <<END
#!/bin/sh
case "\$*" in
  *'\${Provides}'*) cat "$work/installed" ;;
  *) cut -d ' ' -f 1,2 "$work/installed" ;;
esac
END
printf '#!/bin/sh\necho "$*" >>"%s/calls"\n[ ! -e "%s/broken" ] || { echo "E: no such package" >&2; exit 100; }\n' "$work" "$work" >bin/apt-get
printf '#!/bin/sh\nexec "$@"\n' >bin/sudo
chmod +x bin/*
export PATH=$work/bin:$PATH
packages=$(bash "$project/docker/install.sh" --list build | tr '\n' ' ')
[ "$(wc -w <<<"$packages")" -gt 10 ] || fail "few packages: $packages"

# The first one is installed, the second one is provided by another, the third one was removed.
read -r first second third rest <<<"$packages"
printf 'installed %s \ninstalled another %s (= 1), more\nconfig-files %s \n' "$first" "$second" "$third" >installed
bash "$project/docker/install.sh" --yes build >out 2>&1 || fail "it ends with $?: $(cat out)"
printf 'update\ninstall -y --no-remove --no-install-recommends %s %s\n' "$third" "${rest% }" >expected
cmp calls expected || fail "apt-get was called with: $(cat calls)"

touch broken
ends 1 "E: no such package" bash "$project/docker/install.sh" --yes build

rm calls
for package in $packages; do echo "installed $package "; done >installed
bash "$project/docker/install.sh" build || fail "it ends with $? although everything is installed"
[ ! -e calls ] || fail "apt-get was called although everything is installed: $(cat calls)"
