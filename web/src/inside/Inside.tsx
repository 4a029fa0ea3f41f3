/** What the method did, and every knob of it. */
import { useSignal } from "@preact/signals";
import type { ComponentType } from "preact";
import { Compare } from "./Compare";
import { Evaluation } from "./Evaluation";
import { Functions } from "./Functions";
import { HeatMaps } from "./HeatMap";
import { Objective } from "./Objective";
import { Request } from "./Request";
import { Settings } from "./Settings";
import { Timings } from "./Timings";
import "./inside.css";

const TABS: Record<string, ComponentType> = {
  Settings,
  "Presets side by side": Compare,
  "Functional map": HeatMaps,
  Objective,
  "Regions and eigenfunctions": Functions,
  Evaluation,
  Times: Timings,
  Request,
};

const NAMES = Object.keys(TABS);

export default function Inside() {
  const shown = useSignal("Settings");
  const Tab = TABS[shown.value] ?? Settings;
  const onKey = (event: KeyboardEvent) => {
    const way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!way) return;
    event.preventDefault();
    const next = NAMES[(NAMES.indexOf(shown.value) + way + NAMES.length) % NAMES.length] as string;
    shown.value = next;
    document.getElementById(`tab-${NAMES.indexOf(next)}`)?.focus();
  };
  return (
    <>
      <div class="tabs" role="tablist" aria-label="Look inside">
        {NAMES.map((name, i) => (
          <button
            key={name}
            id={`tab-${i}`}
            type="button"
            role="tab"
            aria-selected={name === shown.value}
            aria-controls="tab-panel"
            tabIndex={name === shown.value ? 0 : -1}
            onKeyDown={onKey}
            onClick={() => {
              shown.value = name;
            }}
          >
            {name}
          </button>
        ))}
      </div>
      <div id="tab-panel" class="tab-panel" role="tabpanel" aria-labelledby={`tab-${NAMES.indexOf(shown.value)}`}>
        <Tab key={shown.value} />
      </div>
    </>
  );
}
