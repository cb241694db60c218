#!/usr/bin/env bash
# Installs the Debian packages of docker/packages.txt that are missing, and says which. Asks nothing when run as root or
# with --yes; otherwise it asks once and uses sudo.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
say_yes=false
[ "${1:-}" = "--yes" ] && say_yes=true

is_installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

missing=()
while read -r package _; do
  case "$package" in '' | '#'*) continue ;; esac
  is_installed "$package" || missing+=("$package")
done <"$here/packages.txt"
[ ${#missing[@]} -eq 0 ] && exit 0

echo "Missing packages (of docker/packages.txt): ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "Run this as root, or install them yourself: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  if [ "$say_yes" = false ]; then
    read -r -p "Install them with sudo apt-get? [y/N] " answer || answer=n
    case "$answer" in [yY]*) ;; *) exit 1 ;; esac
  fi
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
trap 'rm -f "$log"' EXIT
echo "Installing them; this takes a minute or two."
if ! { "${as_root[@]}" apt-get update && "${as_root[@]}" apt-get install -y --no-install-recommends "${missing[@]}"; } \
  >"$log" 2>&1; then
  tail -n 20 "$log" >&2
  echo "apt-get failed; the lines above say why. These scripts know Debian 12 and its relatives." >&2
  exit 1
fi
