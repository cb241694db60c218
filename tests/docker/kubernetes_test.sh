#!/usr/bin/env bash
# The containers in docker/kubernetes run known commands with known options. Skipped (77) without python3-yaml.
#   kubernetes_test.sh FOLDER-OF-PROGRAMS
set -euo pipefail
bin=$(cd "$1" && pwd)
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"
if ! python3 -c 'import yaml' 2>/dev/null; then
  echo "!! python3-yaml is not installed: docker/kubernetes is NOT TESTED." >&2
  exit 77
fi

# Prints each container's command line, which begins with the image's program unless the container has a command.
python3 - "$project"/docker/kubernetes/*.yaml >commands <<'EOPY'
import shlex, sys, yaml
for file in sys.argv[1:]:
    for document in yaml.safe_load_all(open(file)):
        for container in document["spec"].get("template", {}).get("spec", {}).get("containers", []):
            assert container["image"].split(":")[0] == "multitetra", container["image"]
            words = container.get("args", [])
            if container.get("command") == ["/bin/sh", "-c"]:
                (line,) = words
                words = line.removeprefix("exec multitetra-server ").split()
            else:
                assert "command" not in container, container
            print(shlex.join(words))
EOPY
[ "$(cut -d ' ' -f 1 commands | sort | uniq -c | tr -s ' \n' ' ')" = " 3 prepare 1 serve " ] || fail "other commands: $(cat commands)"
while IFS= read -r line; do
  eval "words=($line)"
  "$bin/multitetra-server" "${words[0]}" --help-all >help
  for word in "${words[@]}"; do
    case "$word" in
      --*) grep -q -- "^ *\(-[a-z],\)\?${word%%=*}\( \|,\|$\)" help || fail "${words[0]} has no option ${word%%=*}: $line" ;;
    esac
  done
  [ "${words[0]}" != serve ] || "$bin/multitetra-server" "${words[@]}" --print-config >config || fail "serve refuses $line"
done <commands
