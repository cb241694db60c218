#!/usr/bin/env bash
# Checks the viewer's types and runs its unit tests in Node. Exit code 77 with a warning: nothing was tested.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../../client/web"
if [ ! -x node_modules/.bin/vitest ] || [ ! -d src/protocol/generated ]; then
  echo "!! The viewer was not built (its packages are missing): its parts are NOT TESTED."
  exit 77
fi
node_modules/.bin/tsc --noEmit
node_modules/.bin/vitest run
