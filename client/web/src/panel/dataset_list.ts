// The list of the server's datasets and series, with thumbnails and properties; one is selected.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { grouped, inDigits } from "../shared/quantities";
import type { Entry, Series } from "../state/series";
import { reservationsOf, sampleTypeName, valueText } from "../stream/dataset";

export class DatasetList {
  readonly element = h("div", { class: "datasets" });
  private readonly cards = new Map<string, HTMLElement>();
  private entries: readonly Entry[] = [];
  private readonly seen: IntersectionObserver;

  constructor(
    private readonly events: {
      chosen: (entry: Entry) => void;
      becameVisible: (name: string) => void; // Its thumbnail is needed.
      hasPictures: boolean; // Whether there are thumbnails.
    },
  ) {
    this.seen = new IntersectionObserver((entries) => {
      for (const { isIntersecting, target } of entries) {
        if (isIntersecting) this.events.becameVisible((target as HTMLElement).dataset.name!);
      }
    });
  }

  show(list: readonly Entry[]): void {
    this.entries = list;
    const atKeyboard = this.element.querySelector<HTMLElement>(":focus")?.dataset.name;
    this.cards.clear();
    this.seen.disconnect();
    const cards = list.map((entry) => this.card(entry));
    this.element.replaceChildren(...cards);
    if (list.length === 0) this.element.append(h("p", { class: "hint" }, "This server has no dataset yet."));
    for (const card of cards) this.seen.observe(card);
    if (atKeyboard !== undefined) this.cards.get(atKeyboard)?.focus({ preventScroll: true });
  }

  choose(info: DatasetInfo): void {
    const name = this.entries.find(({ info: own, series }) => own === info || series?.members.includes(info))?.name;
    for (const [other, card] of this.cards) {
      const isChosen = other === name;
      if (card.ariaPressed === String(isChosen)) continue;
      card.ariaPressed = String(isChosen);
      if (isChosen) card.scrollIntoView({ block: "nearest" }); // Lays out the page, which takes long with many labels.
    }
  }

  setPicture(name: string, address: string): void {
    this.cards.get(name)?.querySelector("img")?.setAttribute("src", address);
  }

  private card(entry: Entry): HTMLElement {
    const { info, name, series } = entry;
    const [x, y, z] = info.dims;
    const samples = x * y * z;
    const million = samples >= 1e6 ? `${inDigits(samples / 1e6, 3)} M` : grouped(samples);
    const card = h(
      "button",
      {
        type: "button",
        class: "dataset",
        "data-name": name,
        click: () => this.events.chosen(entry),
        "aria-pressed": "false",
        "data-tip":
          `${million} samples of type ${sampleTypeName(info.type)}, spacing ` +
          `${info.spacing.map((s) => inDigits(s, 3)).join(" × ")}, values ` +
          `${[`${valueText(info.min, info)} to ${valueText(info.max, info)}.`, ...reservationsOf(info)].join(" ")}`,
      },
      h("img", { alt: "", src: blank, width: "64", height: "48", hidden: !this.events.hasPictures }),
      h("span", { class: "dataset-name" }, name),
      h(
        "span",
        { class: "dataset-facts" },
        `${x} × ${y} × ${z} · ${series ? wordsOf(series) : sampleTypeName(info.type)}${info.assumed && ` · ${info.assumed} assumed`}${info.rounding && " · rounded"}${info.missing && ` · ${info.missing} to come`}`,
      ),
    );
    this.cards.set(name, card);
    return card;
  }
}

// "12 times, 2 fields".
function wordsOf({ times, fields, labels }: Series): string {
  const counts = [
    [times.length, "times"],
    [fields.length, "fields"],
    [labels.length, "labels"],
  ] as const;
  return counts
    .filter(([count]) => count > 1)
    .map(([count, noun]) => `${count} ${noun}`)
    .join(", ");
}

// A transparent pixel, until the thumbnail is loaded.
const blank = "data:image/gif;base64,R0lGODlhAQABAAAAACH5BAEKAAEALAAAAAABAAEAAAICTAEAOw==";
