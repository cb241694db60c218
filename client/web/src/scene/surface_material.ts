// The materials of surfaces. The inside, visible at ends and cuts, has another color.
import * as THREE from "three";
import type { Material } from "../state/settings";
import type { FieldColors } from "./field_colors";
import { addPeeling } from "./translucency";

interface Finish {
  roughness: number;
  rim: [number, number, number]; // Light at grazing angles, as in skin.
  isMatcap: boolean; // Shaded by the normal in view space only, like a ball in a studio, to emphasize the shape.
}

const finishes: Record<Material, Finish> = {
  neutral: { roughness: 0.62, rim: [0, 0, 0], isMatcap: false },
  skin: { roughness: 0.5, rim: [0.42, 0.13, 0.07], isMatcap: false },
  bone: { roughness: 0.85, rim: [0.1, 0.09, 0.06], isMatcap: false },
  glossy: { roughness: 0.2, rim: [0, 0, 0], isMatcap: false },
  matcap: { roughness: 1, rim: [0, 0, 0], isMatcap: true },
};

const finishShader = /* glsl */ `
  float facing = saturate(dot(normal, geometryViewDir));
  outgoingLight += diffuseColor.rgb * finish.rgb * (1.0 - facing) * (1.0 - facing);
  if (finish.a > 0.0) {
    vec3 studio = normalize(vec3(-0.4, 0.5, 0.77));
    float lit = 0.5 + 0.5 * dot(normal, studio);
    float shine = pow(saturate(dot(normal, normalize(studio + geometryViewDir))), 36.0);
    outgoingLight = diffuseColor.rgb * mix(vec3(0.10, 0.11, 0.15), vec3(1.08, 1.05, 1.0), lit * lit) + 0.22 * shine;
  }
  #include <opaque_fragment>`;

export function setFinish(material: THREE.MeshStandardMaterial, name: Material): void {
  const { roughness, rim, isMatcap } = finishes[name];
  material.roughness = roughness;
  (material.userData.finish as THREE.Vector4).set(...rim, isMatcap ? 1 : 0);
}

// With `field`, vertices that have values of a second field show its colors.
export function surfaceMaterial(color: string, isTranslucent = false, field: FieldColors | null = null): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial({
    color: color,
    metalness: 0,
    side: THREE.DoubleSide,
    blending: isTranslucent ? THREE.NoBlending : THREE.NormalBlending,
    // Wireframes lie in front of their triangles; peeled surfaces are compared with their own
    // depth.
    polygonOffset: !isTranslucent,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
  material.userData.finish = new THREE.Vector4();
  setFinish(material, "neutral");
  material.onBeforeCompile = (shader) => {
    shader.uniforms.finish = { value: material.userData.finish };
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nuniform vec4 finish;")
      .replace("#include <opaque_fragment>", finishShader);
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <color_fragment>",
      "#include <color_fragment>\n" + "if (!gl_FrontFacing) diffuseColor.rgb = diffuseColor.rgb * vec3(0.62, 0.50, 0.47);",
    );
    field?.addToShader(shader);
    if (isTranslucent) addPeeling(shader);
  };
  material.customProgramCacheKey = () => `surface ${isTranslucent} ${field !== null}`;
  return material;
}
