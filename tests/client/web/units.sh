#!/usr/bin/env bash
# The types of the viewer, and its pure parts, under node. Exit code 77: nothing was tested, and a loud line says why.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../../client/web"
if [ ! -x node_modules/.bin/vitest ] || [ ! -d src/protocol/generated ]; then
  echo "!! The viewer was not built (its packages are missing): its parts are NOT TESTED."
  exit 77
fi
node_modules/.bin/tsc --noEmit
node_modules/.bin/vitest run
