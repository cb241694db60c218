#!/bin/bash
# Prepares a volume on the nodes of a Slurm cluster: a plan, an array of parts, and a merge that waits for all parts.
#
#   bash slurm.sh VOLUME DATASET PARTS [options of sbatch]
#   bash slurm.sh /lustre/big.nrrd /lustre/big.mtd 64 --partition=cpu --cpus-per-task=8 --mem=2G
#   PREPARE_OPTIONS=--all-times bash slurm.sh /lustre/heart4d.nii.gz /lustre/heart 8
#
# If DATASET does not end in .mtd, it is a folder, or s3://bucket/folder, of several datasets: times, labels or fields, each
# made by one node. The last job then makes what is missing.
# Without --cpus-per-task each part has one processor. VOLUME and DATASET are paths visible to all nodes, or addresses.
# PREPARE_OPTIONS="--pad 1 --pad-value 0" sets options for reading and preparing. A part that fails or loses its node
# may be run again at any time (sbatch --requeue does so); then run multitetra-server prepare --merge -o DATASET,
# or for a folder the same prepare without --part.
set -euo pipefail
if [ $# -lt 3 ]; then
  echo "usage: slurm.sh VOLUME DATASET PARTS [options of sbatch]" >&2
  exit 2
fi
volume=$1
dataset=$2
parts=$3
shift 3

# submit NAME OPTION... -- COMMAND...: submits a job and prints its number. Passes the command's words unchanged.
submit() {
  local name=$1 options=()
  shift
  while [ "$1" != -- ]; do
    options+=("$1")
    shift
  done
  shift
  sbatch --parsable --requeue --job-name="multitetra-$name" "${options[@]}" <<EOF | cut -d';' -f1
#!/bin/bash
exec multitetra-server prepare ${*@Q}$more_options
EOF
}

more_options=" ${PREPARE_OPTIONS:-}"
plan=
plan_first=()
if [[ $dataset == *.mtd ]]; then
  plan=$(submit plan "$@" -- "$volume" -o "$dataset" --plan "$parts")
  plan_first=(--dependency=afterok:"$plan" --kill-on-invalid-dep=yes)
  merge=(--merge -o "$dataset")
  merge_options=
else
  merge=("$volume" -o "$dataset")
  merge_options=$more_options
fi
more_options+=" --part \$SLURM_ARRAY_TASK_ID/$parts --threads \${SLURM_CPUS_PER_TASK:-1}"
array=$(submit part "$@" --array=1-"$parts" "${plan_first[@]}" -- "$volume" -o "$dataset")
more_options=$merge_options
last=$(submit merge "$@" --dependency=afterok:"$array" --kill-on-invalid-dep=yes -- "${merge[@]}")
echo "${plan:+plan $plan, }parts $array, merge $last"
