#!/usr/bin/env bash
# --help of every command prints examples, then at most 15 common options, one line each; --help-all prints all options.
# Usage: help_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

# options_of PAGE: the names of the options in a help text.
options_of() { sed -nE 's/^  (-[^ ]+).*/\1/p' <<<"$1"; }

check() {
  local page all options count lines
  page=$("$bin/$1" ${2:+"$2"} --help)
  all=$("$bin/$1" ${2:+"$2"} --help-all)
  options=$(options_of "$page")
  count=$(wc -l <<<"$options")
  lines=$(sed -n '/^Options:/,/^$/p' <<<"$page" | sed '1d;/^$/d' | wc -l)
  [ "$count" -le 15 ] || fail "$* --help has $count options: $options"
  [ "$count" = "$lines" ] || fail "$* --help has $lines lines for $count options: $(sed -n '/^Options:/,/^$/p' <<<"$page" | grep -v '^  -')"
  [ -z "$(awk 'length > 100' <<<"$(sed -n '/^Options:/,/^$/p' <<<"$page")")" ] || fail "$* --help has a line of more than 100 characters"
  [ -z "$(awk '{ line = $0; if (gsub(/\(/, "", line) != gsub(/\)/, "", line)) print }' <<<"$(sed -n '/^Options:/,/^$/p' <<<"$page")")" ] || fail "$* --help cuts a text inside parentheses"
  awk '/^Examples:/ { seen = 1 } /^Options:/ && !seen { exit 1 }' <<<"$page" || fail "$* --help has no examples before its options"
  for option in $options; do
    options_of "$all" | grep -qx -- "$option" || fail "$* --help-all lacks $option"
  done
}

for program in multitetra-server multitetra-client; do
  for command in $("$bin/$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z-]*\) .*/\1/p'); do check "$program" "$command"; done
done
check multitetra-gateway
check multitetra-load
all=$("$bin/multitetra-client" fetch --help-all)
grep -qx 'Errors that differ from place to place:' <<<"$all" || fail "--help-all has no groups"

# Limits of serve are keys of its configuration, each with a comment.
"$bin/multitetra-server" serve --print-config >config
for key in max-connections idle-seconds cache-bytes; do
  grep -B 3 "^$key=" config | grep -q '^# ' || fail "--print-config has no comment for $key: $(cat config)"
done
