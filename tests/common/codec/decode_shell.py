"""A decoder of sample shells written only from common/codec/README.md, to show that the page is complete.

    python3 decode_shell.py trained_tables.hpp FOLDER...     checks shell_*.bin of each against its shells.txt
"""
import itertools
import pathlib
import re
import struct
import sys

POWERS = (1073741824, 1170923762, 1276901417, 1392470869, 1518500250, 1655936265, 1805811301, 1969251188)
EIGHTHS = (0, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 5, 6, 6, 6, 6, 7, 7, 7, 7, 7, 8, 8, 8)
# For each edge number: its direction, and which coordinates must have the same parity.
EDGES = (((1, 0, 0), ()), ((0, 1, 0), ()), ((1, 1, 0), (0, 1)), ((-1, 1, 0), (0, 1)), ((0, 0, 1), ()),
         ((1, 0, 1), (0, 2)), ((-1, 0, 1), (0, 2)), ((0, 1, 1), (1, 2)), ((1, 1, 1), (0, 1, 2)),
         ((-1, 1, 1), (0, 1, 2)), ((0, -1, 1), (1, 2)), ((1, -1, 1), (0, 1, 2)), ((-1, -1, 1), (0, 1, 2)))
NEIGHBOURS = ((-1, 0, 0), (0, -1, 0), (0, 0, -1), (-1, -1, 0), (-1, 0, -1), (0, -1, -1), (-1, -1, -1))
FACTORS = (8, 8, 8, 3, 3, 3, 1)


def clamp(value, low, high):
    return max(low, min(high, value))


def half_octaves(v):
    if v < 2:
        return v
    log = v.bit_length() - 1
    return 2 * log + (v >> (log - 1) & 1)


class Tables:
    def __init__(self, path):
        text = pathlib.Path(path).read_text()
        self.of = {name: [int(n) for n in re.findall(r"-?\d+", body)]
                   for name, body in re.findall(r" (kTrained\w+)(?:\[\d+\])+ = \{(.*?)\};", text, re.S)}
        flat = self.of["kTrainedWeights"]
        self.weights = [flat[11 * mask:11 * mask + 11] for mask in range(128)]

    def cut(self, name, *sizes):
        """Splits a table of probabilities into parts of these sizes."""
        parts, at = [], 0
        for size in sizes:
            parts.append([[128 * b + 64] * 2 for b in self.of[name][at:at + size]])
            at += size
        assert at == len(self.of[name])
        return parts


class Bits:
    """Reads entropy-coded and raw bits."""

    def __init__(self, raw, coded):
        self.raw, self.raw_at = raw, 0
        self.coded, self.at = coded, 0
        self.range, self.code = 2**32 - 1, 0
        for _ in range(4):
            self.code = self.code << 8 | self.byte()

    def byte(self):
        self.at += 1
        return self.coded[self.at - 1] if self.at <= len(self.coded) else 0

    def bit(self, p):
        fast, slow = p
        bound = (self.range >> 15) * clamp((fast + slow) >> 1, 64, 2**15 - 64)
        if self.code < bound:
            self.range, one = bound, 1
            p[0], p[1] = fast + ((2**15 - fast) >> 4), slow + ((2**15 - slow) >> 7)
        else:
            self.code, self.range, one = self.code - bound, self.range - bound, 0
            p[0], p[1] = fast - (fast >> 4), slow - (slow >> 7)
        while self.range < 2**24:
            self.range, self.code = self.range << 8, (self.code << 8) + self.byte()
        return one

    def number(self, bits):
        value = 0
        for i in range(bits):
            value |= (self.raw[self.raw_at >> 3] >> (self.raw_at & 7) & 1) << i
            self.raw_at += 1
        return value

    def is_used_up(self):
        return len(self.coded) <= self.at <= len(self.coded) + 4 and (self.raw_at + 7) // 8 == len(self.raw)


