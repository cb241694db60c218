import { noProgress, type StepFacts } from "../../../client/web/src/state/progress";
import { defaults, type Settings } from "../../../client/web/src/state/settings";
import { withSurface } from "../../../client/web/src/state/surfaces";
import { ShownReports } from "../../../client/web/src/surfaces/shown_reports";
import { settingsFrom, surface } from "./made_settings";

const [one, two] = [1, 2].map((triangles) => ({ triangles }) as StepFacts);
const both = settingsFrom({ surfaces: [surface({ isovalue: 7 })] });

// `drawn` has the step at each place; `heard` the reported places and triangles.
function reports() {
  const drawn: (StepFacts | null)[] = [one, two];
  const heard: number[][] = [];
  const now: { settings: Settings; isCurrent: boolean } = { settings: both, isCurrent: true };
  const steps = { progressOf: (at: number) => ({ ...noProgress, shown: drawn[at] ?? null }), isCurrent: () => now.isCurrent };
  const made = new ShownReports(
    steps,
    () => now.settings,
    ({ surface, triangles }) => heard.push([surface, triangles]),
  );
  return { drawn, heard, now, made, since: () => heard.splice(0) };
}

describe("ShownReports", () => {
  test("HaveOnlyVisibleCurrentSurfaces", () => {
    const { made, now, since } = reports();
    now.settings = { ...both, ...withSurface(both, 0, { visible: false }) };
    made.update();
    for (const at of [0, 1]) made.add(at);
    expect(since()).toEqual([
      [1, 2],
      [1, 2],
    ]); // A step that is shown again is reported again.
    now.settings = both;
    made.update();
    made.update();
    expect(since()).toEqual([[0, 1]]);
    now.isCurrent = false;
    made.add(0);
    expect([since(), made.current]).toEqual([[], []]);
  });

  test("RepeatStepsAtOtherPlaces", () => {
    const { made, now, drawn, since } = reports();
    made.update();
    expect(since()).toEqual([
      [0, 1],
      [1, 2],
    ]);
    [now.settings, drawn[0]] = [defaults, two];
    made.update();
    expect(since()).toEqual([[0, 2]]);
    [now.settings, drawn[0]] = [both, one];
    made.update();
    expect(since()).toEqual([
      [0, 1],
      [1, 2],
    ]);
  });
});
