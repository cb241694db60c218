"""Writes an off-center ellipsoid in a volume with three different spacings; its surface has value 0. Usage: make_lump.py FILE.nrrd"""
import array
import itertools
import math
import sys

SIZES, CENTER, RADII = (72, 80, 60), (30, 45, 33), (20.49, 12.49, 8.49)  # In samples.

squares = [[((i - c) / r) ** 2 for i in range(n)] for n, c, r in zip(SIZES, CENTER, RADII)]
values = array.array("f", (100 - 100 * math.sqrt(z + y + x) for z, y, x in itertools.product(*reversed(squares))))
with open(sys.argv[1], "wb") as file:
    file.write(
        b"NRRD0004\ntype: float\ndimension: 3\nsizes: %d %d %d\nencoding: raw\nendian: little\n" % SIZES
        + b"space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.75,0) (0,0,1.25)\n"
        b'space origin: (10,-20,30)\nspace units: "mm" "mm" "mm"\n\n'
    )
    values.tofile(file)
