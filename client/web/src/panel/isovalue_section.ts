// The isovalues: lines in the histogram, the first one's number, and suggested values.
import type { DatasetInfo } from "../protocol/messages";
import { button, chips, h } from "../shared/elements";
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
}

export function isovaluePart(change: Change): IsovaluePart {
  const hasDragged = persistentValues.get("hasDragged") !== null; // The hint is not repeated.
  const hint = h("p", { class: "hint", hidden: hasDragged }, "Drag the line: the surface is where the data has this value.");
  let info: DatasetInfo | null = null;
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
  const log = toggle("log", "Logarithmic heights, which show rare values.", (logScale) => change({ logScale }));
  const filter = componentFilter("the surface", {
    hide: (minComponent) => changeFirst({ minComponent }),
    showHidden: () => changeFirst({ hiddenParts: [] }),
    keepLargest: (isOn) => changeFirst({ minComponent: isOn ? "largest" : 0 }),
  });
  const suggestions = chips("Suggested isovalues");
  const suggestion = (value: number, of: DatasetInfo) => {
    const word = `${roundedWithin(value, of.max - of.min)} ${tissueAtValue(value, of)}`.trim();
    return button(word, () => changeFirst({ isovalue: value }), { "data-tip": "A suggested isovalue.", "data-value": String(value) });
  };
  return {
    histogram,
    elements: [h("div", { class: "section-head" }, h("h2", {}, "Isovalue"), input.element, log.element), histogram.element, suggestions, hint, filter.element],
    show: ({ settings: now, info: shown, list }) => {
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
        suggestions.replaceChildren(...(values.length > 1 ? values.map((value) => suggestion(value, shown)) : []));
        if (!info) histogram.invite(!hasDragged);
      }
      info = shown;
      const isovalue = now.surfaces[0].isovalue ?? suggested;
      for (const one of suggestions.querySelectorAll("button")) one.setAttribute("aria-pressed", String(Number(one.dataset.value) === isovalue));
      input.show(isovalue);
    },
  };
}
