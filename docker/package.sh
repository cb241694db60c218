#!/usr/bin/env bash
# Builds a package of the programs, the viewer and the demo volume, from a clone of the repository.
#
#   bash docker/package.sh deb      a Debian package in build/packages/
#   bash docker/package.sh tar      an archive for every Linux with this machine's C library or a later one, in build/packages/
#   bash docker/package.sh wheel    the same for Python, with `multitetra view` as a command, in build/packages/
#   bash docker/package.sh image    a container image named multitetra (docker, podman or buildah)
#   --yes                           installs missing packages without asking
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
usage() { sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
kind=
sections=()
install_options=()
for argument in "$@"; do
  case "$argument" in
    deb | tar | wheel | image) kind=$argument ;;
    --yes) install_options=(--yes) ;;
    -h | --help) usage; exit 0 ;;
    *) echo "Unknown argument $argument." >&2; usage >&2; exit 2 ;;
  esac
done
[ -n "$kind" ] || { usage >&2; exit 2; }
cd "$project"

build() {
  bash docker/install.sh "${install_options[@]}" build package "${sections[@]}"
  cmake --preset release
  cmake --build --preset release --target multitetra_server_program multitetra_viewer "$@"
  mkdir -p build/packages
}

case "$kind" in
  deb)
    build multitetra_client_program multitetra_gateway_program multitetra_load_program
    (cd build/release && cpack -G DEB -B "$project/build/packages")
    rm -rf build/packages/_CPack_Packages
    ls build/packages/*.deb
    ;;
  tar)
    build multitetra_client_program multitetra_gateway_program multitetra_load_program
    stage=$(mktemp -d)
    trap 'rm -rf "$stage"' EXIT
    cmake --install build/release --prefix "$stage/multitetra" --strip >/dev/null
    python3 docker/contents.py bundle "$project" "$stage/multitetra"
    version=$(sed -n 's/^project(multitetra VERSION \([^ ]*\).*/\1/p' CMakeLists.txt)
    archive=build/packages/multitetra-$version-linux-$(uname -m).tar.xz
    tar --sort=name --owner=0 --group=0 --numeric-owner --mtime=@0 -C "$stage" -cJf "$archive" multitetra
    ls "$archive"
    ;;
  wheel)
    sections=(python)
    build multitetra_python
    python3 client/python/wheel.py build/release build/packages
    ;;
  image)
    for builder in docker podman buildah; do
      command -v "$builder" >/dev/null || continue
      exec "$builder" build -f docker/Dockerfile -t multitetra .
    done
    echo "Neither docker nor podman nor buildah is here; install one of them." >&2
    exit 1
    ;;
esac
