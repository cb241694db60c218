#!/usr/bin/env bash
# Generates src/protocol/generated, the messages in TypeScript. Requires protoc and `npm ci`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
mkdir -p src/protocol/generated
protoc -I ../../proto --plugin=protoc-gen-es=node_modules/.bin/protoc-gen-es --es_opt=target=ts \
  --es_out=src/protocol/generated ../../proto/multitetra/v1/*.proto
