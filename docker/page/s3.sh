#!/usr/bin/env bash
# Uploads the folder of `multitetra-server export --page` to a bucket that everybody may read: s3.sh FOLDER BUCKET.
# Other sites' viewers may read it, too. AWS_ENDPOINT_URL names another store than Amazon's.
set -euo pipefail
aws s3 sync "$1" "s3://$2"
aws s3api put-bucket-cors --bucket "$2" --cors-configuration '{"CORSRules": [{
  "AllowedOrigins": ["*"], "AllowedMethods": ["GET", "HEAD"], "AllowedHeaders": ["*"],
  "ExposeHeaders": ["ETag", "Content-Range"]}]}'
