// Changes of the surfaces of a view.
import { defaultSurface, type Material, type Settings, type SurfaceSettings, type WrittenSettings } from "./settings";

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

// The settings that apply to one surface.
export type OwnSettings = Omit<WrittenSettings, "surfaces">;

export function settingsOf({ surfaces, ...view }: Settings, at: number): OwnSettings {
  return { ...view, ...surfaces[at], dataset: surfaces[at].dataset || view.dataset, error: surfaces[at].error ?? view.error };
}

type Surfaces = Pick<Settings, "surfaces">;

export function withSurface({ surfaces }: Surfaces, at: number, change: Partial<SurfaceSettings>): Surfaces {
  return withAllSurfaces({ surfaces }, (_, i) => (i === at ? change : null));
}

// Changes every surface; a null change leaves it as it is. Returns the same list if nothing is another value.
export function withAllSurfaces({ surfaces }: Surfaces, change: (surface: SurfaceSettings, at: number) => Partial<SurfaceSettings> | null): Surfaces {
  const changed = surfaces.map((one, at) => withFields(one, change(one, at) ?? {}));
  return { surfaces: changed.every((one, at) => one === surfaces[at]) ? surfaces : changed };
}

// Hidden parts belong to one isovalue: a change of it shows all parts.
function withFields(surface: SurfaceSettings, change: Partial<SurfaceSettings>): SurfaceSettings {
  const isOther = (name: string) => change[name as keyof SurfaceSettings] !== surface[name as keyof SurfaceSettings];
  if (!Object.keys(change).some(isOther)) return surface;
  return { ...surface, ...(change.isovalue !== undefined && isOther("isovalue") && { hiddenParts: [] }), ...change };
}

// Adds a surface, up to `maxSurfaces` without labels, which stay the last. A surface encloses those of larger isovalues: the
// outer one of the new and the first surface becomes translucent, if opaque. `suggested`: the first one's isovalue if the
// settings have none.
export function withAddedSurface(
  { surfaces }: Settings,
  isovalue: number,
  suggested: number,
  isLabel: (surface: SurfaceSettings) => boolean = () => false,
): Partial<Settings> {
  const others = surfaces.filter((one, at) => at === 0 || !isLabel(one));
  if (others.length >= maxSurfaces) return {};
  const color = surfaceColors.find((one) => others.every((surface) => surface.color !== one)) ?? surfaceColors[0];
  const [outer] = others;
  const isOuter = isovalue < (outer.isovalue ?? suggested);
  const added = { ...defaultSurface, isovalue, color, opacity: isOuter ? outerOpacity : 1 };
  const all = [...others, added, ...surfaces.filter((one) => !others.includes(one))];
  return isOuter || outer.opacity < 1 ? { surfaces: all } : withSurface({ surfaces: all }, 0, { opacity: outerOpacity });
}

// Shows another dataset by a surface. Neither encloses the other: the first one becomes opaque if adding a surface made it
// translucent, and the other one translucent.
export function withOtherDataset(settings: Settings, at: number, own: Partial<SurfaceSettings>): Surfaces {
  return withAllSurfaces(settings, ({ opacity }, i) => {
    if (i === at) return { ...own, opacity: outerOpacity };
    return i === 0 && opacity === outerOpacity ? { opacity: 1 } : null;
  });
}

// The dataset of the view becomes that of the first one that stays; the last one cannot be removed.
export function withoutSurface(settings: Settings, at: number): Partial<Settings> {
  const surfaces = settings.surfaces.filter((_, i) => i !== at);
  if (surfaces.length === 0) return {};
  const dataset = surfaces[0].dataset || settings.dataset;
  if (dataset === settings.dataset) return { surfaces };
  return { dataset, ...withAllSurfaces({ surfaces }, (one) => ({ dataset: one.dataset === dataset ? "" : one.dataset || settings.dataset })) };
}
