/** A field for the key, where the server asks for one. */
import { useRef } from "preact/hooks";
import { begin, isWanted, key } from "../api/key";

export function KeyField() {
  const field = useRef<HTMLInputElement>(null);
  if (!isWanted.value) return null;
  return (
    <form
      class="choice key"
      onSubmit={(event) => {
        event.preventDefault();
        begin(field.current?.value.trim() ?? "");
      }}
    >
      <label>
        <span>{key.value ? "Another key" : "Key"}</span>
        <input ref={field} type="password" aria-label="Key" autocomplete="off" required />
      </label>
      <button type="submit">Use</button>
    </form>
  );
}
