// GPU fences: report whether drawing has finished, by polling without blocking.
import type * as THREE from "three";

// Resolves when all submitted work is drawn, or at once if the context was lost.
export async function gpuFinished(renderer: THREE.WebGLRenderer, pause = 30): Promise<void> {
  const gl = renderer.getContext() as WebGL2RenderingContext;
  const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  if (!fence) return;
  gl.flush();
  while (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) {
    await new Promise((resolve) => setTimeout(resolve, pause));
  }
  gl.deleteSync(fence);
}
