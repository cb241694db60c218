// The metadata of a prepared file as the description of a dataset: the fields of common/dataset/dataset_fields.hpp.
import { create, type DatasetInfo, DatasetInfoSchema, GeometryBasis, WorldSpace } from "../protocol/messages";
import { sampleTypeOf } from "./sample_array";

type Json = Record<string, unknown>;

const maxSide = 2 ** 19 + 1;
const spaces: Record<string, WorldSpace> = { LPS: WorldSpace.LPS, RAS: WorldSpace.RAS };
const bases: Record<string, GeometryBasis> = { stated: GeometryBasis.STATED, partly: GeometryBasis.PARTLY, assumed: GeometryBasis.ASSUMED };

// Throws the end of a sentence about the metadata.
export function datasetInfo(metadata: unknown): DatasetInfo {
  const json = objectOf(metadata, "it");
  const type = sampleTypeOf(json.type);
  if (type === undefined) throw new Error('field "type" is not one of u8, i8, u16, i16, f32');
  const info = create(DatasetInfoSchema, {
    name: text(json, "name"),
    dims: numbers(json, "dims", 3),
    type,
    spacing: numbers(json, "spacing", 3),
    indexToWorld: list(json, "index_to_world").flat() as number[],
    min: number(json, "min"),
    max: number(json, "max"),
    voidSamples: BigInt(count(json, "void_samples")),
    outside: json.outside === null ? undefined : number(json, "outside"),
    margin: count(json, "margin"),
    gridExponent: count(json, "grid_exponent"),
    histogram: histogramOf(json),
    suggestedIsovalues: numbers(json, "suggested_isovalues"),
    space: spaces[String(json.space)],
    lengthUnit: text(json, "length_unit"),
    valueUnit: text(json, "value_unit"),
    member: json.member === undefined ? undefined : memberOf(objectOf(json.member, "member"), json.label_volume),
    displayWindow: json.display_window === undefined ? undefined : windowOf(objectOf(json.display_window, "display_window")),
    geometry: bases[String(json.geometry)],
    assumed: text(json, "assumed"),
    missing: text(json, "missing"),
  });
  const { name, dims, spacing, indexToWorld, margin, gridExponent } = info;
  const isMap = indexToWorld.length === 12 && indexToWorld.every(Number.isFinite);
  const fits = dims.every((n) => Number.isInteger(n) && n >= 1 && n <= maxSide && n - 1 + 2 * margin <= 2 ** gridExponent);
  if (!name || !isMap || !spacing.every((step) => step > 0) || gridExponent < 1 || gridExponent > 19 || !fits) {
    throw new Error("it has no valid name, grid or placement");
  }
  return info;
}

function histogramOf(json: Json): { low: number; high: number; counts: bigint[] } {
  const histogram = objectOf(json.histogram, "histogram");
  return { low: number(histogram, "low"), high: number(histogram, "high"), counts: numbers(histogram, "counts").map((n) => BigInt(Math.round(n))) };
}

function windowOf(json: Json): { low: number; high: number } {
  return { low: number(json, "low"), high: number(json, "high") };
}

function memberOf(json: Json, volume: unknown) {
  return {
    series: text(json, "series"),
    field: text(json, "field"),
    time: json.time === undefined ? undefined : number(json, "time"),
    timeUnit: text(json, "time_unit"),
    color: color(json),
    label: json.label === undefined ? undefined : labelOf(objectOf(json.label, "label"), volume),
  };
}

function labelOf(json: Json, volume: unknown) {
  const label = { value: number(json, "value"), name: text(json, "name"), color: color(json) };
  if (volume === undefined) return label;
  const extent = objectOf(volume, "label_volume");
  const samples = BigInt(count(extent, "samples"));
  if (extent.least === undefined) return { ...label, samples };
  return { ...label, samples, box: [...numbers(extent, "least", 3), ...numbers(extent, "greatest", 3)], centroid: numbers(extent, "centroid", 3) };
}

function color(json: Json): number | undefined {
  const found = /^#([0-9a-f]{6})$/i.exec(text(json, "color"));
  return found ? Number.parseInt(found[1], 16) : undefined;
}

function objectOf(value: unknown, name: string): Json {
  if (typeof value !== "object" || value === null || Array.isArray(value)) throw new Error(`${name} is not a JSON object`);
  return value as Json;
}

// Empty if it is absent.
function text(json: Json, key: string): string {
  const value = json[key] ?? "";
  if (typeof value !== "string") throw new Error(`field "${key}" is not a string`);
  return value;
}

function number(json: Json, key: string): number {
  const value = json[key];
  if (typeof value !== "number" || !Number.isFinite(value)) throw new Error(`field "${key}" is not a number`);
  return value;
}

function count(json: Json, key: string): number {
  const value = number(json, key);
  if (!Number.isInteger(value) || value < 0 || value > Number.MAX_SAFE_INTEGER) throw new Error(`field "${key}" is not a count`);
  return value;
}

function list(json: Json, key: string): unknown[] {
  const value = json[key];
  if (!Array.isArray(value)) throw new Error(`field "${key}" is not an array`);
  return value;
}

function numbers(json: Json, key: string, length?: number): number[] {
  const values = list(json, key);
  const isRight = values.every((value) => typeof value === "number" && Number.isFinite(value)) && (length ?? values.length) === values.length;
  if (!isRight) throw new Error(`field "${key}" does not have ${length ?? "only"} numbers`);
  return values as number[];
}
