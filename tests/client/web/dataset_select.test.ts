import { offersFor } from "../../../client/web/src/panel/dataset_select";
import { member, plain } from "./made_datasets";

const image = ["dapi", "membrane"].map((field) => member(`embryo.${field}`, "embryo", { field }));
const cells = [1, 2].map((value) => member(`cells.label${value}`, "cells", { label: { value, name: "" } }));
const list = [...image, ...cells, plain("other")];

describe("DatasetSelect", () => {
  test("OffersEveryFieldOfAnotherSeries", () => {
    const { fields, others } = offersFor(list, cells[0], ({ member }) => !member?.label);
    expect(fields).toEqual([]);
    expect(others).toEqual([
      { name: "embryo.dapi", words: "embryo: dapi" },
      { name: "embryo.membrane", words: "embryo: membrane" },
      { name: "other", words: "other" },
    ]);
  });

  test("OffersTheFieldsOfItsOwnSeriesFirst", () => {
    const { fields, others } = offersFor(list, image[0], () => true);
    expect(fields.map(({ words }) => words)).toEqual(["dapi", "membrane"]);
    expect(others.map(({ name }) => name)).toEqual(["cells", "other"]);
  });
});
