#!/usr/bin/env bash
# Options of `multitetra-gateway` from flags, environment and file, its errors, and stopping by signal.
#   gateway_options_test.sh FOLDER-OF-PROGRAMS
set -euo pipefail
gateway=$(realpath "$1")/multitetra-gateway
compose=$(realpath "$(dirname "$0")/../../docker/compose.yaml")
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

cat >gateway.toml <<'TOML'
upstream = ["tcp://127.0.0.1:1", "tls://localhost:2"]
max-connections = 11
max-regions = 12
max-queries = 13
TOML
MULTITETRA_MAX_REGIONS=22 MULTITETRA_MAX_QUERIES=23 MULTITETRA_TRUSTED_PROXY=192.0.2.1,192.0.2.2 \
  "$gateway" --config gateway.toml --max-queries 33 --print-config >config
for line in max-connections=11 max-regions=22 max-queries=33 'upstream=\["tcp://127.0.0.1:1", "tls://localhost:2"\]' \
  'trusted-proxy=\["192.0.2.1", "192.0.2.2"\]'; do
  grep -qx "$line" config || fail "$line is not in: $(cat config)"
done
"$gateway" --config config --print-config >again
cmp config again || fail "--print-config does not read what it prints"
MULTITETRA_UPSTREAM=tcp://a:1,tcp://b:2 "$gateway" --print-config | grep -q 'upstream=\["tcp://a:1", "tcp://b:2"\]' ||
  fail "a list in the environment is not taken"

# docker/compose.yaml: every variable of a service is an option of its program, and what services refer to exists.
python3 - "$compose" >services <<'EOPY' || fail "compose.yaml: $(cat services)"
import sys
try:
    import yaml
except ImportError:
    print("missing")
    sys.exit()
compose = yaml.safe_load(open(sys.argv[1]))
for name, service in compose["services"].items():
    networks = service["networks"]
    assert set(networks) <= set(compose["networks"]), name
    assert set(service.get("depends_on", [])) <= set(compose["services"]), name
    if service["image"] == "multitetra":
        command = " ".join(service.get("entrypoint", ["multitetra-server", "serve"]))
        print(command, *(f"{key}={value}" for key, value in service["environment"].items()), sep="\t")
addresses = [n["inside"]["ipv4_address"] for n in (s["networks"] for s in compose["services"].values()) if isinstance(n, dict)]
assert len(set(addresses)) == len(addresses), addresses
EOPY
if grep -qx missing services; then
  echo "!! python3-yaml is not installed: docker/compose.yaml is NOT TESTED." >&2
else
  [ "$(cut -f1 services | tr '\n' ' ')" = "multitetra-server serve multitetra-gateway " ] || fail "other programs: $(cat services)"
fi
while IFS=$'\t' read -r command variables; do
  [ "$command" != missing ] || continue
  IFS=$'\t' read -ra variables <<<"$variables"
  # shellcheck disable=SC2086
  env MULTITETRA_DATASETS=/data "${variables[@]}" "$(dirname "$gateway")"/$command --print-config >printed ||
    fail "compose.yaml: $command refuses ${variables[*]}"
  for variable in "${variables[@]}"; do
    key=${variable%%=*} key=${key#MULTITETRA_} key=${key,,} key=${key//_/-}
    grep -q "^$key=" printed || fail "compose.yaml: $command has no option $key"
  done
done <services

echo 'max-conections = 1' >typo.toml
ends 2 'no option "max-conections"' "$gateway" --upstream tcp://127.0.0.1:1 --config typo.toml
ends 2 '--upstream' "$gateway"
ends 2 'tls://HOST:PORT' "$gateway" --upstream wss://127.0.0.1:1
ends 2 'give both: a certificate and its key' "$gateway" --upstream tcp://127.0.0.1:1 --tls-cert listener.pem
ends 2 'both are off' "$gateway" --upstream tcp://127.0.0.1:1 --http off
ends 4 'nowhere.pem does not exist' "$gateway" --upstream tcp://127.0.0.1:1 --tls-cert nowhere.pem --tls-key nowhere.key
ends 4 'nowhere.pem' "$gateway" --upstream tls://127.0.0.1:1 --upstream-ca nowhere.pem --http 127.0.0.1:0
ends 4 'token file' "$gateway" --upstream tcp://127.0.0.1:1 --upstream-token-file nowhere --http 127.0.0.1:0

start gateway "$gateway" --upstream tcp://127.0.0.1:1 --http 127.0.0.1:0 --log-format json
url=$(url_of gateway http)
ends 7 'Cannot listen on' "$gateway" --upstream tcp://127.0.0.1:1 --http "${url#http://}"
kill -HUP "$pid"
ends_well gateway "$pid"
grep -q '"text":"stopped"' gateway.log || fail "$(cat gateway.log)"

# The log warns about an open gateway where that shows anything: of servers without tokens, or by the gateway's own.
server=$(dirname "$gateway")/multitetra-server
"$server" generate gyroid --size 9 -o v.nrrd --quiet
"$server" prepare v.nrrd -o v.mtd --quiet
"$server" token alice --append tokens >token
start plain "$server" serve v.mtd --tcp 127.0.0.1:0 --http off
start guarded "$server" serve v.mtd --tcp 127.0.0.1:0 --http off --tokens tokens
plain=$(url_of plain tcp) guarded=$(url_of guarded tcp)
warnings() { grep -c 'every client may see' "$1.log" || true; }
start open "$gateway" --upstream "$plain" --upstream "$guarded" --http 0.0.0.0:0
for _ in $(seq 100); do [ "$(grep -c 'upstream reachable' open.log)" = 2 ] && break; sleep 0.05; done
sleep 0.2
[ "$(warnings open)" = 1 ] || fail "not one warning about an open gateway: $(cat open.log)"
grep -q "every client may see.*$plain" open.log || fail "the server without tokens is not named: $(cat open.log)"
ends_well open "$pid"
start lent "$gateway" --upstream "$guarded" --upstream-token-file token --http 0.0.0.0:0
url_of lent http >/dev/null
[ "$(warnings lent)" = 1 ] || fail "no warning about a token for all: $(cat lent.log)"
start local "$gateway" --upstream "$plain" --http 127.0.0.1:0
for _ in $(seq 100); do grep -q 'upstream reachable' local.log && break; sleep 0.05; done
sleep 0.2
[ "$(warnings local)" = 0 ] || fail "a warning about a gateway for this machine: $(cat local.log)"
