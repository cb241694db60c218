// Bookmarked views, stored in this browser.

import { h } from "../shared/elements";
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
  const form = h("form", { class: "bookmark-form" }, name, add);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const changes = name.value.trim() || `View ${bookmarks.list().length + 1}`;
    bookmarks.add({ name: changes, address: currentAddress() });
    name.value = "";
    show();
  });
  const show = () =>
    list.replaceChildren(
      ...bookmarks.list().map(({ name: changes, address }) => {
        const go = h("button", { type: "button", class: "bookmark" }, changes);
        go.addEventListener("click", () => visit(address));
        const cross = h("button", { type: "button", class: "cross", "aria-label": `Forget ${changes}` }, "×");
        cross.addEventListener("click", () => {
          bookmarks.remove(changes);
          show();
          name.focus();
        });
        return h("li", {}, go, cross);
      }),
    );
  show();
  return [list, form];
}
