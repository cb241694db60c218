# Sourced by tests that run whole programs. Creates and enters a working folder, which is removed at the end of the
# test, when started programs are killed too. A test with a failure exits with 1, whatever its last command returns.
work=$(mktemp -d)
pids=()
failed=0
end_test() {
  local code=$? one
  for one in "${pids[@]}"; do kill "$one" 2>/dev/null || true; done
  wait
  rm -rf "$work"
  [ "$failed" = 0 ] || { echo "$failed failures." >&2; code=1; }
  exit "$code"
}
trap end_test EXIT
cd "$work"

fail() { echo "FAILED: $*" >&2; failed=$((failed + 1)); }

# ends CODE TEXT COMMAND...: checks the exit code and that TEXT is printed.
ends() {
  local code=$1 words=$2 status=0
  shift 2
  "$@" >out 2>&1 || status=$?
  [ "$status" = "$code" ] || fail "exit code $status instead of $code of: $* ($(cat out))"
  grep -qF -- "$words" out || fail "\"$words\" is not printed by: $* ($(cat out))"
}

# start NAME COMMAND...: sets `pid`; the output is in NAME.log.
start() {
  local log=$1.log
  shift
  : >"$log"  # Exists before it is read.
  "$@" >"$log" 2>&1 &
  pid=$!
  pids+=("$pid")
}
# url_of NAME SCHEME: waits for the address that the program listens on, and prints it.
url_of() {
  local url
  for _ in $(seq 600); do
    url=$(sed -n "s/.*listening on \($2:\/\/[^ \"]*\).*/\1/p" "$1.log" | head -n 1)
    [ -z "$url" ] || { echo "$url"; return; }
    sleep 0.05
  done
  cat "$1.log" >&2
  return 1
}
# ends_well NAME PID: sends SIGTERM and expects exit code 0.
ends_well() {
  local status=0
  kill -TERM "$2"
  wait "$2" || status=$?
  [ "$status" = 0 ] || fail "exit code $status after SIGTERM: $(cat "$1.log")"
}
# Prints a port that was free a moment ago, for programs that do not accept port 0.
free_port() {
  python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}

# start_static_nginx NAME PORT FOLDER: serves the files of a folder by nginx, and waits until it replies.
start_static_nginx() {
  mkdir -p "$1"
  cat >"$1.conf" <<END
events {}
http {
  access_log off;
  client_body_temp_path $1/body; proxy_temp_path $1/proxy;
  fastcgi_temp_path $1/fastcgi; uwsgi_temp_path $1/uwsgi; scgi_temp_path $1/scgi;
  server { listen 127.0.0.1:$2; root $3; }
}
END
  start "$1" nginx -p "$work" -c "$work/$1.conf" -g \
    "daemon off; pid $work/$1/pid; user $(id -un) $(id -gn); error_log $work/$1/errors.log;"
  for _ in $(seq 200); do curl -s -o /dev/null "http://127.0.0.1:$2/" && break; sleep 0.05; done
}
