// Neuroglancer as on its own site; the address after "#!" determines what is shown.
import "neuroglancer/unstable/util/polyfills.js";
import "neuroglancer/unstable/layer/enabled_frontend_modules.js";
import "neuroglancer/unstable/datasource/enabled_frontend_modules.js";
import "neuroglancer/unstable/kvstore/enabled_frontend_modules.js";
import { setupDefaultViewer } from "neuroglancer/unstable/ui/default_viewer_setup.js";

const viewer = setupDefaultViewer();

// For each layer: the number of chunks that its view needs, and of those available.
window.pieces = () =>
  viewer.layerManager.managedLayers.map(({ name, layer }) => {
    const infos = (layer?.renderLayers ?? []).map((one) => one.layerChunkProgressInfo);
    const sum = (key) => infos.reduce((before, progress) => before + progress[key], 0);
    return { name, needed: sum("numVisibleChunksNeeded"), there: sum("numVisibleChunksAvailable") };
  });
