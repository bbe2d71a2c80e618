// The WebAssembly module, called with text and bytes; the same in a worker and in Node.

/** The module out of its bytes or a response; `now` reads milliseconds. */
export async function load(source, now = () => performance.now()) {
  let memory;
  const text = (at, length) => new TextDecoder().decode(new Uint8Array(memory.buffer, at, length));
  const host = {
    now_ms: now,
    panicked: (at, length) => console.error(text(at, length)),
  };
  // Not streaming: that needs a server which knows the media type of a module.
  const bytes = source instanceof Response ? await source.arrayBuffer() : source;
  const { instance } = await WebAssembly.instantiate(bytes, { host });
  const { exports } = instance;
  memory = exports.memory;

  /** Hands over text, bytes or what becomes JSON, calls `name`, and returns its text; throws what the module calls wrong. */
  return (name, given, ...numbers) => {
    if (given !== undefined) {
      const bytes = given instanceof Uint8Array ? given : new TextEncoder().encode(typeof given === "string" ? given : JSON.stringify(given));
      const at = exports.input(bytes.length);
      new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
    }
    const length = exports[name](...numbers);
    const answer = text(exports.output(), Math.abs(length));
    if (length < 0) throw new Error(answer);
    return answer;
  };
}
