#!/usr/bin/env bash
# Tries the project on a suite of Debian in bare chroots: both commands of the README and all packages in one, the packages
# again in others where nothing is installed. Needs root, debootstrap and some minutes. Prints a line for each step.
#
#   bash docker/try.sh SUITE                   bookworm, trixie, sid ...; of the commit at HEAD
#   --packages FOLDER                          builds nothing: tries the archive in FOLDER on the suite
#   --skip-tests                               without tests/run.sh
#   --roots FOLDER                             keeps the bare chroots there, and takes those that are there
#   --mirror ADDRESS                           default: http://deb.debian.org/debian
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
usage() { sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
suite=
packages=
roots=
mirror=http://deb.debian.org/debian
with_tests=true
while [ $# -gt 0 ]; do
  case "$1" in
    --packages) packages=$(realpath "${2:?--packages needs a folder}"); shift ;;
    --roots) roots=$(realpath -m "${2:?--roots needs a folder}"); shift ;;
    --mirror) mirror=${2:?--mirror needs an address}; shift ;;
    --skip-tests) with_tests=false ;;
    -h | --help) usage; exit 0 ;;
    -*) echo "Unknown option $1; see --help." >&2; exit 2 ;;
    *) suite=$1 ;;
  esac
  shift
done
[ -n "$suite" ] || { usage >&2; exit 2; }
[ "$(id -u)" -eq 0 ] || { echo "chroots need root: run this with sudo." >&2; exit 2; }
command -v debootstrap >/dev/null || { echo "debootstrap is missing: apt-get install debootstrap" >&2; exit 2; }

work=$(mktemp -d "${TMPDIR:-/var/tmp}/multitetra-try.XXXXXX")
trap 'rm -rf --one-file-system "$work"' EXIT
logs=$project/build/try/$suite
mkdir -p "$logs"
failures=0

# bare NAME: a chroot where nothing is installed.
bare() {
  local root=${roots:-$work}/$suite
  [ -e "$root/etc/debian_version" ] || debootstrap --variant=minbase "$suite" "$root" "$mirror" >"$logs/debootstrap.log" 2>&1
  cp -a "$root" "$work/$1"
  cp /etc/resolv.conf "$work/$1/etc/resolv.conf"
  # Mirrors and snapshots may lag behind a suite that changes every day.
  echo 'Acquire::Check-Valid-Until "false";' >"$work/$1/etc/apt/apt.conf.d/90lagging-mirrors"
  # Authorities that this machine's network needs.
  if [ -d /usr/local/share/ca-certificates ]; then cp -a /usr/local/share/ca-certificates "$work/$1/usr/local/share/"; fi
}
# inside NAME COMMAND: runs a command of the shell in a chroot, with /proc and /dev of its own.
inside() {
  unshare --mount --pid --fork --kill-child bash -c '
    mount -t proc proc "$1/proc" && mount --rbind /dev "$1/dev" &&
    exec chroot "$1" env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
      NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt bash -euo pipefail -c "$2"' \
    bash "$work/$1" "$2"
}
# step NAME CHROOT COMMAND: runs it, logs it, and prints its result.
step() {
  local began=$SECONDS code=0
  inside "$2" "$3" >"$logs/$1.log" 2>&1 || code=$?
  if [ "$code" -eq 0 ]; then
    echo "$suite  $1: passed, $((SECONDS - began)) s"
  else
    echo "$suite  $1: FAILED with exit code $code after $((SECONDS - began)) s; the end of $logs/$1.log:"
    tail -n 15 "$logs/$1.log" | sed 's/^/    /'
    failures=$((failures + 1))
  fi
}

# What a user does with installed programs: the demo volume to a certified mesh. $bin and $share say where they are.
use='
$bin/multitetra-server prepare $share/multitetra/demo/visible_female_head.nrrd -o /tmp/head.mtd
$bin/multitetra-server extract /tmp/head.mtd --isovalue -300.5 --error 0.5 -o /tmp/head.ply
$bin/multitetra-server certify /tmp/head.ply --volume $share/multitetra/demo/visible_female_head.nrrd --isovalue -300.5 --error 0.5
test -s $share/multitetra/viewer/index.html
test -s $share/doc/multitetra/sbom.cdx.json'
install='export DEBIAN_FRONTEND=noninteractive; apt-get update; apt-get install -y --no-install-recommends'

try_archive() {
  bare archive
  cp "$1"/multitetra-*-linux-*.tar.xz "$work/archive/tmp/" || failures=$((failures + 1))
  # tar alone does not unpack xz in a bare system.
  tar -C "$work/archive/opt" -xJf "$work"/archive/tmp/multitetra-*.tar.xz || failures=$((failures + 1))
  step archive archive "bin=/opt/multitetra/bin share=/opt/multitetra/share; $use"
}

if [ -n "$packages" ]; then
  try_archive "$packages"
  exit "$((failures > 0))"
fi

bare build
git clone -q "$project" "$work/build/src"
step demo build "cd /src; bash server/demo.sh --no-serve"
if [ "$with_tests" = true ]; then step tests build "cd /src; bash tests/run.sh"; fi
step plain-build build "cd /src; cmake -B /tmp/plain -DMULTITETRA_TESTS=OFF >/dev/null; cmake --build /tmp/plain -j \$(nproc); cmake --install /tmp/plain --prefix /tmp/prefix
  bin=/tmp/prefix/bin; \$bin/multitetra --version; test -s /tmp/prefix/share/multitetra/viewer/index.html"
for kind in deb tar wheel; do step "package-$kind" build "cd /src; bash docker/package.sh $kind"; done

built=$work/build/src/build/packages
bare deb
cp "$built"/*.deb "$work/deb/tmp/" || failures=$((failures + 1))
step deb deb "$install /tmp/*.deb; bin=/usr/bin share=/usr/share; $use"
try_archive "$built"
bare wheel
cp "$built"/*.whl "$work/wheel/tmp/" || failures=$((failures + 1))
step wheel wheel "$install python3-numpy python3-pip; pip install --break-system-packages --no-deps /tmp/*.whl 2>/dev/null || pip install --no-deps /tmp/*.whl
  multitetra --version; python3 -c 'import multitetra; print(multitetra.__version__)'"
exit "$((failures > 0))"
