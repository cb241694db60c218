// The metadata of a prepared file as the description of a dataset. Its fields are those of the message under their names
// (common/dataset/dataset_fields.hpp), a few in shorter forms.
import { fromJson } from "@bufbuild/protobuf";

import { type DatasetInfo, DatasetInfoSchema, SampleType } from "../protocol/messages";

type Json = Record<string, unknown>;

const maxSide = 2 ** 19 + 1;

// Throws the end of a sentence about the metadata.
export function datasetInfo(metadata: unknown): DatasetInfo {
  const { member, label_volume: volume, ...json } = metadata as Json;
  const info = fromJson(
    DatasetInfoSchema,
    {
      ...json,
      type: named("SAMPLE_TYPE", json.type),
      space: named("WORLD_SPACE", json.space),
      geometry: named("GEOMETRY_BASIS", json.geometry),
      index_to_world: [json.index_to_world].flat(2),
      ...(member ? { member: memberOf(member as Json, (volume ?? {}) as Json) } : {}),
    } as Parameters<typeof fromJson>[1],
    { ignoreUnknownFields: true },
  );
  const { name, dims, spacing, type, indexToWorld, margin, gridExponent, histogram } = info;
  const isPlaced = indexToWorld.length === 12 && spacing.length === 3 && [...indexToWorld, ...spacing, info.min, info.max].every(Number.isFinite);
  const fits = dims.length === 3 && dims.every((n) => n >= 1 && n <= maxSide && n - 1 + 2 * margin <= 2 ** gridExponent);
  if (!name || type === SampleType.UNSPECIFIED || gridExponent < 1 || gridExponent > 19 || !isPlaced || !fits || !histogram) {
    throw new Error("it has no valid name, type, grid, placement or histogram");
  }
  return info;
}

// "i16" -> "SAMPLE_TYPE_I16"
function named(prefix: string, word: unknown): string {
  return `${prefix}_${word ? String(word).toUpperCase() : "UNSPECIFIED"}`;
}

function memberOf({ label, ...member }: Json, { samples, least, greatest, centroid }: Json): Json {
  const extent = least ? { box: [least, greatest].flat(), centroid } : {};
  return { ...withColor(member), ...(label ? { label: { ...withColor(label as Json), samples, ...extent } } : {}) };
}

// "#dd8265" -> 0xdd8265
function withColor(json: Json): Json {
  return json.color === undefined ? json : { ...json, color: Number.parseInt(String(json.color).slice(1), 16) };
}
