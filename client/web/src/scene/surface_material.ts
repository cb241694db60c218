// The shading of surfaces. The inside, visible where a surface ends or is cut, has another colour.
import * as THREE from "three";

import type { FieldColours } from "./field_colours";
import { peeled } from "./translucency";

// With `field` its colours are those of a second field, where vertices have its values.
export function surfaceMaterial(
  colour: string, isTranslucent = false, field: FieldColours | null = null,
): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial({
    color: colour,
    roughness: 0.62,
    metalness: 0,
    side: THREE.DoubleSide,
    blending: isTranslucent ? THREE.NoBlending : THREE.NormalBlending,
    // Wireframes lie before their triangles; what is peeled is compared with its own depth.
    polygonOffset: !isTranslucent,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <color_fragment>",
      "#include <color_fragment>\n" +
        "if (!gl_FrontFacing) diffuseColor.rgb = diffuseColor.rgb * vec3(0.62, 0.50, 0.47);",
    );
    field?.enter(shader);
    if (isTranslucent) peeled(shader);
  };
  material.customProgramCacheKey = () => `surface ${isTranslucent} ${field !== null}`;
  return material;
}
