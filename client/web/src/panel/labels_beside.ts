// Selects the segmentation whose labels are shown beside the surfaces of an image.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { absentSegmentation, type Segmentation, segmentationsBeside, withSegmentation } from "../state/label_surfaces";
import type { Settings } from "../state/settings";
import type { Change } from "./panel_section";

export interface LabelsBeside {
  element: HTMLSelectElement; // Hidden if there is none to select.
  show: (list: readonly DatasetInfo[], settings: Settings, info: DatasetInfo | null) => void;
}

export function labelsBeside(change: Change): LabelsBeside {
  const element = h("select", {
    class: "select",
    "aria-label": "Labels beside the surfaces",
    "data-tip": "The segmentation whose labels are shown beside the surfaces.",
    change: () => now && change(withSegmentation(now.list, now.settings, offers.find(({ name }) => name === element.value) ?? null)),
  });
  let now: { list: readonly DatasetInfo[]; settings: Settings; info: DatasetInfo | null } | null = null;
  let offers: readonly Segmentation[] = [];
  return {
    element,
    show: (list, settings, info) => {
      const absent = info && absentSegmentation(list, settings);
      if (now?.list !== list || now.info !== info || now.settings.labels !== settings.labels) {
        offers = info ? segmentationsBeside(list, info) : [];
        element.replaceChildren(
          h("option", { value: "" }, "No labels"),
          ...offers.map(({ name, labels }) => h("option", { value: name }, `${name} (${labels.length})`)),
          ...(absent ? [h("option", { value: absent.name, disabled: "" }, absent.words)] : []),
        );
        element.hidden = offers.length === 0 && !absent;
      }
      now = { list, settings, info };
      const datasets = new Set(settings.surfaces.map(({ dataset }) => dataset));
      const shown = offers.find(({ labels }) => labels.some(({ name }) => datasets.has(name)));
      element.value = shown?.name ?? absent?.name ?? "";
    },
  };
}
