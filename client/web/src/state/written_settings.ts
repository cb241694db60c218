// Settings as addresses and other pages write them, where the first surface's own fields stand beside `surfaces`.
import { defaultSurface, firstNames, type Settings, type WrittenSettings } from "./settings";
import { withSurface } from "./surfaces";

export function written({ surfaces: [{ dataset, error, ...first }, ...others], ...view }: Settings): WrittenSettings {
  const surfaces = error === null ? others : others.map((one) => ({ ...one, error: one.error ?? view.error }));
  return { ...view, ...first, surfaces, error: error ?? view.error, dataset: dataset || view.dataset };
}

// Returns the change of the settings that have these surfaces.
export function fromWritten(now: Pick<Settings, "surfaces">, { surfaces, ...change }: Partial<WrittenSettings>): Partial<Settings> {
  const fields = (isFirst: boolean) => Object.fromEntries(Object.entries(change).filter(([name]) => firstNames.includes(name) === isFirst));
  const before = surfaces ? { surfaces: [now.surfaces[0] ?? defaultSurface, ...surfaces] } : now;
  const after = withSurface(before, 0, fields(true));
  return { ...fields(false), ...(after.surfaces !== now.surfaces && after) };
}
