// Bookmarked views, stored in this browser.

import { button, h } from "../shared/elements";
import type { Bookmarks } from "../state/bookmarks";

export interface BookmarksEvents {
  bookmarks: Bookmarks;
  currentAddress: () => string; // The address of the current view.
  visit: (address: string) => void;
}

export function bookmarksPart({ bookmarks, currentAddress, visit }: BookmarksEvents): HTMLElement[] {
  const list = h("ul", { class: "bookmarks" });
  const name = h("input", { type: "text", class: "bookmark-name", "aria-label": "Name of the bookmark", placeholder: "Name of this view", maxlength: "80" });
  const add = h("button", { type: "submit", class: "action" }, "Keep");
  const submit = (event: Event) => {
    event.preventDefault();
    bookmarks.add({ name: name.value.trim() || `View ${bookmarks.list().length + 1}`, address: currentAddress() });
    name.value = "";
    show();
  };
  const form = h("form", { class: "bookmark-form", submit }, name, add);
  const show = () =>
    list.replaceChildren(
      ...bookmarks.list().map(({ name: kept, address }) => {
        const forget = () => {
          bookmarks.remove(kept);
          show();
          name.focus();
        };
        const cross = button("×", forget, { class: "cross", "aria-label": `Forget ${kept}` });
        return h(
          "li",
          {},
          button(kept, () => visit(address), { class: "bookmark" }),
          cross,
        );
      }),
    );
  show();
  return [list, form];
}
