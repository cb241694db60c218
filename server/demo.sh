#!/usr/bin/env bash
# The main job from one end to the other: builds, takes a volume (or makes one), prepares it, serves it on this machine,
# fetches an isosurface progressively, checks it, and says where to look next.
#
#   bash server/demo.sh                      a generated head
#   bash server/demo.sh CThead.nhdr          a volume of yours
#   bash server/demo.sh --serve [VOLUME]     stays up until Ctrl-C
#   --yes                                    installs missing packages without asking
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
usage() { sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }

serve=false
install_options=()
volume=
for argument in "$@"; do
  case "$argument" in
    --serve) serve=true ;;
    --yes) install_options=(--yes) ;;
    -h | --help) usage; exit 0 ;;
    -*) echo "Unknown option $argument." >&2; usage >&2; exit 2 ;;
    *) volume=$(realpath -s "$argument") ;;
  esac
done
cd "$project"

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
server=build/release/bin/multitetra-server
client=build/release/bin/multitetra-client
out=build/demo
mkdir -p "$out"

surface=() # Else the dataset's first suggestion.
look=()
if [ -z "$volume" ]; then
  surface=(--isovalue 71.5)
  look=(--clip y) # Cut open: most of it is inside.
  echo "== Making a volume: a head phantom with noise, 128 samples a side"
  volume=$out/head.nrrd
  "$server" generate head --size 128 --noise 20 -o "$volume"
fi

echo "== Preparing it"
"$server" prepare "$volume" -o "$out/demo.mtd"

echo "== Serving it"
log=$out/server.log
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
page=$("$client" view --http "$page_url" "${surface[@]}" --error 0.25 "${look[@]}")
echo "   $url"
echo "   $page in a browser (while this runs)"

echo "== Fetching an isosurface: coarse first, refined, checked"
"$client" fetch --server "$url" "${surface[@]}" --error 0.25 -o "$out/demo.ply" --report "$out/report.json" \
  --save-steps "$out/steps"

echo "== A picture of it, and a plot of all isovalues (half a minute)"
"$client" snapshot --server "$url" "${surface[@]}" --error 0.25 -o "$out/demo.png"
"$server" plot "$out/demo.mtd" -o "$out/demo.svg" --isovalues 32 --errors 0.5,1,2 --quiet

echo "== Where to look next"
cat <<EOF
   The mesh            $out/demo.ply (ParaView, MeshLab, Blender); its previews: $out/steps/
   A picture           $out/demo.png; all isovalues, and how large their surfaces are: $out/demo.svg
   What was checked    $out/report.json
   A volume of yours   bash server/demo.sh FILE.nrrd       (or NIfTI, DICOM, OME-Zarr, VTK, HDF5 ...: multitetra-server formats)
   Other isovalues     $server info $out/demo.mtd
                       $server extract $out/demo.mtd --isovalue V --error 0.5 -o mesh.glb
   Every command       $server --help, $client --help
EOF
if [ "$serve" = true ]; then
  echo "   Serving until Ctrl-C. Look at it, turn it, drag its isovalue:"
  echo "                       $page"
  echo "   or in another terminal:"
  echo "                       $client fetch --server $url --isovalue V -o mesh.ply"
  trap 'kill "$pid" 2>/dev/null || true' INT TERM
  wait "$pid" || true
fi
