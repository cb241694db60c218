// Names of three's layers: which objects are in which pass of a frame. Lights are in all of them.
export const layers = {
  solid: 0, // Opaque surfaces.
  translucent: 1, // Translucent surfaces; scene_renderer.ts orders them.
  marks: 3, // Lines and other marks, which do not cause occlusion.
  overlay: 2, // Handles and marks that are never hidden.
  upload: 4, // Objects to upload to the GPU that are not drawn yet.
} as const;
