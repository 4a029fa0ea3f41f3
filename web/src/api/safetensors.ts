/** Arrays as the server sends them in the format safetensors: the length of a JSON header, the header, the numbers. */

const KINDS = { F32: Float32Array, F64: Float64Array };

type Numbers = Float32Array<ArrayBuffer> | Float64Array<ArrayBuffer>;

interface Entry {
  dtype: keyof typeof KINDS;
  data_offsets: [number, number];
}

/** The arrays of a file by their names, each by rows. */
export function arrays(file: ArrayBuffer): Record<string, Numbers> {
  const length = Number(new DataView(file).getBigUint64(0, true));
  const { __metadata__, ...header } = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 8, length)));
  const read = ({ dtype, data_offsets: [start, end] }: Entry) =>
    new KINDS[dtype](file.slice(8 + length + start, 8 + length + end));
  return Object.fromEntries(
    Object.entries(header as Record<string, Entry>).map(([name, entry]) => [name, read(entry)]),
  );
}
