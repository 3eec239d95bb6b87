/**
 * Messages between page and server, the same both ways: a JSON header and arrays, as bytes.
 *
 * The length of the header as a little-endian 32-bit number, the header in UTF-8, then the arrays,
 * each from a multiple of 8 bytes on. The header's `arrays` says what they are, in order:
 * `[[name, dtype, shape], ...]`. Arrays that were decoded are views of the bytes: nothing is copied.
 */

const kinds = {
  f4: Float32Array,
  f8: Float64Array,
  u4: Uint32Array,
  i4: Int32Array,
  u2: Uint16Array,
  u1: Uint8Array,
} as const;

type Dtype = keyof typeof kinds;
export type NumberArray = InstanceType<(typeof kinds)[Dtype]>;

export type Header = Record<string, unknown>;
/** Arrays to be sent: flat ones as they are, others with their shape. */
export type Arrays = Record<string, NumberArray | { values: NumberArray; shape: number[] }>;

export interface Message<H = Header> {
  header: H;
  /** By name, flattened in the order of C. */
  arrays: Record<string, NumberArray>;
  shapes: Record<string, number[]>;
}

const padded = (size: number) => (size + 7) & ~7;

/** The bytes of a message. */
export function encode(header: Header, arrays: Arrays = {}): ArrayBuffer {
  const given = Object.entries(arrays).map(([name, array]) => {
    const values = "values" in array && "shape" in array ? array.values : (array as NumberArray);
    const shape = values === array ? [values.length] : (array as { shape: number[] }).shape;
    return { name, values, shape };
  });
  const table = given.map(({ name, values, shape }) => [name, dtypeOf(values), shape]);
  const text = new TextEncoder().encode(JSON.stringify({ ...header, arrays: table }));
  const first = padded(4 + text.length);
  const size = given.reduce((sum, { values }) => sum + padded(values.byteLength), first);
  const bytes = new Uint8Array(size);
  new DataView(bytes.buffer).setUint32(0, text.length, true);
  bytes.set(text, 4);
  let start = first;
  for (const { values } of given) {
    bytes.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), start);
    start += padded(values.byteLength);
  }
  return bytes.buffer;
}

/** The message in these bytes; throws where they are none. */
export function decode<H = Header>(bytes: ArrayBuffer): Message<H> {
  if (bytes.byteLength < 4) throw new Error("a message has at least 4 bytes");
  const length = new DataView(bytes).getUint32(0, true);
  if (4 + length > bytes.byteLength) throw new Error("a message's header ends beyond its bytes");
  const text = new TextDecoder().decode(new Uint8Array(bytes, 4, length));
  const { arrays: table = [], ...header } = JSON.parse(text);
  const message: Message<H> = { header, arrays: {}, shapes: {} };
  let start = padded(4 + length);
  for (const [name, dtype, shape] of table as [string, Dtype, number[]][]) {
    const Kind = kinds[dtype];
    const count = shape.reduce((product, n) => product * n, 1);
    if (!Kind || start + count * Kind.BYTES_PER_ELEMENT > bytes.byteLength)
      throw new Error(`array ${name} of a message is not all there`);
    // an empty array may begin behind the end, where there is nothing to view
    message.arrays[name] = count ? new Kind(bytes, start, count) : new Kind(0);
    message.shapes[name] = shape;
    start += padded(count * Kind.BYTES_PER_ELEMENT);
  }
  return message;
}

function dtypeOf(values: NumberArray): Dtype {
  for (const [dtype, Kind] of Object.entries(kinds))
    if (values instanceof Kind) return dtype as Dtype;
  throw new Error("an array of a type that messages do not have");
}
