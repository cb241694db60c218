// All settings of a user as one plain value: the request and its display. One table says for each its first value, how
// it is written in the page's address, and what else depends on it.
//
// Addresses and other pages write the first surface's own fields beside `surfaces`, which has the others, so that
// addresses of one surface are short: WrittenSettings (written_settings.ts). Everywhere else one list has all of them.
import { colorMaps } from "../shared/color_maps";
import * as format from "./setting_formats";
import { materials, type SurfaceSettings } from "./setting_types";

export * from "./setting_types";

interface Setting<T> {
  initial: T;
  format: format.Format<NonNullable<T>>;
  isRequested: boolean; // A change needs another request.
  isOfView: boolean; // Undo leaves it as it is: the camera, the time, what was measured.
}

type Roles = Partial<Pick<Setting<unknown>, "isRequested" | "isOfView">>;

function setting<T>(written: format.Format<T>, initial: NoInfer<T>, roles: Roles = {}): Setting<T> {
  return { initial, format: written as format.Format<NonNullable<T>>, isRequested: false, isOfView: false, ...roles };
}

// At first null: not set.
function optional<T extends object | number>(written: format.Format<T>, roles: Roles = {}): Setting<T | null> {
  return setting<T | null>(written as format.Format<T | null>, null, roles);
}

const requested = { isRequested: true };
const ofView = { isOfView: true };
const onOff = (initial: boolean, roles?: Roles) => setting(format.onOff, initial, roles);
const share = (initial: number) => setting(format.number(0, 1), initial); // 0 to 1 along a normal or an axis.

// The first surface's own; its dataset and error are the view's.
const firstTable = {
  isovalue: optional(format.anyNumber),
  color: setting(format.color, "#e0cdb4"),
  material: setting(format.oneOf(...materials), "neutral"),
  opacity: share(1),
  visible: onOff(true),
  minComponent: setting(format.minComponent, 0),
  hiddenParts: setting(format.hiddenParts, []),
};

const viewTable = {
  // The request.
  dataset: setting(format.text, ""), // Or a series of datasets: its first member.
  labels: setting(format.labels, ""), // The visible labels of a segmentation (label_ranges.ts), until they become surfaces; then empty.
  t: optional(format.anyNumber, ofView), // The time within a series; the nearest one is shown. Null: the dataset's own.
  error: setting(format.number(0, 1e6), 0.25, requested), // Voxels.
  bound: setting(format.oneOf("certified", "paper"), "certified", requested),
  topologyRule: setting(format.oneOf("exact", "paper"), "exact", requested),
  topologyTolerance: setting(format.number(0, 1e6), 0, requested), // Voxels.
  region: optional(format.region, requested),
  followView: onOff(true, requested), // Reduces the error where it exceeds `pixels` on the screen.
  pixels: setting(format.number(0.1, 100), 1), // Allowed error on the screen, with followView.
  maxTriangles: setting(format.number(0, 1e9), 0, requested), // 0: no limit.
  drawableTriangles: setting(format.number(0, 60e6), 12e6), // Of a surface at full resolution, where that is complete sooner; for later requests.
  simplify: onOff(true, requested), // Removes triangles that the error does not require.
  surfaces: setting(format.surfaces, []), // As written: all but the first.
  labelNames: setting(format.labelNames, []), // Names given by the user.
  // Display.
  colorBy: setting(format.text, "", requested), // The dataset whose values color the surfaces; empty: none.
  colors: setting(format.oneOf(...colorMaps), "viridis"), // This and the next four: the color scale of those values.
  fieldLevel: optional(format.anyNumber),
  fieldWindow: optional(format.number(0, Number.MAX_VALUE)),
  fieldLog: onOff(false), // Logarithmic color scale.
  noValueColor: setting(format.color, "#808080"), // The color where the field has no value.
  shading: setting(format.oneOf("field", "smooth", "facets"), "smooth"),
  wireframe: onOff(false),
  coloring: setting(format.oneOf("plain", "tiles", "steps"), "plain"),
  clip: setting(format.oneOf("off", "x", "y", "z", "oblique"), "off"),
  clipAt: share(0.5),
  clipNormal: optional(format.direction), // The normal of an oblique cut, a unit vector; null: none chosen.
  clipFlipped: onOff(false),
  crop: optional(format.box), // The box outside of which everything is hidden; null: nothing is.
  filled: onOff(true), // Fills the cut and the crop's faces with the samples inside the surfaces.
  slice: setting(format.oneOf("off", "x", "y", "z"), "off"), // A plane of samples in the scene.
  samplesOf: setting(format.text, ""), // The dataset whose samples planes show; empty: the first surface's, or the image of a segmentation.
  transparentAir: onOff(true), // Hides samples of air.
  sliceAt: share(0.5),
  layout: setting(format.oneOf("surface", "four"), "surface"), // The surface alone, or with three orthogonal slices.
  cross: optional(format.place, ofView), // The point where the three slices intersect; null: the center of the data.
  sliceColors: setting(format.oneOf(...colorMaps), "gray"), // The colors of samples.
  level: optional(format.anyNumber), // The center and the length of the sample colors' range; null: a range that shows most of the data.
  windowWidth: optional(format.number(0, Number.MAX_VALUE)),
  samplesLog: onOff(false),
  volume: setting(format.oneOf("off", "on", "maximum"), "off"), // The samples as a volume, or the largest value along each ray.
  opacities: setting(format.opacities, []), // Of the volume by value; empty: those usual for the data.
  volumeShading: onOff(true), // Lights the volume by its gradients.
  volumeLabels: setting(format.oneOf("off", "color", "only"), "off"), // Labels color the volume, or are all that is shown of it.
  axes: onOff(true),
  projection: setting(format.oneOf("perspective", "orthographic"), "perspective"),
  occlusion: onOff(true), // Darkens hollows.
  logScale: onOff(true),
  theme: setting(format.oneOf("auto", "dark", "light"), "auto", ofView),
  gestures: setting(format.oneOf("auto", "cooperative", "all"), "auto"), // Cooperative ones leave the wheel and one finger to the page around.
  playing: onOff(false, ofView), // Plays the times.
  speed: setting(format.number(0.1, 60), 10), // Times per second.
  loop: onOff(true), // Restarts after the last time.
  up: setting(format.direction, [0, 0, 1], ofView), // The up direction, a unit vector in world coordinates.
  eye: optional(format.place, ofView), // Null: the default view.
  target: optional(format.place, ofView),
  places: setting(format.places, [], ofView), // At most three.
};

