// Numbers distinct lattice points in order of appearance; a hash table without objects.
export class PointNumbers {
  private slots: Int32Array;
  private mask: number;
  private points: Int32Array;
  private count = 0;

  constructor(expected: number) {
    let size = 16;
    while (size < 2 * expected) size *= 2;
    this.slots = new Int32Array(size).fill(-1);
    this.mask = size - 1;
    this.points = new Int32Array(3 * Math.max(8, expected));
  }

  // Returns the number of this point, assigning a new one if needed.
  numberOf(x: number, y: number, z: number): number {
    let slot = scattered(x, y, z) & this.mask;
    for (;;) {
      const found = this.slots[slot];
      if (found < 0) break;
      const p = this.points;
      if (p[3 * found] === x && p[3 * found + 1] === y && p[3 * found + 2] === z) return found;
      slot = (slot + 1) & this.mask;
    }
    const number = this.count++;
    if (3 * this.count > this.points.length) this.growPoints();
    this.points[3 * number] = x;
    this.points[3 * number + 1] = y;
    this.points[3 * number + 2] = z;
    this.slots[slot] = number;
    if (2 * this.count > this.slots.length) this.growSlots();
    return number;
  }

  get size(): number {
    return this.count;
  }

  // Three coordinates per point.
  coordinates(): Int32Array {
    return this.points.slice(0, 3 * this.count);
  }

  private growPoints(): void {
    const larger = new Int32Array(2 * this.points.length);
    larger.set(this.points);
    this.points = larger;
  }

  private growSlots(): void {
    this.slots = new Int32Array(2 * this.slots.length).fill(-1);
    this.mask = this.slots.length - 1;
    for (let number = 0; number < this.count; ++number) {
      const [x, y, z] = this.points.subarray(3 * number, 3 * number + 3);
      let slot = scattered(x, y, z) & this.mask;
      while (this.slots[slot] >= 0) slot = (slot + 1) & this.mask;
      this.slots[slot] = number;
    }
  }
}

function scattered(x: number, y: number, z: number): number {
  let h = Math.imul(x, 0x9e3779b1) ^ Math.imul(y, 0x85ebca77) ^ Math.imul(z, 0xc2b2ae3d);
  h = Math.imul(h ^ (h >>> 15), 0x2c1b3c6d);
  return h ^ (h >>> 13);
}
