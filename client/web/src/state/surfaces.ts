// The surfaces of a view as a list. The first one uses the settings' own isovalue and error, which keeps addresses of
// pages with one surface short; the others have their own.
import { type AdditionalSurface, defaults, type Material, type Settings } from "./settings";

export interface SurfaceSettings extends Omit<AdditionalSurface, "isovalue"> {
  isovalue: number | null; // Null, only for the first: the dataset's suggestion.
}

// The most surfaces that a user can add.
export const maxSurfaces = 8;
export const outerOpacity = 0.35; // Of a surface that encloses others.

// Distinguishable for color-blind users; the first two are bone and skin.
export const surfaceColors = ["#e0cdb4", "#d9775f", "#7fb3d5", "#e6c65c", "#8fc9a3", "#b7a3d9", "#d99bc4", "#9aa5b3"];

// Returns a material, with its color unless the user has chosen another one than those of new surfaces.
export function withMaterial({ color }: Pick<SurfaceSettings, "color">, material: Material): Partial<SurfaceSettings> {
  const isUsual = surfaceColors.includes(color) || Object.values(materialColors).includes(color);
  const own = materialColors[material];
  return isUsual && own ? { material, color: own } : { material };
}

const materialColors: Partial<Record<Material, string>> = { skin: "#e8b89a", bone: "#f0e6d2" };

export function surfacesOf(settings: Settings): SurfaceSettings[] {
  const { isovalue, error, color, opacity, visible, minComponent, hiddenParts, material } = settings;
  return [{ isovalue, error, color, opacity, visible, minComponent, hiddenParts, material }, ...settings.surfaces];
}

// Returns the settings of one surface alone; null: there is no such surface.
export function settingsOf(settings: Settings, at: number): Settings | null {
  const own = surfacesOf(settings)[at];
  if (!own) return null;
  const { minComponent, hiddenParts, material } = defaults; // The first one's settings do not apply to others.
  return { ...settings, minComponent, hiddenParts, material, ...own, error: own.error ?? settings.error, surfaces: defaults.surfaces };
}

// Hidden parts belong to one isovalue: a change of it shows all parts.
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

type AllChange = Partial<Pick<SurfaceSettings, "visible" | "opacity" | "color">> | Pick<Settings, "minComponent"> | Pick<Settings, "hiddenParts">;

// Changes every surface; a null change leaves it as it is.
export function withAllSurfaces(settings: Settings, change: (surface: SurfaceSettings, at: number) => AllChange | null): Partial<Settings> {
  const [first, ...others] = surfacesOf(settings);
  const surfaces = others.map((one, i) => ({ ...settings.surfaces[i], ...change(one, i + 1) }));
  return { ...change(first, 0), surfaces };
}

// Adds a surface, up to `maxSurfaces` without labels, which stay the last. A surface encloses those of larger isovalues: the
// outer one of the new and the first surface becomes translucent, if opaque. `suggested`: the first one's isovalue if the
// settings have none.
export function withAddedSurface(
  settings: Settings,
  isovalue: number,
  suggested: number,
  isLabel: (surface: AdditionalSurface) => boolean = () => false,
): Partial<Settings> {
  const others = settings.surfaces.filter((one) => !isLabel(one));
  const used = [settings, ...others];
  if (used.length >= maxSurfaces) return {};
  const color = surfaceColors.find((one) => used.every((surface) => surface.color !== one)) ?? surfaceColors[0];
  const isOuter = isovalue < (settings.isovalue ?? suggested);
  const surface = { isovalue, error: null, color, opacity: isOuter ? outerOpacity : 1, visible: true };
  const surfaces = [...others, surface, ...settings.surfaces.filter(isLabel)];
  return isOuter || settings.opacity < 1 ? { surfaces } : { surfaces, opacity: outerOpacity };
}

// Shows another dataset by a further surface. Neither encloses the other: the first one becomes opaque if adding a surface
// made it translucent, and the other one translucent.
export function withOtherDataset(
  settings: Settings,
  at: number,
  own: Pick<AdditionalSurface, "isovalue"> & { dataset: string; color?: string },
): Partial<Settings> {
  const change = withSurface(settings, at, { ...own, opacity: outerOpacity });
  return settings.opacity === outerOpacity ? { ...change, opacity: 1 } : change;
}

// Removing the first surface promotes the second; the last one cannot be removed.
export function withoutSurface(settings: Settings, at: number): Partial<Settings> {
  const surfaces = settings.surfaces.filter((_, i) => i !== at - 1);
  if (at > 0) return { surfaces };
  const [next, ...rest] = settings.surfaces;
  if (!next) return {};
  const { dataset, ...look } = next;
  const { minComponent, hiddenParts, material } = { ...defaults, ...look };
  const own = dataset || settings.dataset;
  // Keep the dataset of surfaces that used the first one's.
  const kept = rest.map((one) => (own === settings.dataset || one.dataset ? one : { ...one, dataset: settings.dataset }));
  return { ...look, minComponent, hiddenParts, material, dataset: own, error: next.error ?? settings.error, surfaces: kept };
}
