#!/usr/bin/env bash
# The life of tokens: names are unique, files are private, and revoked and expired tokens stop working, also on open
# connections. Usage: tokens_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
server=$bin/multitetra-server
client=$bin/multitetra-client
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

"$server" generate sphere --size 9 -o sphere.nrrd --quiet
"$server" prepare sphere.nrrd -o sphere.mtd --quiet
alice=$("$server" token alice --file tokens)
[ "$(stat -c %a tokens)" = 600 ] || fail "others can read a new file of tokens"
chmod 640 tokens
mkdir etc
if [ "$(id -u)" = 0 ]; then
  # Written by root for a service whose group owns the folder.
  chgrp nogroup etc
  "$server" token alice --file etc/tokens >/dev/null
  "$server" token bob --file etc/tokens >/dev/null
  [ "$(stat -c '%a %U %G' etc/tokens)" = "640 root nogroup" ] || fail "the service cannot read: $(ls -l etc/tokens)"
fi
bob=$("$server" token bob --datasets 'sp*' --append tokens)
[ "$(stat -c %a tokens)" = 640 ] || fail "the file's mode has changed"
ends 2 '"alice" already has a token in tokens' "$server" token alice --file tokens
[ "$(grep -c '^alice ' tokens)" = 1 ] || fail "two tokens of one name"
"$server" token list --file tokens >list
[ "$(cat list)" = "alice *
bob sp*" ] || fail "the list: $(cat list)"
"$server" token list --file tokens --json | grep -q '"expires": null' || fail "the list as JSON"

start server "$server" serve sphere.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 --tokens tokens
url=$(url_of server tcp)
accepts_token() { "$client" list --server "$url" --token "$1" >/dev/null 2>&1; }
reload_until() {
  kill -HUP "$pid"
  for _ in $(seq 200); do
    "$@" && return 0
    sleep 0.05
  done
  return 1
}
accepts_token "$alice" && accepts_token "$bob" || fail "a new token is not known"
"$server" token revoke alice --file tokens >/dev/null
accepts_token "$bob" || fail "another token was revoked"
rejects_alice() { ! accepts_token "$alice"; }
reload_until rejects_alice || fail "a revoked token still lets in"
new=$("$server" token bob --replace --file tokens)
reload_until accepts_token "$new" || fail "a replaced token is not known"
! accepts_token "$bob" || fail "what was replaced still lets in"
ends 1 'has no token named "alice"' "$server" token revoke alice --file tokens
ends 1 "nowhere" "$server" token revoke alice --file nowhere
ends 2 "--file" "$server" token list
ends 2 "revoke NAME" "$server" token revoke --file tokens
ends 2 "30d" "$server" token carol --expires soon --file tokens

# Concurrent appends write one line each.
for i in $(seq 20); do "$server" token "user$i" --file tokens >/dev/null & made+=("$!"); done
wait "${made[@]}"
[ "$(grep -c '^user' tokens)" = 20 ] || fail "of twenty tokens made at once $(grep -c '^user' tokens) are there"

# Each problem is one line of the log with token name and reason; clients get the reply for a mistyped name.
"$server" generate torus --size 9 -o torus.nrrd --quiet
"$server" prepare torus.nrrd -o torus.mtd --name torus --quiet
ends 2 'repeat --datasets for several' "$server" token several --datasets sphere,torus --file watched
seer=$("$server" token seer --datasets torus --file watched)
"$server" token typo --datasets 'nosuch*' --file watched >/dev/null
watching=$pid
start watched "$server" serve sphere.mtd torus.mtd --tcp 127.0.0.1:0 --http 127.0.0.1:0 --tokens watched \
  --max-requests-per-second 1
watched=$(url_of watched http)
status_of() { curl -s -o answer -w '%{http_code}' -H "Authorization: Bearer $1" "$watched$2"; }
lines() { grep -c -- "$1" watched.log || true; }
grep 'matches no dataset' watched.log | grep -q 'name=typo datasets=nosuch\*' || fail "no warning of a pattern: $(cat watched.log)"
[ "$(lines 'matches no dataset')" = 1 ] || fail "a warning of a pattern that has datasets: $(cat watched.log)"
[ "$(status_of "$seer" /v1/datasets/sphere)" = 404 ] || fail "a dataset of others is seen"
! grep -q 'not allowed' answer || fail "the answer says that there is such a dataset: $(cat answer)"
for _ in $(seq 40); do [ "$(status_of "$seer" /v1/datasets)" != 429 ] || break; done
[ "$(status_of "$seer" /v1/datasets/nowhere)" = 429 ] || fail "the rate has no limit: $(cat answer)"
kill -HUP "$pid"
sleep 1
[ "$(lines 'Dataset .*sphere.* is not allowed for this token')" = 1 ] || fail "a dataset of others: $(cat watched.log)"
[ "$(lines '/v1/datasets/sphere')" = 1 ] || fail "one rejection has several lines: $(cat watched.log)"
[ "$(lines '/v1/datasets/nowhere\|refused')" = 1 ] || fail "one rejection by rate has several lines: $(cat watched.log)"
grep '/v1/datasets/nowhere' watched.log | grep 'name=seer' | grep -q 'reason=' || fail "429 without name or reason: $(cat watched.log)"
grep 'tokens file reloaded' watched.log | grep -q 'tokens=2' || fail "no count of tokens: $(cat watched.log)"
ends_well watched "$pid"
pid=$watching

# A token expires without SIGHUP.
soon=$(date -u -d '+12 seconds' +%Y-%m-%dT%H:%M:%SZ)  # Long enough for a busy machine.
short=$("$server" token short --expires "$soon" --file tokens)
long=$("$server" token long --expires 12h --file tokens)
reload_until accepts_token "$long" || fail "a token that expires is not known"
accepts_token "$short" || fail "a token is not known before it expires"
while [ "$(date -u +%Y-%m-%dT%H:%M:%SZ)" \< "$soon" ]; do sleep 0.2; done
ends 1 "expired at $soon" "$client" list --server "$url" --token "$short"
curl -s -o answer -H "Authorization: Bearer $short" "$(url_of server http)/v1/datasets"
accepts_token "$long" || fail "a token expired too soon"
! grep -q short answer || fail "the answer names the token: $(cat answer)"
for line in 'error .*name=short.*expired at' 'http .*name=short.*status=401.*expired at'; do
  grep -q "$line" server.log || fail "an expired token is refused without its name: $(cat server.log)"
done
"$server" token list --file tokens | grep -q "^short \*  EXPIRED $soon" || fail "the list does not mark expired tokens"
ends_well server "$pid"
