#!/usr/bin/env bash
# Builds the browser viewer into a folder served by the server's HTTP port.
#
#   bash client/web/build.sh OUTPUT_FOLDER
#
# Requires node (18 or later), npm and protoc. Installs packages once per package-lock.json, from
# the network or a warm npm cache; does nothing if no source has changed.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
output=${1:?name the output folder}
mkdir -p "$output"
output=$(cd "$output" && pwd)
cd "$here"

# Presets share node_modules, so builds must not overlap.
mkdir -p node_modules
exec 9>node_modules/.multitetra_lock
flock 9

sources=$(find . ../../proto/multitetra ../../common/codec/wasm -path ./node_modules -prune -o -path ./src/protocol/generated -prune -o \
  -type f -print0 | sort -z | xargs -0 sha256sum | sha256sum)
if [ -f "$output/index.html" ] && [ "$(cat "$output.sources" 2>/dev/null)" = "$sources" ]; then
  exit 0
fi

lock=$(sha256sum package-lock.json)
if [ "$(cat node_modules/.multitetra_packages 2>/dev/null)" != "$lock" ]; then
  npm ci --no-audit --no-fund --loglevel=error
  echo "$lock" >node_modules/.multitetra_packages
fi
bash generate.sh
MULTITETRA_VIEWER_OUT=$output node_modules/.bin/vite build --logLevel warn
MULTITETRA_WIDGET_OUT=$output/../widget node_modules/.bin/vite build --config vite.widget.config.ts --logLevel warn
echo "$sources" >"$output.sources"
echo "The browser viewer is in $output."
