// The viewer in a notebook, in anywidget's form: render({ model, el }) returns a cleanup function. The viewer itself, a file of
// three megabytes, comes once from the kernel, by the widget's own messages, so that no notebook stores it.
// client/web/src/notebook/widget.ts has the rest, viewer.py is the Python side.
function render({ model, el }) {
  const wanted = "multitetra_viewer";
  let end = () => {};
  let isGone = false;
  const show = async (code, token) => {
    globalThis[wanted] ??= import(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
    const { default: viewer } = await globalThis[wanted];
    if (!isGone) end = viewer.render({ model, el, token });
  };
  const hear = (content, buffers) => {
    if (content.kind !== "code") return;
    model.off("msg:custom", hear);
    show(buffers[0], content.token).catch((problem) => (el.textContent = `The viewer was not loaded: ${problem}`));
  };
  model.on("msg:custom", hear);
  model.send({ kind: "code", isKnown: wanted in globalThis });
  return () => {
    isGone = true;
    model.off("msg:custom", hear);
    end();
  };
}
