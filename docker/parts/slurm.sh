#!/bin/bash
# Prepares a volume over the nodes of a Slurm cluster: a plan, an array of parts, a merge that waits for all of them.
#
#   bash slurm.sh VOLUME DATASET PARTS [options of sbatch]
#   bash slurm.sh /lustre/big.nrrd /lustre/big.mtd 64 --partition=cpu --cpus-per-task=8 --mem=2G
#
# Without --cpus-per-task a part has one processor. VOLUME and DATASET are paths that all nodes see. PREPARE_OPTIONS="--margin 1 --outside 0" sets how to read and prepare it. A part that fails or loses its node may run again at any time
# (sbatch --requeue does it); after that: multitetra-server prepare --merge -o DATASET.
set -euo pipefail
if [ $# -lt 3 ]; then
  echo "usage: slurm.sh VOLUME DATASET PARTS [options of sbatch]" >&2
  exit 2
fi
volume=$1
dataset=$2
parts=$3
shift 3

# submit NAME OPTION... -- COMMAND...: prints the job's number. The command's words reach the job as they are.
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
plan=$(submit plan "$@" -- "$volume" -o "$dataset" --plan "$parts")
more_options+=" --part \$SLURM_ARRAY_TASK_ID/$parts --threads \${SLURM_CPUS_PER_TASK:-1}"
array=$(submit part "$@" --array=1-"$parts" --dependency=afterok:"$plan" --kill-on-invalid-dep=yes -- "$volume" -o "$dataset")
more_options=""
merge=$(submit merge "$@" --dependency=afterok:"$array" --kill-on-invalid-dep=yes -- --merge -o "$dataset")
echo "plan $plan, parts $array, merge $merge"
