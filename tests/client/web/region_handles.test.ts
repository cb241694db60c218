import { layers } from "../../../client/web/src/scene/layers";
import { RegionHandles } from "../../../client/web/src/scene/region_handles";
import type { Stage } from "../../../client/web/src/scene/stage";

type Group = Parameters<Stage["scene"]["add"]>[0];

describe("RegionHandles", () => {
  test("OutlineIsVisibleThroughSurfaces", () => {
    const groups: Group[] = [];
    const stage = {
      scene: { add: (group: Group) => groups.push(group) },
      whenDrawn: () => {},
      invalidate: () => {},
      worldLengthAt: () => 1,
    };
    const handles = new RegionHandles(stage as unknown as Stage, new EventTarget() as HTMLCanvasElement, () => {});
    const outline = () => groups[0].children.find(({ type, layers: { mask } }) => type === "LineSegments" && mask === 1 << layers.overlay)!;
    handles.show({ kind: "box", low: [0, 0, 0], high: [2, 4, 6], error: 1 });
    expect([outline().scale.toArray(), outline().position.toArray()]).toEqual([
      [2, 4, 6],
      [1, 2, 3],
    ]);
    handles.show({ kind: "ball", center: [1, 1, 1], radius: 3, error: 1 });
    expect(outline().scale.toArray()).toEqual([3, 3, 3]);
    handles.show(null);
    expect(groups[0].children).toEqual([]);
  });
});