class Header:
    def __init__(self, data):
        self.data, self.at = data, 4
        assert data[0] == 1, "Unknown version"
        self.values, self.levels_log2, self.has_void = data[1] & 3, data[1] >> 2 & 3, data[1] >> 4 & 1
        assert self.values < 3 and data[1] >> 5 == 0 and data[3] >> 6 == 0, "Unknown bits"
        assert self.values == 2 or self.levels_log2 == 0, "log2 L is of quantized shells only"
        if self.values == 1:
            self.levels_log2 = 3
        self.steps = 1 << ((data[2] & 15) + (data[2] >> 4))
        self.layer = [[data[3] >> (2 * a + h) & 1 for h in range(2)] for a in range(3)]
        self.origin = [self.varint() for _ in range(3)]
        self.size = [self.take(1)[0] + 2 for _ in range(3)]
        self.vertices, self.triangles = self.varint(), self.varint()
        self.layer_level, self.layer_is_positive = 0, False
        if self.values == 0:
            self.isovalue, = struct.unpack("<d", self.take(8))
            if data[3]:
                self.layer_value, = struct.unpack("<f", self.take(4))
                self.layer_is_positive = self.layer_value > self.isovalue
        else:
            self.first, self.levels, self.unit = self.signed(), self.varint(), self.signed()
            if data[3]:
                layer = self.varint()
                self.layer_level, self.layer_is_positive = layer >> 1, bool(layer & 1)
        raw = self.varint()
        self.bits = Bits(self.take(raw), data[self.at:])

    def take(self, count):
        self.at += count
        return self.data[self.at - count:self.at]

    def varint(self):
        value, shift = 0, 0
        while True:
            byte, = self.take(1)
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def signed(self):
        value = self.varint()
        return -(value + 1 >> 1) if value & 1 else value >> 1


