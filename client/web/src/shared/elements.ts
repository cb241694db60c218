// Creates DOM elements in one expression.
type Child = Node | string | null;
type Attributes = Record<string, string | boolean | ((event: never) => void)>; // Functions listen to the event of that name.

export function h<K extends keyof HTMLElementTagNameMap>(tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") {
      element.addEventListener(name, value as unknown as EventListener);
    } else if (value === true) element.setAttribute(name, "");
    else if (value !== false) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

export function button(word: string, click: () => void, attributes: Attributes = {}): HTMLButtonElement {
  return h("button", { type: "button", click, ...attributes }, word);
}

// A row of buttons.
export function chips(label: string, ...buttons: HTMLElement[]): HTMLElement {
  return h("div", { class: "chips", role: "group", "aria-label": label }, ...buttons);
}
