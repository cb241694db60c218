// The viewer as a widget of notebooks, in anywidget's form: render({ model, el }) returns a cleanup function. Its server is
// reached through the kernel. client/python/multitetra/viewer.py is the Python side.
import { type GivenSettings, Viewer } from "../module";
import { offerChannels } from "../stream/channel";
import colors from "../style/colors.css?inline";
import picture from "../style/picture.css?inline";
import { KernelChannels, type WidgetModel } from "./kernel_channel";

const scheme = "kernel:";
const pictureDelay = 1000; // Milliseconds after a surface is complete.
const byModel = new WeakMap<WidgetModel, HTMLElement>();
const kernels = new Map<string, KernelChannels>();

offerChannels(scheme, (address) => kernels.get(address)!.channel());

// The widget's output may be drawn again, with the same viewer.
function render({ model, el, token }: { model: WidgetModel; el: HTMLElement; token: string }): () => void {
  const element = byModel.get(model) ?? newViewer(model, token);
  element.style.height = `${model.get("height") as number}px`;
  el.appendChild(element);
  return () => {
    if (element.parentElement === el) element.remove();
  };
}

function newViewer(model: WidgetModel, token: string): HTMLElement {
  addStyles();
  const element = document.createElement("div");
  element.style.position = "relative";
  byModel.set(model, element);
  const address = scheme + String(kernels.size + 1);
  kernels.set(address, new KernelChannels(model));
  const wanted = () => model.get("wanted") as GivenSettings;
  const save = (name: string, value: unknown) => {
    model.set(name, value);
    model.save_changes();
  };
  let viewer: Viewer;
  try {
    viewer = new Viewer(element, { server: address, token });
  } catch (problem) {
    element.textContent = `The viewer cannot draw here: ${String(problem)}`;
    return element;
  }
  const setWanted = () => {
    const now = viewer.get() as unknown as Record<string, unknown>;
    const other = Object.entries(wanted()).filter(([name, value]) => JSON.stringify(value) !== JSON.stringify(now[name]));
    if (other.length === 0) return;
    const ignored = viewer.set(Object.fromEntries(other) as GivenSettings);
    if (ignored.length > 0) save("ignored", ignored);
  };
  let timer = 0;
  viewer.on("state", (state) => save("settings", state));
  viewer.on("picked", (place) => save("picks", [...(model.get("picks") as unknown[]), place]));
  viewer.on("shown", (facts) => {
    save("shown", facts);
    window.clearTimeout(timer);
    if (facts.isFinal) timer = window.setTimeout(() => void sendPicture(model, viewer), pictureDelay);
  });
  model.on("change:wanted", setWanted);
  setWanted();
  return element;
}

// For notebooks that are opened without a kernel.
async function sendPicture(model: WidgetModel, viewer: Viewer): Promise<void> {
  const png = await viewer.picture().catch(() => null);
  if (png) model.send({ kind: "picture" }, undefined, [await png.arrayBuffer()]);
}

function addStyles(): void {
  if (document.querySelector("style[data-multitetra]")) return;
  const style = document.createElement("style");
  style.dataset.multitetra = "";
  style.textContent = `${colors + picture}\n.multitetra-picture { display: none !important }`;
  document.head.appendChild(style);
}

export default { render };
