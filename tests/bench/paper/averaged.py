"""Downsamples a NRRD file of int16 samples (raw or gzip, attached) to the means of blocks of N^3 samples: a part of paper.sh.

    averaged.py VOLUME.nrrd N OUTPUT.nrrd
"""
import gzip
import sys

import numpy


def main():
    source, n, output = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    with open(source, "rb") as file:
        header, payload = file.read().split(b"\n\n", 1)
    fields = dict(line.split(b": ", 1) for line in header.split(b"\n") if b": " in line and not line.startswith(b"#"))
    if fields[b"type"] != b"int16" or fields[b"endian"] != b"little":
        sys.exit(f"{source}: not int16, little endian")
    samples = gzip.decompress(payload) if fields[b"encoding"] == b"gzip" else payload
    sizes = [int(word) for word in fields[b"sizes"].split()][::-1]
    whole = [size // n for size in sizes]
    volume = numpy.frombuffer(samples, "<i2").reshape(sizes)[tuple(slice(n * size) for size in whole)]
    blocks = volume.reshape(whole[0], n, whole[1], n, whole[2], n)
    means = numpy.rint(blocks.mean(axis=(1, 3, 5))).astype("<i2")
    with open(output, "wb") as file:
        sizes = " ".join(str(size) for size in whole[::-1])
        file.write(f"NRRD0004\ntype: int16\ndimension: 3\nsizes: {sizes}\nendian: little\nencoding: raw\n\n".encode())
        file.write(means.tobytes())


if __name__ == "__main__":
    main()
