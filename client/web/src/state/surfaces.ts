// The surfaces of one view as a list. The first one's isovalue and error are the settings' own, so that the address of
// a page with one surface stays short. All others have their own.
import { defaults, type AdditionalSurface, type Settings } from "./settings";

export interface SurfaceSettings extends Omit<AdditionalSurface, "isovalue"> {
  isovalue: number | null; // Null, of the first alone: the dataset's own suggestion.
}

// The most surfaces that a user adds by hand.
export const mostSurfaces = 8;
// The most labels of a segmentation.
export const mostLabels = 1024;
export const maxMinComponent = 1e6; // Samples, as everywhere in the project.

const outerOpacity = 0.35;

// Distinguishable for color-blind users; the first two are bone and skin.
const colors = ["#e0cdb4", "#d9775f", "#7fb3d5", "#e6c65c", "#8fc9a3", "#b7a3d9", "#d99bc4", "#9aa5b3"];

export function surfacesOf(settings: Settings): SurfaceSettings[] {
  const { isovalue, error, color, opacity, visible, minComponent, hiddenParts, material, largestOnly } = settings;
  return [{ isovalue, error, color, opacity, visible, minComponent, hiddenParts, material, largestOnly }, ...settings.surfaces];
}

// The request for this surface alone. Null: there is none.
export function settingsOf(settings: Settings, at: number): Settings | null {
  const own = surfacesOf(settings)[at];
  if (!own) return null;
  const { minComponent, hiddenParts, material, largestOnly } = defaults; // The first one's settings do not apply to others.
  return { ...settings, minComponent, hiddenParts, material, largestOnly, ...own, error: own.error ?? settings.error, surfaces: defaults.surfaces };
}

// Parts that were hidden belong to one isovalue: at another one all are shown.
export function withSurface(settings: Settings, at: number, given: Partial<SurfaceSettings>): Partial<Settings> {
  const hasHidden = (surfacesOf(settings)[at]?.hiddenParts?.length ?? 0) > 0;
  const change = given.isovalue !== undefined && hasHidden ? { hiddenParts: [], ...given } : given;
  if (at === 0) {
    const { error, dataset: _own, ...rest } = change;
    return error === undefined || error === null ? rest : { ...rest, error };
  }
  const { isovalue, ...rest } = change;
  const own = isovalue === undefined || isovalue === null ? rest : { ...rest, isovalue };
  return { surfaces: settings.surfaces.map((surface, i) => (i === at - 1 ? { ...surface, ...own } : surface)) };
}

type AllChange = Pick<SurfaceSettings, "visible"> | Pick<SurfaceSettings, "opacity"> | Pick<Settings, "minComponent"> | Pick<Settings, "hiddenParts">;

// What is changed of each; null: nothing.
export function withAllSurfaces(
  settings: Settings, change: (surface: SurfaceSettings, at: number) => AllChange | null,
): Partial<Settings> {
  const [first, ...others] = surfacesOf(settings);
  const surfaces = others.map((one, i) => ({ ...settings.surfaces[i], ...change(one, i + 1) }));
  return { ...change(first, 0), surfaces };
}

// Nothing more than `mostSurfaces`. A surface encloses those of larger isovalues: of the new one and the first, the outer one
// becomes translucent, unless it is. `suggested`: the first one's isovalue, where the settings have none.
export function withAddedSurface(settings: Settings, isovalue: number, suggested: number): Partial<Settings> {
  const used = surfacesOf(settings);
  if (used.length >= mostSurfaces) return {};
  const color = colors.find((one) => used.every((surface) => surface.color !== one)) ?? colors[0];
  const isOuter = isovalue < (settings.isovalue ?? suggested);
  const surface = { isovalue, error: null, color, opacity: isOuter ? outerOpacity : 1, visible: true };
  const surfaces = [...settings.surfaces, surface];
  return isOuter || settings.opacity < 1 ? { surfaces } : { surfaces, opacity: outerOpacity };
}

// The first leaves its place to the second; the last one stays.
export function withoutSurface(settings: Settings, at: number): Partial<Settings> {
  const surfaces = settings.surfaces.filter((_, i) => i !== at - 1);
  if (at > 0) return { surfaces };
  const [next, ...rest] = settings.surfaces;
  if (!next) return {};
  const { dataset, ...look } = next;
  const { minComponent, hiddenParts, material, largestOnly } = { ...defaults, ...look };
  const own = dataset || settings.dataset;
  // Those that were of the first one's dataset still are.
  const kept = rest.map((one) => (own === settings.dataset || one.dataset ? one : { ...one, dataset: settings.dataset }));
  return { ...look, minComponent, hiddenParts, material, largestOnly, dataset: own, error: next.error ?? settings.error, surfaces: kept };
}
