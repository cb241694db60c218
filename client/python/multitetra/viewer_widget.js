// The viewer in a notebook: shows the server's page in a frame and maps its messages
// (client/web/EMBEDDING.md) to the state of a widget. viewer.py is the Python side.
//
// render() has anywidget's form: `model` has get, set, save_changes and on; render() returns a
// cleanup function.
function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.src = model.get("page");
  frame.title = "Multi-Tetra viewer";
  frame.allow = "fullscreen";
  frame.style.cssText = `width: 100%; height: ${model.get("height")}px; border: 0;`;
  el.appendChild(frame);
  const origin = new URL(frame.src, location.href).origin;
  let isListening = false; // Whether the frame has sent "ready".

  const save = (name, value) => {
    model.set(name, value);
    model.save_changes();
  };
  // Sends the settings that Python requests and that differ from the current ones.
  const sendSettings = () => {
    const now = model.get("settings");
    const other = Object.entries(model.get("wanted")).filter(
      ([name, value]) => JSON.stringify(value) !== JSON.stringify(now[name]),
    );
    if (isListening && other.length > 0) {
      frame.contentWindow.postMessage({ multitetra: "set", state: Object.fromEntries(other) }, origin);
    }
  };
  const hear = ({ source, origin: from, data }) => {
    if (source !== frame.contentWindow || from !== origin || !data) return;
    switch (data.multitetra) {
      case "ready":
        isListening = true;
        // From now on the frame reports its state.
        frame.contentWindow.postMessage({ multitetra: "get" }, origin);
        sendSettings();
        break;
      case "state":
        save("settings", data.state);
        if (data.ignored.length > 0) save("ignored", data.ignored);
        break;
      case "shown":
        save("shown", plain(data));
        break;
      case "picked":
        save("picks", [...model.get("picks"), plain(data)]);
        break;
    }
  };
  const plain = ({ multitetra, ...rest }) => rest;
  window.addEventListener("message", hear);
  model.on("change:wanted", sendSettings);
  return () => window.removeEventListener("message", hear);
}
