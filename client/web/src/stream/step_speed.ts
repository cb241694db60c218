// How many triangles a second are decoded, checked and shown here: servers plan their steps with it.
// Time counts from a step's last tile on: until then the link may have been what one waited for.

const few = 5000; // Triangles that tell nothing.
const weight = 0.5; // Of the step that was last.

export class StepSpeed {
  // Until a step has told more.
  private perSecond = 500_000;

  get trianglesPerSecond(): number {
    return this.perSecond;
  }

  note(triangles: number, milliseconds: number): void {
    if (triangles < few || !(milliseconds > 0)) return;
    this.perSecond += weight * ((1000 * triangles) / milliseconds - this.perSecond);
  }
}
