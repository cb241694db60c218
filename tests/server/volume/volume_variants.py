"""Random choices for scripts that write many variants of each kind of file. Their second argument is the number of
variants, the third the seed."""
import random
import sys

import numpy

VARIANTS, SEED = int(sys.argv[2]), int(sys.argv[3])
INTEGERS = ("i1", "u1", "i2", "u2", "i4", "u4")
FLOATS = ("f2", "f4", "f8")


class Variant:
    """Random choices for one file."""

    def __init__(self, kind, number):
        self.name = f"{kind}-{number}"
        self.choose = random.Random(f"{SEED} {kind} {number}")
        self.numbers = numpy.random.default_rng([SEED, number, *kind.encode()])

    def one_of(self, *values):
        return self.choose.choice(values)

    def shape(self, least=2, most=9):
        return tuple(self.choose.randint(least, most) for _ in range(3))

    def samples(self, shape, dtype):
        """Integers that both the type and f32 represent exactly."""
        kind = numpy.dtype(dtype).kind
        low, high = (0, 250) if kind == "u" else (-120, 120)
        if numpy.dtype(dtype).itemsize > 1:
            low, high = 8 * low, 8 * high
        return self.numbers.integers(low, high, shape).astype(dtype)

    def size(self):
        return [self.one_of(0.25, 0.5, 0.75, 1, 1.5, 2, 4) for _ in range(3)]

    def origin(self):
        return [self.choose.randint(-40, 40) * 0.5 for _ in range(3)]

    def chunks(self, shape):
        return tuple(self.choose.randint(1, n + 1) for n in shape)

    def entry(self, count):
        return self.choose.randrange(count)


def variants(kind):
    return (Variant(kind, number) for number in range(VARIANTS))
