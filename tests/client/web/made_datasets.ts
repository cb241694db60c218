// Dataset descriptions as a server sends them.
import { create, type DatasetInfo, DatasetInfoSchema, SeriesMemberSchema } from "../../../client/web/src/protocol/messages";

export function plain(name: string): DatasetInfo {
  return create(DatasetInfoSchema, { name, dims: [9, 9, 9], spacing: [1, 1, 1], min: 0, max: 1, gridExponent: 4 });
}

interface MemberFields {
  field?: string;
  time?: number;
  timeUnit?: string;
  color?: number;
  label?: { value: number; name: string; color?: number };
}

export function member(name: string, series: string, overrides: MemberFields): DatasetInfo {
  return { ...plain(name), member: create(SeriesMemberSchema, { series, ...overrides }) };
}
