// Settings as other pages write them, and surfaces, with defaults for what is not given.
import { defaultSurface, defaults, type Settings, type SurfaceSettings, type WrittenSettings } from "../../../client/web/src/state/settings";
import { fromWritten } from "../../../client/web/src/state/written_settings";

export function settingsFrom(given: Partial<WrittenSettings>): Settings {
  return { ...defaults, ...fromWritten(defaults, given) };
}

export function surface(fields: Partial<SurfaceSettings>): SurfaceSettings {
  return { ...defaultSurface, ...fields };
}
