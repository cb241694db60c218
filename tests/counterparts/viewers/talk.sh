# Tests with third-party viewers, sourced by ../run.sh. Viewers are installed from npm when first needed and stay beside
# the programs, as do the screenshots.

viewers_store=$bin/../counterparts
pictures=$viewers_store/pictures
pages_port=$(free_port)   # Servers allow pages at this port.

prepare_trees() {
  [ ! -e tree.mtd ] || return 0
  "$bin/multitetra-server" generate head --size 160 --noise 20 -o tree.nrrd --quiet
  "$bin/multitetra-server" prepare tree.nrrd -o tree.mtd --quiet
  python3 "$here/viewers/make_lump.py" lump.nrrd
  "$bin/multitetra-server" prepare lump.nrrd -o lump.mtd --quiet
}
tree_settings=557.5,error=1

# segment_of ISOVALUE: the number of its segment in neuroglancer.
segment_of() { python3 -c 'import struct, sys; print(struct.unpack("<Q", struct.pack("<d", float(sys.argv[1]) or -0.0))[0])' "$1"; }

# Installs and builds the viewers and sets the certificate that they accept; fails if that is impossible.
install_viewers() {
  command -v node >/dev/null && command -v npm >/dev/null || { leave_out "viewers from npm"; return 1; }
  mkdir -p "$viewers_store/viewers" "$pictures"
  cp -r "$here/viewers/." "$viewers_store/viewers"
  (
    cd "$viewers_store/viewers"
    if ! cmp -s package.json installed.json; then
      timeout 300 npm install --no-package-lock --no-audit --no-fund --ignore-scripts --loglevel=error || exit 1
      cp package.json installed.json
    fi
    npx vite build --logLevel warn
  ) >npm.log 2>&1 || { cat npm.log >&2; leave_out "viewers from npm, which could not be installed"; return 1; }
  # The only self-signed certificate that Node and Chromium accept.
  export NODE_EXTRA_CA_CERTS=$work/tls.pem PICTURES=$pictures PAGES_PORT=$pages_port
  CERTIFICATE_HASH=$(openssl x509 -in tls.pem -pubkey -noout | openssl pkey -pubin -outform der |
    openssl dgst -sha256 -binary | base64)
  export CERTIFICATE_HASH CHROMIUM=${CHROMIUM:-/usr/bin/chromium}
}
with_viewers() { (cd "$viewers_store/viewers" && node "$@"); }

talk_tiles() {
  install_viewers || return 1
  [ -x "$CHROMIUM" ] || { leave_out "3D Tiles in Chromium"; return 1; }
  with_viewers tiles.mjs "$token" "tree/iso/$tree_settings" "${https[@]}" || fail "3D Tiles"
  "$bin/multitetra-server" export tree.mtd --isovalue 557.5 --error 1 --format glb-lods --json -o lods >lods.json
  with_viewers levels.mjs "$work/lods/surface.glb" "$(python3 -c 'import json; print(json.load(open("lods.json"))["triangles"])')" ||
    fail "a GLB with levels"
  echo "Pictures are in $pictures."
}

talk_neuroglancer() {
  install_viewers || return 1
  local url open
  for url in "${https[@]}"; do
    open=$url/v1/token/$token
    with_viewers fragments.mjs "$open/neuroglancer/tree/surfaces,error=1" "$(segment_of 557.5)" \
      "$open/3dtiles/tree/iso/$tree_settings/tileset.json" || fail "neuroglancer's decoder: $url"
  done
  if command -v nginx >/dev/null; then
    talk_exported
  else
    leave_out "neuroglancer's reading of shards"
  fi
  [ -x "$CHROMIUM" ] || { leave_out "neuroglancer in Chromium"; return 0; }
  with_viewers slices.mjs "$token" "${https[@]}" || fail "neuroglancer in Chromium"
  echo "Pictures are in $pictures."
}

# The output of export, served by an ordinary web server.
talk_exported() {
  local port one
  port=$(free_port)
  for one in '' --sharded; do
    "$bin/multitetra-server" export tree.mtd --isovalue 557.5,600.5 --error 1 --format neuroglancer $one -o "site/mesh$one" --quiet
  done
  "$bin/multitetra-server" export tree.mtd --isovalue 557.5 --error 1 -o site/tiles --quiet
  start_static_nginx static "$port" "$work/site"
  for one in '' --sharded; do
    with_viewers fragments.mjs "http://127.0.0.1:$port/mesh$one" "$(segment_of 557.5)" \
      "http://127.0.0.1:$port/tiles/tileset.json" || fail "neuroglancer's decoder: export $one"
    with_viewers fragments.mjs "http://127.0.0.1:$port/mesh$one" "$(segment_of 600.5)" ||
      fail "neuroglancer's decoder: export $one: the second segment"
  done
}

talk_paraview() {
  command -v pvpython >/dev/null && command -v xvfb-run >/dev/null || { leave_out ParaView; return 1; }
  local package=$bin/../python url
  [ -e "$package/multitetra/__init__.py" ] || { leave_out "ParaView, whose package is not built (target multitetra_python)"; return 1; }
  mkdir -p "$pictures"
  for url in "${https[@]/https:/wss:}"; do
    SSL_CERT_FILE=$work/tls.pem PYTHONPATH=$package:$project/client/paraview/debian12 timeout 200 xvfb-run -a pvpython \
      "$here/viewers/open_in_paraview.py" "$project/client/paraview/multitetra_reader.py" "$url" "$work/token" tree 557.5 \
      "$pictures/paraview.png" >paraview.txt 2>&1 && grep -q 'TRIANGLES [1-9]' paraview.txt || fail "ParaView: $url: $(cat paraview.txt)"
  done
  echo "Pictures are in $pictures."
}
