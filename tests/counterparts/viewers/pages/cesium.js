// Shows a tileset in CesiumJS, anywhere on the globe. The token is in the address.
const { Cesium } = window;

const viewer = new Cesium.Viewer("globe", {
  ...Object.fromEntries(
    ["animation", "baseLayerPicker", "geocoder", "homeButton", "infoBox", "navigationHelpButton"]
      .concat(["sceneModePicker", "selectionIndicator", "timeline", "baseLayer", "globe", "skyBox", "skyAtmosphere"])
      .map((name) => [name, false]),
  ),
});
viewer.scene.backgroundColor = Cesium.Color.fromCssColorString("#223344");
viewer.scene.light = new Cesium.DirectionalLight({ direction: new Cesium.Cartesian3(-0.3, 1, -0.6) });
viewer.scene.screenSpaceCameraController.enableCollisionDetection = false;
viewer.camera.frustum.near = 0.01;

const failed = [];
let tileset = null;
let frames = 0; // Since the camera moved.
viewer.scene.postRender.addEventListener(() => (frames += 1));

window.counterpart = {
  async open(address) {
    tileset = await Cesium.Cesium3DTileset.fromUrl(address, { dynamicScreenSpaceError: false });
    tileset.modelMatrix = Cesium.Transforms.eastNorthUpToFixedFrame(Cesium.Cartesian3.fromDegrees(8, 50, 100));
    tileset.tileFailed.addEventListener(({ url, message }) => failed.push(`${url}: ${message}`));
    viewer.scene.primitives.add(tileset);
  },
  // Looks at the middle from `radii` radii of the whole away. `error` is the allowed screen-space error in pixels.
  look(radii, error) {
    const range = radii * tileset.boundingSphere.radius;
    const offset = new Cesium.HeadingPitchRange(0.4, -0.2, range);
    viewer.camera.flyToBoundingSphere(tileset.boundingSphere, { duration: 0, offset });
    tileset.maximumScreenSpaceError = error;
    frames = 0;
  },
  isBusy: () => frames < 5 || !tileset.tilesLoaded || tileset.statistics.numberOfTrianglesSelected === 0,
  facts: () => ({
    failed,
    tiles: tileset.statistics.selected,
    triangles: tileset.statistics.numberOfTrianglesSelected,
  }),
};
