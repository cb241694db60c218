#!/usr/bin/env bash
# Stores of other projects that hold a dataset: it is verified, served and extracted by ranges; buckets are also listed
# and filled.
#   stores.sh FOLDER-OF-PROGRAMS [STORE...]     nginx s3rver radosgw
#
# nginx        a folder behind a web server
# s3rver       an S3 bucket in Node, from npm; it requires signatures, and accepts any
# radosgw      an S3 bucket with signatures in a Ceph cluster of one monitor and one in-memory OSD (as root)
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
project=$(cd "$here/../.." && pwd)
bin=$(cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- nginx s3rver radosgw
source "$project/tests/support/programs.sh"
tested=0
leave_out() { echo "!! LEFT OUT: $1: NOT TESTED (docker/install.sh tests bench)." >&2; }
unset "${!AWS_@}"

"$bin/multitetra-server" generate head --size 96 --noise 20 -o head.nrrd --quiet
"$bin/multitetra-server" prepare head.nrrd -o head.mtd --name head --quiet
mkdir volumes && cp head.mtd volumes/
"$bin/multitetra-server" extract head.mtd --isovalue 100.5 --error 1 -o extracted.ply --quiet
fetch() {  # fetch SERVER FILE: writes the surface and prints its digest.
  "$bin/multitetra-client" fetch --server "${1/http:/ws:}" --dataset head --isovalue 100.5 --error 1 --quiet \
    --report report.json -o "$2" && python3 -c 'import json; print(json.load(open("report.json"))["steps"][-1]["content_digest"])'
}
start file "$bin/multitetra-server" serve head.mtd --tcp off --http 127.0.0.1:0
digest=$(fetch "$(url_of file http)" file.ply)

# Checks the guarantees of a dataset, wherever it is stored.
check_store() {  # check_store STORE ADDRESS
  local server fetched
  "$bin/multitetra-server" verify "$2" --quiet || fail "$1: not verified"
  "$bin/multitetra-server" extract "$2" --isovalue 100.5 --error 1 -o "$1-extracted.ply" --quiet || fail "$1: not extracted"
  cmp -s "$1-extracted.ply" extracted.ply || fail "$1: another surface is extracted"
  start "$1-server" "$bin/multitetra-server" serve "$2" --tcp off --http 127.0.0.1:0 --cache-dir "$1-cache"
  server=$(url_of "$1-server" http)
  [ "$(fetch "$server" "$1.ply")" = "$digest" ] || fail "$1: another surface"
  fetched=$(curl -sf "$server/metrics" | sed -n 's/^multitetra_block_fetches_total //p')
  [ "${fetched%.*}" -gt 0 ] || fail "$1: nothing was fetched"
  echo "$1: verified, extracted, and served ($fetched blocks fetched)"
}

# Makes a bucket, prepares a dataset into it and lists it.
fill_bucket() {  # fill_bucket STORE: at the address in AWS_... variables.
  local put=(curl -sSf --aws-sigv4 aws:amz:us-east-1:s3 --user "$AWS_ACCESS_KEY_ID:$AWS_SECRET_ACCESS_KEY" -o out)
  digest_of() { echo "x-amz-content-sha256: $(sha256sum <"$1" | cut -d ' ' -f 1)"; }
  "${put[@]}" -H "$(digest_of /dev/null)" -X PUT "$AWS_ENDPOINT_URL/volumes" || fail "$1: no bucket"
  "$bin/multitetra-server" prepare head.nrrd -o s3://volumes/in/head.mtd --name head --quiet || fail "$1: not prepared into the bucket"
  "$bin/multitetra-server" prepare head.nrrd -o s3://volumes/in/head.mtd --name head --quiet || fail "$1: a dataset is not replaced"
  "$bin/multitetra-server" info s3://volumes/in/ | grep -q '"head" in s3://volumes/in/head.mtd' || fail "$1: not listed"
  "${put[@]}" -H "$(digest_of head.nrrd)" -T head.nrrd "$AWS_ENDPOINT_URL/volumes/other.mtd"
  ! "$bin/multitetra-server" prepare head.nrrd -o s3://volumes/other.mtd --quiet 2>out || fail "$1: what is no dataset is replaced"
}

serve_nginx() {
  command -v nginx >/dev/null || { leave_out nginx; return 1; }
  local port
  port=$(free_port)
  start_static_nginx nginx "$port" "$work/volumes"
  check_store nginx "http://127.0.0.1:$port/head.mtd"
}

serve_s3rver() {
  command -v npm >/dev/null || { leave_out s3rver; return 1; }
  local port folder=$bin/../counterparts/stores
  port=$(free_port)
  mkdir -p "$folder"
  echo '{"private": true, "dependencies": {"s3rver": "3.7.1"}}' >"$folder/package.json"
  (cd "$folder" && timeout 300 npm install --no-package-lock --no-audit --no-fund --ignore-scripts --loglevel=error) >npm.log 2>&1 ||
    { cat npm.log >&2; leave_out "s3rver, which could not be installed"; return 1; }
  start s3rver node "$folder/node_modules/s3rver/bin/s3rver.js" -d "$work/s3rver" -a 127.0.0.1 -p "$port" --no-vhost-buckets
  for _ in $(seq 200); do curl -s -o /dev/null "http://127.0.0.1:$port/" && break; sleep 0.05; done
  export AWS_ENDPOINT_URL=http://127.0.0.1:$port AWS_ACCESS_KEY_ID=S3RVER AWS_SECRET_ACCESS_KEY=S3RVER AWS_REGION=us-east-1
  fill_bucket s3rver
  check_store s3rver s3://volumes/in/head.mtd
  unset "${!AWS_@}"
}

# Starts a minimal cluster that keeps everything in memory.
start_ceph() {  # start_ceph PORT
  local id
  mkdir -p ceph/mon ceph/osd
  cat >ceph/ceph.conf <<END
[global]
fsid = $(cat /proc/sys/kernel/random/uuid)
mon host = v1:127.0.0.1:$1
ms bind msgr2 = false
auth cluster required = none
auth service required = none
auth client required = none
osd pool default size = 1
osd pool default min size = 1
osd pool default pg num = 1
osd crush chooseleaf type = 0
mon allow pool size one = true
mon data avail crit = 1
osd objectstore = memstore
memstore device bytes = 256M
run dir = $work/ceph
admin socket = $work/ceph/\$name.asok
log file = $work/ceph/\$name.log
pid file = $work/ceph/\$name.pid
keyring = $work/ceph/keyring
[mon.a]
mon data = $work/ceph/mon
[osd.0]
osd data = $work/ceph/osd
END
  export CEPH_CONF=$work/ceph/ceph.conf
  id=$(sed -n 's/^fsid = //p' "$CEPH_CONF")
  ceph-authtool --create-keyring ceph/keyring --gen-key -n mon. --cap mon 'allow *'
  ceph-authtool ceph/keyring --gen-key -n client.admin --cap mon 'allow *' --cap osd 'allow *'
  monmaptool --create --fsid "$id" --addv a "[v1:127.0.0.1:$1]" ceph/monmap
  ceph-mon --mkfs -i a --monmap ceph/monmap --keyring ceph/keyring
  start ceph-mon ceph-mon -f -i a
  for _ in $(seq 60); do timeout 5 ceph -s && break; sleep 0.5; done
  id=$(cat /proc/sys/kernel/random/uuid)
  timeout 20 ceph osd new "$id" 0
  ceph-osd -i 0 --mkfs --osd-uuid "$id"
  start ceph-osd ceph-osd -f -i 0
  for _ in $(seq 60); do timeout 5 ceph osd stat | grep '1 up' && break; sleep 0.5; done
  timeout 60 radosgw-admin --name client.admin user create --uid tester --display-name tester --access-key ACCESS \
    --secret-key SECRET
}

serve_radosgw() {
  local program port
  for program in radosgw radosgw-admin ceph ceph-mon ceph-osd; do
    command -v "$program" >/dev/null || { leave_out radosgw; return 1; }
  done
  [ "$(id -u)" = 0 ] || { leave_out "radosgw, whose OSD wants to be root"; return 1; }
  start_ceph "$(free_port)" >ceph.txt 2>&1
  port=$(free_port)
  start radosgw radosgw -f --name client.admin --rgw-frontends "beast endpoint=127.0.0.1:$port"
  for _ in $(seq 300); do curl -s -o /dev/null "http://127.0.0.1:$port/" && break; sleep 0.1; done
  export AWS_ENDPOINT_URL=http://127.0.0.1:$port AWS_ACCESS_KEY_ID=ACCESS AWS_SECRET_ACCESS_KEY=SECRET AWS_REGION=us-east-1
  fill_bucket radosgw
  ! AWS_SECRET_ACCESS_KEY=wrong "$bin/multitetra-server" verify s3://volumes/in/head.mtd >out 2>&1 || fail "radosgw: accepts a wrong signature"
  grep -q '/volumes/in/head' out || fail "radosgw: what is said of a wrong signature: $(cat out)"
  echo "radosgw: with a wrong secret: $(cat out)"
  check_store radosgw s3://volumes/in/head.mtd
  unset "${!AWS_@}" CEPH_CONF
}

for store in "$@"; do
  echo "== $store"
  if "serve_$store"; then tested=$((tested + 1)); fi
done
[ "$tested" -gt 0 ] || exit 77
