// The volume in the scene: its opacities by value. Colors are those of slices.
import type { DatasetInfo } from "../protocol/messages";
import { opacitiesOf, volumePresets } from "../scene/volume/opacities";
import type { ShownLevel } from "../scene/volume/volume";
import { button, chips, h } from "../shared/elements";
import { labelOf } from "../state/series";
import type { SurfaceSettings } from "../state/settings";
import { sampledOf } from "../surfaces/scene_at";
import { OpacityEditor } from "./opacity_editor";
import { type Change, noSamples, type PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export interface VolumePart extends PanelSection {
  showLevel: (level: ShownLevel | null) => void;
}

export function volumePart(change: Change): VolumePart {
  const controls = new SettingControls(change);
  const refusal = h("p", { class: "hint", hidden: true }, noSamples);
  const volume = controls.choice("volume", "Volume", "All samples at once, in one picture with the surfaces. Colors and window are those of slices.", {
    off: "Off",
    on: ["Opacities", "Each value has an opacity."],
    maximum: ["Maximum", "The largest value behind each pixel, up to opaque surfaces."],
  });
  const presets = chips("Presets");
  const editor = new OpacityEditor((opacities, isDragging) => change({ opacities }, isDragging));
  const shading = controls.toggle("volumeShading", "Shading", "Lights the volume by its gradients.");
  const labelsTip = "Samples of a label have its color, or are transparent if it is hidden, instead of surfaces of labels.";
  const labels = controls.choice("volumeLabels", "Labels", labelsTip, {
    off: "Off",
    color: ["Color", "Other samples have the colors of slices."],
    only: ["Only", "Other samples are transparent."],
  });
  const hint = h("p", { class: "hint" }, "An opaque surface hides what is behind it: make it translucent or hide it.");
  const detail = h("p", { class: "hint volume-detail", role: "status" });
  let known: DatasetInfo | null = null;
  const showPresets = (sampled: DatasetInfo) => {
    if (sampled === known) return;
    known = sampled;
    presets.replaceChildren(...volumePresets(sampled).map(({ name, tip, changes }) => button(name, () => change(changes), { "data-tip": tip })));
  };
  return {
    elements: [refusal, volume, presets, editor.element, shading, labels, detail, hint],
    show: ({ settings, info, list, permitsSamples }) => {
      controls.show(settings);
      const isOn = permitsSamples && info !== null && settings.volume !== "off";
      refusal.hidden = permitsSamples;
      volume.hidden = presets.hidden = !permitsSamples;
      editor.element.hidden = shading.hidden = !isOn || settings.volume !== "on";
      const isLabel = ({ dataset }: SurfaceSettings) => labelOf(list, dataset || settings.dataset) !== null;
      labels.hidden = shading.hidden || !settings.surfaces.some(isLabel) || sampledOf(list, settings, info!).member?.label !== undefined;
      const isDrawn = (one: SurfaceSettings) => labels.hidden || settings.volumeLabels === "off" || !isLabel(one);
      hint.hidden = !isOn || !settings.surfaces.some((one) => one.visible && one.opacity === 1 && isDrawn(one));
      if (!info) return;
      const sampled = sampledOf(list, settings, info);
      showPresets(sampled);
      if (isOn) editor.show(sampled, opacitiesOf(settings, sampled));
    },
    showLevel: (level) => {
      detail.textContent = level ? levelText(level) : "";
    },
  };
}

function levelText({ step, isLast }: ShownLevel): string {
  if (step === 1) return "All samples are shown.";
  const shown = `One in ${step} samples along each axis is shown`;
  return isLast ? `${shown}: more exceed the memory.` : `${shown}; finer ones follow.`;
}
