// Selects a dataset in the same world as another one: fields of the same series first.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { type Entry, entriesOf, findByName, isSameSeries, memberOfField, seriesOf } from "../state/series";
import { worldDifference } from "../stream/dataset";

export interface DatasetSelect {
  element: HTMLSelectElement;
  // Offers the datasets and shows the chosen one; empty: none. Returns the number of datasets offered.
  show: (list: readonly DatasetInfo[], info: DatasetInfo | null, chosen: string) => number;
}

interface Offer {
  name: string; // The name of a dataset or of a series.
  words: string;
}

// `none`: the text of the first choice, no dataset. `isOffered`: which datasets are.
export function datasetSelect(
  label: string,
  none: string,
  onChange: (name: string) => void,
  isOffered: (one: DatasetInfo, info: DatasetInfo) => boolean = () => true,
): DatasetSelect {
  const element = h("select", { class: "select", "aria-label": label, change: () => onChange(element.value) });
  let offered = "";
  let shown: unknown[] = [];
  let count = 0;
  return {
    element,
    show: (...now) => {
      if (now.every((one, at) => one === shown[at])) return count;
      shown = now;
      const [list, info, name] = now;
      const { fields, others } = info ? offersFor(list, info, (one) => isOffered(one, info)) : { fields: [], others: [] };
      const chosen = chosenOf(list, info, name);
      const isUnknown = chosen !== "" && ![...fields, ...others].some((one) => one.name === chosen);
      const rest = isUnknown ? [...others, { name: chosen, words: chosen }] : others;
      const key = JSON.stringify([fields, rest]);
      if (key !== offered) {
        offered = key;
        element.replaceChildren(
          h("option", { value: "" }, none),
          ...group("Fields of the same series", fields),
          ...group(fields.length > 0 ? "Other datasets" : "Datasets", rest),
        );
      }
      element.value = chosen;
      return (count = fields.length + rest.length);
    },
  };
}

function group(label: string, offers: readonly Offer[]): HTMLElement[] {
  if (offers.length === 0) return [];
  return [h("optgroup", { label }, ...offers.map(({ name, words }) => h("option", { value: name }, words)))];
}

// A field is identified by its first time, so that names do not change with the time.
export function offersFor(list: readonly DatasetInfo[], info: DatasetInfo, isOffered: (one: DatasetInfo) => boolean): { fields: Offer[]; others: Offer[] } {
  const series = seriesOf(list, info);
  const fields = series && series.fields.length > 1 ? series.fields : [];
  return {
    fields: fields
      .map((field) => ({ info: firstOf(list, info, field), words: field || "(no name)" }))
      .filter((one) => isOffered(one.info))
      .map((one) => ({ name: one.info.name, words: one.words })),
    others: entriesOf(list)
      .filter((one) => isOffered(one.info) && worldDifference(info, one.info) === null && !(fields.length > 0 && isSameSeries(one.info, info)))
      .flatMap((one) => offersOf(list, one)),
  };
}

// Each field of a series.
function offersOf(list: readonly DatasetInfo[], { name, info, series }: Entry): Offer[] {
  if (!series || series.fields.length < 2) return [{ name, words: name }];
  return series.fields.map((field) => ({ name: firstOf(list, info, field).name, words: `${name}: ${field || "(no name)"}` }));
}

function firstOf(list: readonly DatasetInfo[], info: DatasetInfo, field: string): DatasetInfo {
  const series = seriesOf(list, info)!;
  const first = findByName(list, series.name)!;
  return memberOfField(series, first, field) ?? info;
}

// Returns the offer that matches the wanted dataset.
function chosenOf(list: readonly DatasetInfo[], info: DatasetInfo | null, wanted: string): string {
  const by = findByName(list, wanted);
  if (!wanted || !by || !info) return wanted;
  if (by.member && (seriesOf(list, by)?.fields.length ?? 0) > 1) return firstOf(list, by, by.member.field).name;
  return seriesOf(list, by)?.name ?? by.name;
}
