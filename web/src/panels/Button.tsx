import type { ComponentChildren } from "preact";
import { Icon, type IconName } from "./icons";

interface Props {
  icon: IconName;
  /** What it does, read out and shown on hovering. */
  label: string;
  /** The key that does the same. */
  keys?: string;
  disabled?: boolean;
  pressed?: boolean;
  onClick: () => void;
  children?: ComponentChildren;
}

/** A button with a picture, and a word where there is room for one. */
export function IconButton({ icon, label, keys, disabled, pressed, onClick, children }: Props) {
  return (
    <button
      type="button"
      class="icon-button"
      title={keys ? `${label} (${keys})` : label}
      aria-label={label}
      aria-keyshortcuts={keys}
      aria-pressed={pressed}
      disabled={disabled}
      onClick={onClick}
    >
      <Icon name={icon} />
      {children && <span>{children}</span>}
    </button>
  );
}

interface FileProps {
  icon: IconName;
  label: string;
  accept: string;
  /** Asks for a photograph: shown where there is a touch screen. */
  isCamera?: boolean;
  onFile: (file: File) => void;
  children?: ComponentChildren;
}

/** A button that asks for a file. */
export function FileButton({ icon, label, accept, isCamera = false, onFile, children }: FileProps) {
  return (
    <label class={`icon-button ${isCamera ? "camera" : ""}`} title={label}>
      <Icon name={icon} />
      {children && <span>{children}</span>}
      <input
        type="file"
        class="hidden"
        accept={accept}
        {...(isCamera && { capture: "environment" })}
        aria-label={label}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          event.currentTarget.value = "";
          if (file) onFile(file);
        }}
      />
    </label>
  );
}
