#!/usr/bin/env bash
# Whether a server on this machine is alive, without a program beside bash: exit 0 if GET /livez on its HTTP door is
# answered with 200. The port is the first argument, 7480 without.
set -euo pipefail
exec 3<>"/dev/tcp/127.0.0.1/${1:-7480}"
printf 'GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' >&3
IFS= read -r -t 2 status <&3
[[ "$status" == "HTTP/1.1 200 "* ]]
