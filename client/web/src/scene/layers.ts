// What takes part in which pass of a frame: three's layers, by name. Lights are in all of them.
export const layers = {
  solid: 0, // Surfaces that hide what is behind them.
  translucent: 1, // Surfaces that one sees through; scene_renderer.ts puts them in order.
  marks: 3, // Lines and glass around it all, which darken nothing.
  overlay: 2, // Handles and marks that nothing hides.
  upload: 4, // Goes to the graphics card, and is not drawn yet.
} as const;
