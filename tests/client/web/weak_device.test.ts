import { isWeak } from "../../../client/web/src/embed/weak_device";

test("WeakDevicesHaveFewCoresOrDrawInSoftware", () => {
  expect(isWeak({ cores: 8, renderer: "ANGLE (NVIDIA GeForce RTX 3060)" })).toBe(false);
  expect(isWeak({ cores: 0, renderer: "Apple GPU" })).toBe(false); // Unknown.
  expect(isWeak({ cores: 2, renderer: "Apple GPU" })).toBe(true);
  for (const renderer of ["ANGLE (Google, SwiftShader Device)", "llvmpipe (LLVM 15)", "Microsoft Basic Render Driver"]) {
    expect(isWeak({ cores: 8, renderer })).toBe(true);
  }
});
