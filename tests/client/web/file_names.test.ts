import { fileName, seriesName } from "../../../client/web/src/state/file_names";
import { member, plain } from "./made_datasets";

describe("FileName", () => {
  test("NamesTheDatasetAndTheIsovalue", () => {
    expect(fileName([{ info: plain("head"), isovalue: 500.5 }])).toBe("head_500.5");
    expect(fileName([{ info: plain("a/b: c"), isovalue: -1 }])).toBe("a-b-c_-1");
    expect(fileName([])).toBe("multitetra");
  });

  test("NamesSeriesFieldAndTime", () => {
    const info = member("jet@1", "jet", { field: "temperature", time: 0.25 });
    expect(fileName([{ info, isovalue: 300 }])).toBe("jet_temperature_0.25_300");
    expect(seriesName([{ info, isovalue: 300 }])).toBe("jet_temperature_300");
  });

  test("NamesTheOnlyLabelOrTheirSeries", () => {
    const [second, third] = ["left ventricle", ""].map((name, at) => ({
      info: member(`brain:${at}`, "brain", { label: { value: at + 2, name } }),
      isovalue: 0.5,
    }));
    expect(fileName([second])).toBe("brain_left-ventricle");
    expect(fileName([third])).toBe("brain_3");
    expect(fileName([second, third])).toBe("brain_labels");
  });
});
