#!/usr/bin/env bash
# Installs the missing Debian packages of docker/packages.txt and prints their names. Asks once and uses sudo,
# unless run as root or with --yes.
#
#   bash docker/install.sh [--yes] SECTION...    sections of packages.txt, for example: build tests
#   bash docker/install.sh --list SECTION...     only prints their packages
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
say_yes=false
only_list=false
sections=()
for argument in "$@"; do
  case "$argument" in
    --yes) say_yes=true ;;
    --list) only_list=true ;;
    -h | --help) sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *)
      grep -qx "\[$argument\]" "$here/packages.txt" || { echo "No section [$argument] in packages.txt." >&2; exit 2; }
      sections+=("$argument")
      ;;
  esac
done
[ ${#sections[@]} -gt 0 ] || { echo "Name a section of packages.txt; see --help." >&2; exit 2; }

packages=()
section=
while read -r word _; do
  case "$word" in
    '' | '#'*) ;;
    '['*) section=${word:1:-1} ;;
    *) [[ " ${sections[*]} " == *" $section "* ]] && packages+=("$word") ;;
  esac
done <"$here/packages.txt"
if [ "$only_list" = true ]; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi

# The names that installed packages provide: nodejs of another vendor also provides npm.
declare -A installed
while read -r status names; do
  [ "$status" = installed ] || continue
  for name in ${names//,/ }; do installed[$name]=yes; done
done < <(dpkg-query -W -f '${db:Status-Status} ${Package} ${Provides}\n')

missing=()
for package in "${packages[@]}"; do
  [ -n "${installed[$package]:-}" ] || missing+=("$package")
done
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
if ! { "${as_root[@]}" apt-get update && "${as_root[@]}" apt-get install -y --no-remove --no-install-recommends "${missing[@]}"; } \
  >"$log" 2>&1; then
  tail -n 20 "$log" >&2
  echo "apt-get failed; the lines above say why. These scripts know Debian 12 and 13 and Ubuntu 24.04." >&2
  exit 1
fi
