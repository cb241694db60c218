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

# Times are divided among the parts, without a plan; at the end what is missing is made.
python3 - <<'EOF'
import struct
header = bytearray(348)
struct.pack_into("<i8h", header, 0, 348, 0, 0, 0, 0, 0, 0, 0, 0)
struct.pack_into("<8h", header, 40, 4, 9, 8, 7, 5, 1, 1, 1)
struct.pack_into("<2h", header, 70, 2, 8)
struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 1, 0, 0, 0)
struct.pack_into("<f", header, 108, 352)
header[344:348] = b"n+1\0"
samples = bytes((7 * i + i // 504 * i % 31) % 256 for i in range(5 * 504))
open("times.nii", "wb").write(bytes(header) + bytes(4) + samples)
EOF
mkdir series
cp times.nii series/beat.nii
times=(multitetra-server prepare series/beat.nii --all-times --quiet -o)
"${times[@]}" at_once
for part in 1 3; do "${times[@]}" in_parts --part $part/3; done
[ "$(ls in_parts | wc -l)" = 3 ] || fail "two of three parts of five times make $(ls in_parts)"
"${times[@]}" in_parts
ends 2 "need no plan" "${times[@]}" in_parts --plan 3
ends 2 "is not a part" "${times[@]}" in_parts --part 4/3
PREPARE_OPTIONS=--all-times bash "$project/docker/parts/slurm.sh" "$work/series/beat.nii" "$work/of_slurm" 7 >/dev/null
[ ! -e failed.log ] || fail "slurm.sh: $(cat failed.log jobs.log)"
for folder in in_parts of_slurm; do diff -r at_once $folder >/dev/null || fail "$folder has other datasets than one process makes"; done

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
  snakemake -s "$project/docker/parts/Snakefile" --cores 2 --quiet all --config volumes="$work/series" out="$work/of_snakemake" \
    parts=2 series=--all-times >snakemake.log 2>&1 || fail "Snakefile: $(tail -n 20 snakemake.log)"
  diff -r at_once of_snakemake/beat >/dev/null || fail "Snakefile: other times than one process makes"
  cmp -s datasets/gyroid.mtd whole.mtd || fail "Snakefile: another dataset than one process makes"
fi
