#!/usr/bin/env bash
# docker/parts: preparation in parts by schedulers gives the same dataset as one process.
#   parts_test.sh FOLDER-OF-PROGRAMS
set -euo pipefail
bin=$(cd "$1" && pwd)
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"

export PATH=$work/path:$bin:$PATH
mkdir path volumes datasets
multitetra-server generate gyroid --size 40 -o volumes/gyroid.nrrd --quiet
multitetra-server prepare volumes/gyroid.nrrd -o whole.mtd --quiet

# A scheduler that runs each job immediately, and array jobs sequentially, as Slurm does without --cpus-per-task.
cat >path/sbatch <<'EOF'
#!/usr/bin/env bash
array=1-1
for option in "$@"; do [[ $option != --array=* ]] || array=${option#--array=}; done
script=$(cat)
for i in $(seq "${array%-*}" "${array#*-}"); do
  env -u SLURM_CPUS_PER_TASK SLURM_ARRAY_TASK_ID="$i" bash -c "$script" >>jobs.log 2>&1 || echo "job $i failed" >>failed.log
done
echo 1
EOF
chmod +x path/sbatch
bash "$project/docker/parts/slurm.sh" "$work/volumes/gyroid.nrrd" "$work/slurm.mtd" 3 --partition=cpu >/dev/null
[ ! -e failed.log ] || fail "slurm.sh: $(cat failed.log jobs.log)"
cmp -s slurm.mtd whole.mtd || fail "slurm.sh: another dataset than one process makes"

# The Snakefile finds single-file volumes of any format, and fails if there are none.
cp volumes/gyroid.nrrd volumes/other.nii.gz
mkdir empty
kinds="mgz mgh vtk cube ims pvti zip map ccp4 hdf5 mrc.gz dat hdr"
for kind in $kinds; do touch "volumes/of_$kind.$kind"; done
touch volumes/of_hdr.img volumes/notes.txt volumes/alone.img
mkdir volumes/slices
cat >found.py <<'EOF'
import sys
head = open(sys.argv[1]).read().split("\nrule all:")[0]
space = {"config": {"volumes": sys.argv[2], "out": "datasets"}}
exec(head, space)
print(*space["volumes"])
EOF
found=$(python3 found.py "$project/docker/parts/Snakefile" volumes 2>left_out.txt)
expected=$(printf '%s\n' gyroid other $(printf 'of_%s ' $kinds) | LC_ALL=C sort | tr '\n' ' ')
[ "$(tr ' ' '\n' <<<"$found" | LC_ALL=C sort | tr '\n' ' ')" = "$expected" ] || fail "Snakefile: it finds $found"
[ "$(cat left_out.txt)" = "Skipped in 'volumes': alone.img, notes.txt, slices" ] || fail "Snakefile: $(cat left_out.txt)"
for kind in $kinds; do rm "volumes/of_$kind.$kind"; done
rm -r volumes/of_hdr.img volumes/notes.txt volumes/alone.img volumes/slices
ends 1 "There is no volume in 'empty'" python3 found.py "$project/docker/parts/Snakefile" empty
cp volumes/gyroid.nrrd volumes/gyroid.mha
ends 1 "would both be 'gyroid.mtd'" python3 found.py "$project/docker/parts/Snakefile" volumes
rm volumes/gyroid.mha volumes/other.nii.gz

if command -v snakemake >/dev/null; then
  snakemake -s "$project/docker/parts/Snakefile" --cores 2 --quiet all --config volumes="$work/volumes" out="$work/datasets" \
    parts=2 >snakemake.log 2>&1 || fail "Snakefile: $(tail -n 20 snakemake.log)"
  cmp -s datasets/gyroid.mtd whole.mtd || fail "Snakefile: another dataset than one process makes"
fi
