#!/usr/bin/env bash
# Checks format and common mistakes of the viewer's TypeScript by client/web/biome.jsonc; "format.sh --write" mends what
# it can. Exit code 77 with a warning: nothing was tested.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../../client/web"
if [ ! -x node_modules/.bin/biome ]; then
  echo "!! The viewer was not built (its packages are missing): its format is NOT TESTED."
  exit 77
fi
node_modules/.bin/biome check "$@" src ../../tests/client/web *.ts
