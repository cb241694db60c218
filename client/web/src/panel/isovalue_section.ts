// The isovalues: lines in the histogram, the first one's number, and suggested values.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { roundedWithin } from "../shared/quantities";
import { tissueAtValue } from "../shared/sample_window";
import { persistentValues } from "../state/browser_storage";
import { hiddenPartsOf } from "../state/hidden_parts";
import { rangeOf } from "../state/series";
import type { Settings, SurfaceSettings } from "../state/settings";
import { withSurface } from "../state/surfaces";
import { suggestedIsovalue } from "../stream/request";
import { componentFilter } from "./component_filter";
import { HistogramView } from "./histogram";
import { toggle } from "./inputs";
import { numberInput } from "./number_input";
import type { Change, PanelSection } from "./panel_section";

export interface IsovaluePart extends PanelSection {
  histogram: HistogramView;
  showDatasets: (list: readonly DatasetInfo[]) => void;
}

export function isovaluePart(change: Change): IsovaluePart {
  const hasDragged = persistentValues.get("hasDragged") !== null; // The hint is not repeated.
  const hint = h("p", { class: "hint", hidden: hasDragged }, "Drag the line: the surface is where the data has this value.");
  let info: DatasetInfo | null = null;
  let list: readonly DatasetInfo[] = [];
  let settings: Settings;
  const histogram = new HistogramView({
    moved: (surface, isovalue, isDragging) => {
      hint.classList.add("is-read");
      histogram.invite(false);
      persistentValues.set("hasDragged", "yes");
      change(withSurface(settings, surface, { isovalue }), isDragging);
    },
  });
  const changeFirst = (changes: Partial<SurfaceSettings>) => change(withSurface(settings, 0, changes));
  const input = numberInput("Isovalue", (isovalue) => changeFirst({ isovalue }));
  const log = toggle({
    label: "log",
    tip: "Logarithmic heights, which show rare values.",
    onChange: (logScale) => change({ logScale }),
  });
  const filter = componentFilter("the surface", {
    hide: (minComponent) => changeFirst({ minComponent }),
    showHidden: () => changeFirst({ hiddenParts: [] }),
    keepLargest: (isOn) => changeFirst({ minComponent: isOn ? "largest" : 0 }),
  });
  const chips = h("div", { class: "chips", role: "group", "aria-label": "Suggested isovalues" });
  const chip = (value: number, of: DatasetInfo) => {
    const button = h(
      "button",
      { type: "button", "data-tip": "A suggested isovalue." },
      `${roundedWithin(value, of.max - of.min)} ${tissueAtValue(value, of)}`.trim(),
    );
    button.dataset.value = String(value);
    button.addEventListener("click", () => changeFirst({ isovalue: value }));
    return button;
  };
  return {
    histogram,
    elements: [h("div", { class: "section-head" }, h("h2", {}, "Isovalue"), input.element, log.element), histogram.element, chips, hint, filter.element],
    show: (now, shown) => {
      settings = now;
      log.show(now.logScale);
      filter.show(hiddenPartsOf(now.surfaces[0]));
      filter.element.hidden = now.surfaces.length > 1; // With several surfaces each has its own.
      if (!shown) return;
      const suggested = suggestedIsovalue(shown);
      const lines = now.surfaces.flatMap(({ isovalue, color, dataset }, surface) =>
        (dataset || shown.name) === shown.name ? [{ surface, isovalue: isovalue ?? suggested, color }] : [],
      );
      histogram.show(shown, lines, now.logScale, rangeOf(list, shown));
      if (shown !== info) {
        const values = shown.suggestedIsovalues.slice(0, 5).sort((a, b) => a - b);
        chips.replaceChildren(...(values.length > 1 ? values.map((value) => chip(value, shown)) : []));
        if (!info) histogram.invite(!hasDragged);
      }
      info = shown;
      const isovalue = now.surfaces[0].isovalue ?? suggested;
      for (const button of chips.querySelectorAll("button")) {
        button.setAttribute("aria-pressed", String(Number(button.dataset.value) === isovalue));
      }
      input.show(isovalue);
    },
    showDatasets: (now) => {
      list = now;
    },
  };
}
