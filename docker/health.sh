#!/usr/bin/env bash
# Checks whether a server on this machine is alive, with bash only: exits with 0 if GET /livez on its HTTP port returns
# 200, or 400, which a listener with TLS (which bash does not support) answers. The port is the first argument, else that
# of MULTITETRA_HTTP, else 7480.
set -euo pipefail
from=${MULTITETRA_HTTP:-}
port=${1:-${from##*:}}
exec 3<>"/dev/tcp/127.0.0.1/${port:-7480}"
printf 'GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' >&3
IFS= read -r -t 2 status <&3
[[ "$status" =~ ^HTTP/1.1\ (200|400)\  ]]
