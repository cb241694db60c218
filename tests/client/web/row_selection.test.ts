import { RowSelection } from "../../../client/web/src/panel/row_selection";

describe("RowSelection", () => {
  const order = [..."abcdef"];
  const selectionOf = () => {
    const selection = new RowSelection(() => {});
    return { selection, selected: () => order.filter((key) => selection.has(key)).join("") };
  };

  test("SelectsOneRowAndTogglesOthers", () => {
    const { selection, selected } = selectionOf();
    selection.select("b");
    selection.toggle("d");
    expect(selected()).toBe("bd");
    selection.toggle("b");
    expect(selected()).toBe("d");
    selection.select("a");
    expect(selected()).toBe("a");
  });

  test("ExtendsFromTheRowSelectedLast", () => {
    const { selection, selected } = selectionOf();
    selection.extend("c", order);
    expect(selected()).toBe("c");
    selection.extend("e", order);
    expect(selected()).toBe("cde");
    selection.extend("a", order);
    expect(selected()).toBe("abc");
    selection.toggle("e");
    selection.extend("f", order);
    expect(selected()).toBe("ef");
  });

  test("ExtendsFromTheFocusedRowIfNoneIsSelected", () => {
    const { selection, selected } = selectionOf();
    selection.extend("d", order, "c");
    expect(selected()).toBe("cd");
    selection.extend("e", order, "d");
    expect(selected()).toBe("cde");
  });

  test("SelectsOneRowIfTheLastSelectedOneIsNotListed", () => {
    const { selection, selected } = selectionOf();
    selection.select("b");
    selection.extend("e", ["d", "e", "f"]);
    expect(selected()).toBe("e");
    selection.extend("f", ["d", "e", "f"]);
    expect(selected()).toBe("ef");
  });

  test("ReportsWhetherAnythingWasCleared", () => {
    const { selection, selected } = selectionOf();
    expect(selection.clear()).toBe(false);
    selection.selectAll(["a", "f"]);
    expect(selected()).toBe("af");
    expect(selection.clear()).toBe(true);
    expect(selected()).toBe("");
  });
});
