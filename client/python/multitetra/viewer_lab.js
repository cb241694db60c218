// The viewer's part of JupyterLab and Notebook 7, after viewer_widget.js: a module as their loader wants it, with one plugin. It
// gives the widget's view to ipywidgets, whose own module is in the scope that all modules share.
{
  const name = "multitetra_viewer";
  // Of several versions, the newest is what everybody gets.
  const shared = async (versions) => {
    const newest = Object.keys(versions).sort((a, b) => a.localeCompare(b, undefined, { numeric: true })).at(-1);
    return (await versions[newest].get())();
  };
  let scope = {};
  globalThis._JUPYTERLAB ??= {};
  globalThis._JUPYTERLAB[name] = {
    init(given) {
      scope = given;
    },
    async get() {
      if (!scope["@jupyter-widgets/base"]) throw new Error("The viewer needs ipywidgets 8 with its part of JupyterLab.");
      const { DOMWidgetView, IJupyterWidgetRegistry } = await shared(scope["@jupyter-widgets/base"]);
      class ViewerView extends DOMWidgetView {
        render() {
          this.end = render({ model: this.model, el: this.el });
        }
        remove() {
          this.end();
          return super.remove();
        }
      }
      const plugin = {
        id: `${name}:plugin`,
        autoStart: true,
        requires: [IJupyterWidgetRegistry],
        activate: (_, registry) => registry.registerWidget({ name, version: "1.0.0", exports: { ViewerView } }),
      };
      return () => ({ __esModule: true, default: plugin });
    },
  };
}
