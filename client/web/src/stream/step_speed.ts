// Measures how many triangles per second are decoded, checked and shown; servers plan their steps with it. Counts from
// a step's last tile on, because until then the network may be the bottleneck.

const few = 5000; // Smaller steps are ignored.
const weight = 0.5; // The weight of the latest step in the moving average.

export class StepSpeed {
  // The default until a step was measured.
  private perSecond = 500_000;

  get trianglesPerSecond(): number {
    return this.perSecond;
  }

  record(triangles: number, milliseconds: number): void {
    if (triangles < few || !(milliseconds > 0)) return;
    this.perSecond += weight * ((1000 * triangles) / milliseconds - this.perSecond);
  }
}
