import { listenToSlice, type SliceActions } from "../../../client/web/src/scene/slice_gestures";

// Returns a canvas without a page, and what its gestures call.
function heard() {
  const calls: [keyof SliceActions, ...unknown[]][] = [];
  const note =
    (name: keyof SliceActions) =>
    (...values: unknown[]) =>
      void calls.push([name, ...values]);
  const canvas = Object.assign(new EventTarget(), { setPointerCapture: () => {}, clientWidth: 100, clientHeight: 80 });
  listenToSlice(canvas as unknown as HTMLCanvasElement, {
    moveCross: note("moveCross"),
    step: note("step"),
    zoom: note("zoom"),
    pan: note("pan"),
    resetZoom: note("resetZoom"),
    mark: note("mark"),
  });
  const send = (type: string, values: object) => canvas.dispatchEvent(Object.assign(new Event(type), values));
  const point = (type: string, pointerId: number, offsetX: number, offsetY: number, button = 0, shiftKey = false) =>
    send(type, { pointerId, offsetX, offsetY, button, shiftKey });
  return { calls, send, point };
}

describe("SliceGestures", () => {
  test("DragTheCrosshair", () => {
    const { calls, point } = heard();
    point("pointerdown", 1, 10, 20);
    point("pointermove", 1, 11, 22);
    point("pointerup", 1, 12, 23);
    expect(calls).toEqual([
      ["moveCross", 10, 20, true],
      ["moveCross", 11, 22, true],
      ["moveCross", 12, 23, false],
    ]);
  });

  test("PanWithTheRightButtonOrShift", () => {
    for (const [button, shiftKey] of [
      [2, false],
      [0, true],
    ] as const) {
      const { calls, point } = heard();
      point("pointerdown", 1, 10, 20, button, shiftKey);
      point("pointermove", 1, 15, 18);
      point("pointerup", 1, 15, 18);
      expect(calls).toEqual([["pan", 5, -2]]);
    }
  });

  test("PinchAfterEndingTheDragOfTheFirstFinger", () => {
    const { calls, point } = heard();
    point("pointerdown", 1, 10, 20);
    point("pointerdown", 2, 30, 20);
    point("pointermove", 2, 50, 20);
    point("pointerup", 2, 50, 20);
    point("pointermove", 1, 99, 99); // The finger that is left does nothing.
    point("pointerup", 1, 99, 99);
    expect(calls).toEqual([
      ["moveCross", 10, 20, true],
      ["moveCross", 10, 20, false],
      ["pan", 10, 0],
      ["zoom", 2, 30, 20],
    ]);
  });

  test("StepWithTheWheelAndZoomWithControl", () => {
    const { calls, send } = heard();
    const wheel = { deltaMode: 0, offsetX: 3, offsetY: 4, ctrlKey: false, metaKey: false };
    send("wheel", { ...wheel, deltaY: 50 });
    expect(calls).toEqual([]);
    send("wheel", { ...wheel, deltaY: 80 });
    send("wheel", { ...wheel, deltaY: 300, ctrlKey: true });
    expect(calls).toEqual([
      ["step", "normal", -2],
      ["zoom", Math.exp(-1), 3, 4],
    ]);
  });

  test("MarkPlacesByDoubleClicksAndTheCrosshairByAKey", () => {
    const { calls, send } = heard();
    send("dblclick", { offsetX: 7, offsetY: 9 });
    send("keydown", { key: "m" });
    send("keydown", { key: "m", ctrlKey: true });
    send("keydown", { key: "f" });
    expect(calls).toEqual([["mark", { x: 7, y: 9 }], ["mark", null], ["resetZoom"]]);
  });
});
