// How many triangles a second are decoded, checked and shown here: servers plan their steps with it.
// Time counts from a step's last tile on: until then the link may have been what one waited for.

const few = 5000; // Steps of fewer triangles are ignored.
const weight = 0.5; // The weight of the latest step.

export class StepSpeed {
  // The default until a step was measured.
  private perSecond = 500_000;

  get trianglesPerSecond(): number {
    return this.perSecond;
  }

  note(triangles: number, milliseconds: number): void {
    if (triangles < few || !(milliseconds > 0)) return;
    this.perSecond += weight * ((1000 * triangles) / milliseconds - this.perSecond);
  }
}
