// Types for the part of Draco's decoder that the viewer uses; the package has none.
declare module "draco3d" {
  interface Status {
    ok(): boolean;
    error_msg(): string;
  }
  interface Mesh {
    num_points(): number;
    num_faces(): number;
  }
  type Attribute = object;
  interface Decoder {
    DecodeArrayToMesh(bytes: Int8Array, length: number, mesh: Mesh): Status;
    GetAttributeId(mesh: Mesh, kind: number): number;
    GetAttribute(mesh: Mesh, id: number): Attribute;
    GetAttributeDataArrayForAllPoints(mesh: Mesh, attribute: Attribute, type: number, bytes: number, pointer: number): boolean;
    GetTrianglesUInt32Array(mesh: Mesh, bytes: number, pointer: number): boolean;
  }
  interface DecoderModule {
    Decoder: new () => Decoder;
    Mesh: new () => Mesh;
    POSITION: number;
    NORMAL: number;
    DT_INT32: number;
    DT_FLOAT32: number;
    HEAPF32: Float32Array;
    _malloc(bytes: number): number;
    _free(pointer: number): void;
    destroy(object: object): void;
  }
}

declare module "draco3d/draco_decoder_nodejs.js" {
  const createDecoderModule: (options: {
    wasmBinary?: ArrayBuffer;
    instantiateWasm?: (imports: WebAssembly.Imports, receive: (instance: WebAssembly.Instance) => void) => object;
    locateFile?: (name: string) => string;
  }) => Promise<import("draco3d").DecoderModule>;
  export default createDecoderModule;
}