def read_field(bits, mixed, ones, sample, size):
    nx, ny, nz = size
    kinds, field = {}, {}
    for k, j, i in itertools.product(*(range((n + 3) // 4) for n in (nz, ny, nx))):
        n, d, q = kinds.get((i, j - 1, k)), kinds.get((i, j, k - 1)), kinds.get((i, j - 1, k - 1), 3)
        w = kinds.get((i - 1, j, k))
        if w is None:
            w = n if n is not None else d if d is not None else 0
        n = w if n is None else n
        d = n if d is None else d
        context = ((3 * w + n) * 3 + d) * 4 + q
        kinds[i, j, k] = 2 if bits.bit(mixed[context]) else bits.bit(ones[context])

    zeros = [0] * nx
    rows = {}
    for z in range(nz):
        for y in range(ny):
            north, down = rows.get((y - 1, z)), rows.get((y, z - 1))
            north = down if north is None else north
            down = north if down is None else down
            north, down = north or zeros, down or zeros
            north2, down2 = rows.get((y - 2, z), north), rows.get((y, z - 2), down)
            down_north, down_south = rows.get((y - 1, z - 1), north), rows.get((y + 1, z - 1), down)
            row = rows[y, z] = [0] * nx
            for x in range(nx):
                kind = kinds[x // 4, y // 4, z // 4]
                if kind < 2:
                    row[x] = kind
                    continue
                left = [row[i] if i >= 0 else north[0] for i in (x - 2, x - 1)]
                lower, upper = max(x - 1, 0), min(x + 1, nx - 1)
                known = (*left, north[lower], north[x], north[upper], down[lower], down[x], down[upper],
                         north2[x], down2[x], down_north[x], down_south[x])
                row[x] = bits.bit(sample[sum(b << i for i, b in enumerate(known))])
    for (y, z), row in rows.items():
        for x, bit in enumerate(row):
            field[x, y, z] = bit
    return field


class Shell:
    def __init__(self, data, tables):
        h = self.header = Header(data)
        self.bits, self.tables = h.bits, tables
        low = [h.layer[a][0] for a in range(3)]
        data_size = [h.size[a] - sum(h.layer[a]) for a in range(3)]

        def field(around):
            inner = read_field(self.bits, *tables.cut("kTrainedSigns", 108, 108, 4096), data_size)
            return {p: inner.get(tuple(p[a] - low[a] for a in range(3)), around) for p in self.points()}

        self.present = field(1) if h.has_void else {p: 1 for p in self.points()}
        self.positive = field(int(h.layer_is_positive))
        self.is_data = {p: all(low[a] <= p[a] < low[a] + data_size[a] for a in range(3)) for p in self.points()}
        self.find_edges()
        self.read_slices()
        self.march()
        assert self.bits.is_used_up(), "Bytes are missing or left"

    def points(self):
        nx, ny, nz = self.header.size
        return ((x, y, z) for z in range(nz) for y in range(ny) for x in range(nx))

    def find_edges(self):
        """Finds the crossed edges, (z, y, direction, x) -> end point, and the samples at their ends."""
        self.crossed, self.active = {}, set()
        for p in self.points():
            grid = [p[a] + self.header.origin[a] for a in range(3)]
            for number, (direction, same) in enumerate(EDGES):
                end = tuple(p[a] + direction[a] for a in range(3))
                if len({grid[a] & 1 for a in same}) > 1 or not (self.present[p] and self.present.get(end)):
                    continue
                if self.positive[p] != self.positive[end]:
                    self.crossed[p[2], p[1], number, p[0]] = end
                    self.active |= {p, end}

    def read_slices(self):
        h = self.header
        self.missed_p, self.high, self.longer, self.mantissa = self.tables.cut(
            "kTrainedLevels" if h.values else "kTrainedExactValues", 576, 576, 3456, 108)
        self.wrong, self.lower, self.further = self.tables.cut("kTrainedCorrections", 96, 96, 8)
        self.known, self.value, self.q = {}, {}, {}
        self.recent = [2048, 512] if h.values else [16, 8]
        edges = sorted(self.crossed)
        for z in range(h.size[2]):
            for p in sorted((p for p in self.active if p[2] == z), key=lambda p: (p[1], p[0])):
                if self.is_data[p]:
                    self.read_sample(p)
                else:
                    self.value[p] = h.layer_level if h.values else h.layer_value
            for edge in edges:
                if (edge[0] == z - 1 and edge[2] >= 4) or (edge[0] == z and edge[2] < 4):
                    self.q[edge] = self.cut(edge)

    def read_sample(self, p):
        h = self.header
        inside = tuple(tuple(clamp(p[a] + n[a], 0, h.size[a] - 1) for a in range(3)) for n in NEIGHBOURS)
        outside = [tuple(p[a] + n[a] for a in range(3)) for n in NEIGHBOURS]
        known = [self.known.get(n) for n in outside]
        mask = sum(1 << i for i, k in enumerate(known) if k)
        g, missed = self.recent
        if mask:
            total = sum(f for f, k in zip(FACTORS, known) if k)
            g = (sum(f * abs(k[0]) for f, k in zip(FACTORS, known) if k) + total // 2) // total
            missed = 2 * sum(f * k[1] for f, k in zip(FACTORS, known) if k) // total
        inputs = [k[0] if k else g if self.positive[n] else -g for k, n in zip(known, inside)]
        for axis in range(3):
            behind = tuple(min(p[a] + (a == axis), h.size[a] - 1) for a in range(3))
            inputs.append(g if self.positive[behind] else -g)
        inputs.append(g if self.positive[p] else -g)
        total = 128 + sum(w * i for w, i in zip(self.tables.weights[mask], inputs))
        predicted = max(0, (total if self.positive[p] else -total) >> 9)
        scale = missed + (g >> 2)
        neighbours = bin(mask).count("1")
        support = 0 if not mask else 1 if neighbours <= 2 else 2 if neighbours <= 4 else 3

        if h.values == 0:
            context = 4 * min(half_octaves(scale), 23) + support
            place = 0 if predicted == 0 else next((i for i, f in enumerate((8, 4, 2, 1), 1) if f * predicted < scale), 5)
            exact = clamp(predicted + self.residual(context, place, predicted > 0), 0, 2**25 - 1)
            whole = int(h.isovalue // 1)
            self.value[p] = float(whole + 1 + exact if self.positive[p] else whole - exact)
            m = min(exact, 65535)
        else:
            seen = max(predicted, scale // 8)
            near = self.level_near(seen)
            context = 4 * clamp(half_octaves(scale) - half_octaves(seen) + 2 * h.levels_log2 + 8, 0, 23) + support
            place = min(2 * near >> h.levels_log2, 5)
            level = clamp(near + self.residual(context, place, near > 0), 0, h.levels - 1)
            self.value[p] = level
            m = self.magnitude(level)
        t = min(abs(m - predicted), 65535)
        w = 2 * m + 1
        self.known[p] = (w if self.positive[p] else -w, t)
        self.recent = [(7 * self.recent[0] + w) >> 3, (7 * self.recent[1] + 2 * t) >> 3]

    def residual(self, context, place, can_be_less):
        bit = self.bits.bit
        if not bit(self.missed_p[6 * context + place]):
            return 0
        negative = bit(self.high[6 * context + place]) if can_be_less else 0
        k = 0
        while k < 26 and bit(self.longer[(2 * context + negative) * 18 + min(k, 17)]):
            k += 1
        size, mantissa, left = 1, (2 * min(k, 17) + negative) * 3, k
        if left > 0:
            size, left = size << 1 | bit(self.mantissa[mantissa]), left - 1
        if left > 0:
            size, left = size << 1 | bit(self.mantissa[mantissa + 1 + (size & 1)]), left - 1
        size = size << left | self.bits.number(left)
        return -size if negative else size

    def magnitude(self, level):
        h = self.header
        if level == 0:
            return 0
        e = (h.first + level - 1 - (h.unit << h.levels_log2)) * 8 >> h.levels_log2
        return 1 if e < 0 else 65535 if e >= 128 else min(((POWERS[e % 8] << (e // 8)) + 2**29) >> 30, 65535)

    def level_near(self, v):
        h = self.header
        if v < 1:
            return 0
        log = v.bit_length() - 1
        mantissa = (v << 5 >> log) & 31
        level = (8 * log + EIGHTHS[mantissa] + (4 >> h.levels_log2)) >> (3 - h.levels_log2)
        return clamp(level + (h.unit << h.levels_log2) - h.first + 1, 0, h.levels - 1)

    def quantized_cut(self, difference, nudge=0):
        """The crossing's position, measured from the end with the lower level."""
        s = self.header.steps
        e = min(8 * abs(difference) >> self.header.levels_log2, 176)
        r = POWERS[e % 8] << (e // 8)
        d = 2**30 + r
        dividend = 2 * s * (r if difference < 0 else 2**30) + d + nudge * (d >> 19)
        return clamp(dividend // (2 * d), 1, s - 1)

    def cut(self, edge):
        h, s = self.header, self.header.steps
        z, y, number, x = edge
        a, b = self.value[x, y, z], self.value[self.crossed[edge]]
        if h.values == 0:
            dx, dy, dz = EDGES[number][0]
            turned = 4 * dx + 2 * dy + dz < 0
            if turned:
                a, b = b, a
            q = clamp(int((h.isovalue - a) / (b - a) * s + 0.5), 1, s - 1)
            return s - q if turned else q
        if a == 0 or b == 0:
            return 1 if a == 0 else s - 1
        d = abs(b - a)
        q = self.quantized_cut(d)
        if h.values == 1:
            q = self.corrected(d, q)
        return s - q if b < a else q

    def corrected(self, d, q):
        least, greatest = self.quantized_cut(d + 1, -1), self.quantized_cut(d - 1, 1)
        if least == greatest or not self.bits.bit(self.wrong[min(d, 95)]):
            return q
        is_less = self.bits.bit(self.lower[min(d, 95)]) if least < q < greatest else q == greatest
        bound = q - least if is_less else greatest - q
        distance = 1
        while distance < bound and self.bits.bit(self.further[min(distance, 8) - 1]):
            distance += 1
        return q - distance if is_less else q + distance

    def vertex(self, p, q):
        """The lattice vertex on the edge between two samples."""
        number = {direction: i for i, (direction, _) in enumerate(EDGES)}
        step = tuple(q[a] - p[a] for a in range(3))
        if step not in number:
            p, step = q, tuple(-c for c in step)
        cut = self.q[p[2], p[1], number[step], p[0]]
        return tuple((p[a] + self.header.origin[a]) * self.header.steps + step[a] * cut for a in range(3))

    def march(self):
        self.mesh = []
        h = self.header
        for cell in itertools.product(*(range(n - 1) for n in h.size)):
            even = tuple(c + ((c + o) & 1) for c, o in zip(cell, h.origin))
            odd = tuple(2 * c + 1 - e for c, e in zip(cell, even))
            for order in itertools.permutations(range(3)):
                corners = [even]
                for axis in order:
                    corners.append(tuple(odd[a] if a == axis else corners[-1][a] for a in range(3)))
                if all(self.present[p] for p in corners):
                    self.add_polygon(corners)

    def add_polygon(self, corners):
        above = [p for p in corners if self.positive[p]]
        below = [p for p in corners if not self.positive[p]]
        if not above or not below:
            return
        if len(above) == 2:
            ends = [(above[0], below[0]), (above[0], below[1]), (above[1], below[1]), (above[1], below[0])]
        else:
            ends = [(p, q) for p in above for q in below]
        # Orients the polygon to the low corners' mean, by midpoints of edges: rounding cannot make these collinear.
        middles = [tuple(p[a] + q[a] for a in range(3)) for p, q in ends]
        u, v = ([middles[i][a] - middles[0][a] for a in range(3)] for i in (1, 2))
        normal = [u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3] for a in range(3)]
        down = [sum(p[a] for p in below) * len(above) - sum(p[a] for p in above) * len(below) for a in range(3)]
        polygon = [self.vertex(p, q) for p, q in ends]
        if sum(n * d for n, d in zip(normal, down)) < 0:
            polygon.reverse()
        if len(polygon) == 3:
            self.mesh.append(tuple(polygon))
            return
        p, q, r, s = polygon
        pr, qs = (sum((m - n)**2 for m, n in zip(*ends)) for ends in ((p, r), (q, s)))
        along_first = pr < qs or (pr == qs and min(p, r) < min(q, s))
        self.mesh += [(p, q, r), (p, r, s)] if along_first else [(q, r, s), (q, s, p)]

    def summary(self):
        triangles = sorted(min(t[i:] + t[:i] for i in range(3)) for t in self.mesh)
        total = 2166136261
        for triangle in triangles:
            for coordinate in itertools.chain(*triangle):
                total = ((total ^ (coordinate & 0xffffffff)) * 16777619) & 0xffffffff
        vertices = len(set(itertools.chain(*triangles)))
        assert (vertices, len(triangles)) == (self.header.vertices, self.header.triangles), "Not what the header says"
        return f"{vertices} {len(triangles)} {total:x}"


def is_decoded(folder, tables):
    wrong = 0
    for line in (folder / "shells.txt").read_text().splitlines():
        name, expected = line.split(" ", 1)
        found = Shell((folder / f"shell_{name}.bin").read_bytes(), tables).summary()
        print(f"{name}: {found}")
        if found != expected:
            print(f"{name}: expected {expected}")
            wrong += 1
    return wrong == 0


def main():
    tables = Tables(sys.argv[1])
    folders = [pathlib.Path(folder) for folder in sys.argv[2:]]
    return 0 if folders and all([is_decoded(folder, tables) for folder in folders]) else 1


if __name__ == "__main__":
    sys.exit(main())
