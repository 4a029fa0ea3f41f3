/** The page: left the sheet, right the mesh, below what to know and to correct. */

import { useSignal } from "@preact/signals";
import { lazy, Suspense } from "preact/compat";
import { Alternatives } from "./panels/Alternatives";
import { IconButton } from "./panels/Button";
import { Choices } from "./panels/Choices";
import { Header } from "./panels/Header";
import { Landmarks } from "./panels/Landmarks";
import { Legend } from "./panels/Legend";
import { MeshTools } from "./panels/MeshTools";
import { SheetTools } from "./panels/SheetTools";
import { Start } from "./panels/Start";
import { Status } from "./panels/Status";
import { Understood } from "./panels/Understood";
import { named } from "./panels/words";
import { Sheet } from "./sheet/Sheet";
import { dismiss, meshState } from "./state/mesh";
import { untaken } from "./state/taking";
import { tool } from "./state/tools";
import { MeshView } from "./view/MeshView";

const Pose = lazy(() => import("./posing/Pose"));
const Inside = lazy(() => import("./inside/Inside"));

export function App() {
  return (
    <>
      <Header />
      <main>
        <div class="workbench">
          <section class="card" aria-label="Drawing">
            <SheetTools />
            <Untaken />
            <div class="area">
              <Sheet />
            </div>
            <div class="foot">
              <Start />
              <Understood />
            </div>
            <p id="sheet-keys" class="hidden">
              Arrows move a cross, Space puts the pen down and lifts it, Escape gives the stroke up.
            </p>
          </section>
          <section class="card" aria-label="Mesh">
            <MeshTools />
            <MeshState />
            <div class="area">
              <MeshView />
            </div>
            <div class="foot">
              <Legend />
            </div>
            <p id="mesh-keys" class="hidden">
              Arrows turn the mesh, plus and minus bring it nearer and farther. While landmarks are set arrows move a
              cross and Enter sets one.
            </p>
          </section>
        </div>
        {tool.value === "pose" && (
          <Suspense fallback={null}>
            <Pose />
          </Suspense>
        )}
        <Status />
        <div class="corrections">
          <Alternatives />
          <Landmarks />
          <Choices />
        </div>
        <LookInside />
      </main>
      <footer>
        <a href="/licences">Licences of what this page is made of</a>
      </footer>
    </>
  );
}

/** Fetched when it is opened. */
function LookInside() {
  const isOpen = useSignal(false);
  return (
    <details
      class="inside"
      onToggle={(event) => {
        isOpen.value = event.currentTarget.open;
      }}
    >
      <summary>Look inside</summary>
      {isOpen.value && (
        <Suspense fallback={<p class="hint">Opening…</p>}>
          <Inside />
        </Suspense>
      )}
    </details>
  );
}

function Untaken() {
  if (!untaken.value) return null;
  return (
    <Refused
      words={`${untaken.value}.`}
      dismiss={() => {
        untaken.value = null;
      }}
    />
  );
}

function MeshState() {
  const state = meshState.value;
  if (!state) return null;
  if ("refused" in state) return <Refused words={state.refused} dismiss={dismiss} />;
  return (
    <p class="progress" role="status">
      <span>Fetching {named(state.loading)}…</span>
      <progress aria-label="Fetching the mesh" />
    </p>
  );
}

function Refused({ words, dismiss }: { words: string; dismiss: () => void }) {
  return (
    <div class="trouble" role="alert">
      <p>{words}</p>
      <IconButton icon="close" label="Close" onClick={dismiss} />
    </div>
  );
}
