import { fileName, seriesName } from "../../../client/web/src/state/file_names";
import { member, plain } from "./made_datasets";

describe("FileName", () => {
  test("NamesTheDatasetAndTheIsovalue", () => {
    expect(fileName(plain("head"), 500.5)).toBe("head_500.5");
    expect(fileName(plain("a/b: c"), -1)).toBe("a-b-c_-1");
  });

  test("NamesSeriesFieldAndTime", () => {
    const info = member("jet@1", "jet", { field: "temperature", time: 0.25 });
    expect(fileName(info, 300)).toBe("jet_temperature_0.25_300");
    expect(seriesName(info, 300)).toBe("jet_temperature_300");
  });

  test("NamesLabelsInsteadOfIsovalues", () => {
    expect(fileName(member("brain:2", "brain", { label: { value: 2, name: "left ventricle" } }), 0.5)).toBe("brain_left-ventricle");
    expect(fileName(member("brain:3", "brain", { label: { value: 3, name: "" } }), 0.5)).toBe("brain_3");
  });
});
