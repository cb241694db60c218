// A limit of triangles for frames on devices that draw many triangles slowly. The visitor of a page expects to turn the
// surface, and did not choose its error; the page may set another limit.

export const maxTrianglesOfWeakDevices = 500_000;
const fewCores = 2;
const softwareRenderers = /swiftshader|llvmpipe|softpipe|software|basic render/i;

export interface Device {
  cores: number; // 0: unknown.
  renderer: string; // Of WebGL.
}

export function isWeak({ cores, renderer }: Device): boolean {
  return (cores > 0 && cores <= fewCores) || softwareRenderers.test(renderer);
}

export function thisDevice(context: WebGLRenderingContext | WebGL2RenderingContext): Device {
  const names = context.getExtension("WEBGL_debug_renderer_info"); // Browsers without it name the renderer in RENDERER.
  const renderer = String(context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER));
  return { cores: navigator.hardwareConcurrency || 0, renderer };
}
