/** Name, looks, and the link to this state. */
import { useSignal } from "@preact/signals";
import type { Palette } from "../colour/maps";
import { link } from "../state/link";
import { palette, type Theme, theme } from "../state/preferences";
import { Icon } from "./icons";
import { KeyField } from "./KeyField";

export function Header() {
  return (
    <header class="top">
      <h1>
        <Mark /> sketchmatch
      </h1>
      <nav aria-label="Page">
        <KeyField />
        <CopyLink />
        <label class="choice">
          <span>Colours</span>
          <select
            value={palette.value}
            onChange={({ currentTarget: { value } }) => {
              palette.value = value as Palette;
            }}
          >
            <option value="hues">hues</option>
            <option value="safe">colour-blind safe</option>
          </select>
        </label>
        <label class="choice">
          <span>Theme</span>
          <select
            value={theme.value}
            onChange={({ currentTarget: { value } }) => {
              theme.value = value as Theme;
            }}
          >
            <option value="auto">system</option>
            <option value="light">light</option>
            <option value="dark">dark</option>
          </select>
        </label>
        <a href="/docs">API</a>
      </nav>
    </header>
  );
}

const Mark = () => (
  <svg class="brand" viewBox="0 0 32 32" aria-hidden="true">
    <path class="flat" d="M3 22C4 10 13 5 18 9" />
    <path class="round" d="M14 23c0-6 4-10 8-10s7 4 7 8-3 7-8 7-7-2-7-5z" />
  </svg>
);

function CopyLink() {
  const said = useSignal("");
  const copy = async () => {
    const address = await link();
    if (!address) {
      said.value = "There is nothing to link to yet";
      return;
    }
    history.replaceState(null, "", address);
    said.value = await navigator.clipboard.writeText(address).then(
      () => "Copied",
      () => "It is in the address bar",
    );
  };
  return (
    <>
      <span class="said" role="status">
        {said.value}
      </span>
      <button type="button" class="icon-button" onClick={copy} title="A link that opens the same state">
        <Icon name="link" />
        <span>Copy link</span>
      </button>
    </>
  );
}
