# shellcheck shell=bash disable=SC2034
# Sourced by the measurements of whole volumes: parses options, builds the programs, and creates a folder that is
# removed at the end.
#
#   options=(--out --quick) out=build/quality packages=(build tests) targets=(quality_bench)
#   source "$(dirname "${BASH_SOURCE[0]}")/set_up.sh" "$@"
#
# `options` are those in addition to --programs, --yes and --help; the variables they set (out, runs) must have
# defaults. Sets project, public_data, quick, publish, programs, server, python, work, left_out and the functions below.
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
public_data=$project/../shared/data
quick=false
publish=false
programs=
install_options=()
while [ $# -gt 0 ]; do
  case " ${options[*]} --programs --yes -h --help " in
    *" $1 "*) ;;
    *) echo "Unknown option $1; see --help." >&2; exit 2 ;;
  esac
  case "$1" in
    --out) out=$(realpath -m "${2:?--out needs a folder}"); shift ;;
    --runs) runs=${2:?--runs needs a number}; shift ;;
    --quick) quick=true runs=1 ;;
    --publish) publish=true ;;
    --programs) programs=$(realpath "${2:?--programs needs a folder}"); shift ;;
    --yes) install_options=(--yes) ;;
    -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
  esac
  shift
done
cd "$project"
[ -z "${out:-}" ] || out=$(realpath -m "$out")

# Other software is searched for even if programs are given.
if [ -z "$programs" ] || [[ " ${packages[*]} " == *" bench "* ]]; then
  bash docker/install.sh "${install_options[@]}" "${packages[@]}"
fi
if [ -z "$programs" ]; then
  echo "== Building (preset bench)"
  cmake --preset bench >/dev/null
  cmake --build --preset bench --target multitetra_server_program "${targets[@]}"
  programs=$project/build/bench/bin
fi
server=$programs/multitetra-server
python=/usr/bin/python3  # Debian's Python, for its packages.

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

left_out=()
leave_out() { left_out+=("$1"); echo "!! LEFT OUT: $1"; }
say_left_out() { for what in "${left_out[@]}"; do echo "!! LEFT OUT: $what"; done; }

# public ACTION NAME FILE ...: runs ACTION NAME PATH ... for a file of ../shared/data, if it exists.
public() {
  local action=$1 name=$2 file=$3
  shift 3
  if [ -f "$public_data/$file" ]; then
    "$action" "$name" "$public_data/$file" "$@"
  else
    leave_out "$name: ../shared/data/$file is not there"
  fi
}
# generated_head NAME SIZE: generates a head with SIZE samples per side in NAME.nrrd.
generated_head() { "$server" generate head --size "$2" --noise 20 -o "$work/$1.nrrd" --quiet; }
