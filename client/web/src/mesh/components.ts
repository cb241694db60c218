// Disjoint sets of the numbers 0 to n - 1.
export class Components {
  private readonly parent: Uint32Array;

  constructor(n: number) {
    this.parent = new Uint32Array(n);
    for (let i = 0; i < n; ++i) this.parent[i] = i;
  }

  join(a: number, b: number): void {
    a = this.root(a);
    b = this.root(b);
    this.parent[Math.max(a, b)] = Math.min(a, b);
  }

  root(v: number): number {
    const p = this.parent;
    while (p[v] !== v) v = p[v] = p[p[v]];
    return v;
  }

  count(): number {
    let roots = 0;
    for (let v = 0; v < this.parent.length; ++v) roots += this.parent[v] === v ? 1 : 0;
    return roots;
  }
}
