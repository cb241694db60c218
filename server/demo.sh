#!/usr/bin/env bash
# The main job from one end to the other: builds, prepares a volume, serves it on this machine, fetches an isosurface
# progressively, checks it, and shows it in a browser. On a terminal it serves until Ctrl-C; otherwise it ends.
#
#   bash server/demo.sh                      a CT of a head (server/volume/demo)
#   bash server/demo.sh CThead.nhdr          a volume of yours
#   --serve, --no-serve                      serves until Ctrl-C, or ends, wherever it runs
#   --programs FOLDER                        builds nothing: runs the programs there
#   --output FOLDER                          writes there (default: build/demo)
#   --yes                                    installs missing packages without asking
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
usage() { sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }

serve=false
[ -t 1 ] && serve=true
install_options=()
volume=
programs=
out=build/demo
while [ $# -gt 0 ]; do
  case "$1" in
    --serve) serve=true ;;
    --no-serve) serve=false ;;
    --programs | --output)
      [ $# -gt 1 ] || { echo "$1 needs a folder." >&2; exit 2; }
      if [ "$1" = --programs ]; then programs=$(realpath -s "$2"); else out=$(realpath -s "$2"); fi
      shift
      ;;
    --yes) install_options=(--yes) ;;
    -h | --help) usage; exit 0 ;;
    -*) echo "Unknown option $1." >&2; usage >&2; exit 2 ;;
    *) volume=$(realpath -s "$1") ;;
  esac
  shift
done
cd "$project"

if [ -z "$programs" ]; then
  programs=build/release/bin
  bash docker/install.sh "${install_options[@]}" build
  echo "== Building (the first time takes some minutes)"
  build_log=$(mktemp)
  if ! { cmake --preset release && cmake --build --preset release --target multitetra_server_program \
    multitetra_client_program multitetra_viewer; } >"$build_log" 2>&1; then
    tail -n 40 "$build_log" >&2
    echo "The build failed; the whole log is $build_log." >&2
    exit 1
  fi
  rm -f "$build_log"
fi
server=$programs/multitetra-server
client=$programs/multitetra-client
mkdir -p "$out"

surface=() # Else the dataset's first suggestion.
picture=()
dataset=()
look=
if [ -z "$volume" ]; then
  volume=server/volume/demo/visible_female_head.nrrd
  surface=(--isovalue -300.5) # Skin.
  # Skin over bone, without dust.
  picture=(--isovalue -300.5,300.5 --surface-color '#e0ac8d,#f3ead6' --opacity 0.45,1 --min-component 20 --azimuth 40)
  dataset=(--dataset visible_female_head)
  look='&isovalue=-300.5&color=e0ac8d&opacity=0.45&min_component=20&surfaces=300.5,f3ead6,,,,,20&axes=false'
fi

echo "== Preparing $volume"
"$server" prepare "$volume" -o "$out/demo.mtd" --force

echo "== Serving it"
log=$out/server.log
: >"$log" # It is read before the server's shell has opened it.
"$server" serve "$out/demo.mtd" --tcp 127.0.0.1:0 --http 127.0.0.1:0 2>"$log" &
pid=$!
trap 'kill "$pid" 2>/dev/null || true; wait "$pid" 2>/dev/null || true' EXIT
url=
page_url=
for _ in $(seq 100); do
  url=$(sed -n 's/.*listening on \(tcp:[^ ]*\).*/\1/p' "$log")
  page_url=$(sed -n 's/.*listening on \(http:[^ ]*\).*/\1/p' "$log")
  [ -n "$url" ] && [ -n "$page_url" ] && break
  kill -0 "$pid" 2>/dev/null || { cat "$log" >&2; exit 1; }
  sleep 0.1
done
[ -n "$url" ] && [ -n "$page_url" ] || { cat "$log" >&2; echo "The server did not start to listen." >&2; exit 1; }
page=$("$client" view --http "$page_url" "${dataset[@]}")$look
echo "   $page in a browser, from now on"

echo "== Fetching an isosurface: coarse first, refined, checked"
"$client" fetch --server "$url" "${surface[@]}" --error 0.25 -o "$out/demo.ply" --report "$out/report.json" \
  --save-steps "$out/steps"

echo "== Certifying it against the volume: distance both ways, topology, defects"
isovalue=$(grep -o '"isovalue": *[^,}]*' "$out/report.json" | head -n 1 | sed 's/.*: *//')
"$server" certify "$out/demo.ply" --volume "$volume" --isovalue "$isovalue" --error 0.25 --json --quiet >"$out/certificate.json"
# The larger distance of both directions, and what the full surface has.
certified=$(awk '
  /"voxel": \{/ {in_voxels = 1} /"world": \{/ {in_voxels = 0}
  in_voxels && /"maximum_at_most"/ && $2 + 0 > most {most = $2 + 0}
  /"components"/ {components = $2 + 0}
  END {printf "within %.2g of 0.25 voxels (and 0.054 for vertices on a lattice), topology kept, %d components", most, components}
' "$out/certificate.json")

echo "== A picture, and a plot of all isovalues"
"$client" snapshot --server "$url" "${picture[@]}" --error 0.25 -o "$out/demo.png"
"$server" plot "$out/demo.mtd" -o "$out/demo.svg" --isovalues 16 --errors 1,2 --quiet

cat <<EOF
== What there is now
   The mesh            $out/demo.ply (ParaView, MeshLab, Blender); its previews: $out/steps/
   A picture           $out/demo.png; all isovalues, and how large their surfaces are: $out/demo.svg
   What was checked    $out/report.json, $out/certificate.json
   A volume of yours   $programs/multitetra view FILE     (NRRD, NIfTI, DICOM, OME-Zarr, VTK, HDF5 ...)
   Every command       $server --help, $client --help
EOF
if [ "$serve" = false ]; then
  echo "   In a browser        $programs/multitetra view $out/demo.mtd"
  echo "   Certified           $certified"
  exit 0
fi
echo "   Certified           $certified"
bold=
plain=
if [ -t 1 ] && [ -z "${NO_COLOR:-}" ]; then bold=$'\e[1m' plain=$'\e[0m'; fi
printf '\n   %s\n\n   Serving until Ctrl-C. Open this address in a browser.\n' "$bold$page$plain"
trap 'kill "$pid" 2>/dev/null || true' INT TERM
wait "$pid" || true