// In the order of addresses.
export const settingTable = {
  ...{ dataset: viewTable.dataset, labels: viewTable.labels, t: viewTable.t, isovalue: firstTable.isovalue },
  ...viewTable,
  ...firstTable,
};

type ValuesOf<Table> = { [Name in keyof Table]: Table[Name] extends Setting<infer T> ? T : never };
export type WrittenSettings = ValuesOf<typeof settingTable>;
export type Settings = Omit<ValuesOf<typeof viewTable>, "surfaces"> & { surfaces: readonly SurfaceSettings[] }; // At least one.

export type Cut = Settings["clip"];
export type Coloring = Settings["coloring"];

const initialOf = <Table extends object>(table: Table) =>
  Object.fromEntries(Object.entries(table).map(([name, { initial }]) => [name, initial])) as ValuesOf<Table>;

export const firstNames = Object.keys(firstTable);
export const settingNames = Object.keys(viewTable) as (keyof Settings)[];
export const writtenNames = Object.keys(settingTable) as (keyof WrittenSettings)[];
export const writtenDefaults: WrittenSettings = initialOf(settingTable);
export const defaultSurface: SurfaceSettings = { dataset: "", error: null, ...initialOf(firstTable) };
export const defaults: Settings = { ...initialOf(viewTable), surfaces: [defaultSurface] };

// Returns whether a new request is needed now. Not for another dataset or time: these are requested when the dataset is
// available.
export function isOtherRequest(now: Settings, before: Settings): boolean {
  if (now.dataset !== before.dataset || now.t !== before.t) return false;
  const isOther = (name: keyof Settings) => now[name] !== before[name];
  const requested = ({ surfaces }: Settings) => surfaces.map(({ dataset, isovalue, error, visible }) => `${dataset} ${isovalue} ${error} ${visible}`).join();
  return (
    settingNames.some((name) => viewTable[name].isRequested && isOther(name)) ||
    requested(now) !== requested(before) ||
    (now.followView && isOther("pixels")) ||
    (now.shading === "field") !== (before.shading === "field")
  );
}
