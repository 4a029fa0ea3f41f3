/** Puts the page together and follows what is done on it. */
import { render } from "preact";
import { App } from "./App";
import * as api from "./api/shapes";
import { Away, words } from "./api/trouble";
import { named } from "./panels/words";
import { keep, kept, restore } from "./state/keep";
import { linked } from "./state/link";
import { live } from "./state/live";
import { examples, mesh, meshState, takeExample, takeStored } from "./state/mesh";
import { applyTheme } from "./state/preferences";
import { followRest } from "./state/rested";
import { shortcuts } from "./state/shortcuts";
import { take } from "./state/taking";
import { followViews } from "./view/camera";
import "./style/tokens.css";
import "./style/page.css";
import "./style/controls.css";
import "./style/sheet.css";
import "./style/panels.css";

applyTheme();
render(<App />, document.getElementById("page") as HTMLElement);
shortcuts();
takeDropped();
followViews();
followRest();
void resume();

/** Opens what the address or the browser kept, else the first example; tried again while the server is away. */
async function resume() {
  const state = (await linked()) ?? (await kept());
  if (state) restore(state);
  live();
  const wanted = state?.mesh ?? null;
  for (let rest = 1000; !mesh.value; rest = Math.min(2 * rest, 15_000)) {
    const isHad = await firstMesh(wanted).then(
      () => true,
      (error) => !(error instanceof Away),
    );
    if (isHad) break;
    await new Promise((resolve) => setTimeout(resolve, rest));
  }
  keep();
}

async function firstMesh(wanted: { id: string; name: string } | null) {
  try {
    examples.value = await api.examples();
  } catch (error) {
    meshState.value = { refused: `${words(error)}${error instanceof Away ? " Trying again." : ""}` };
    throw error;
  }
  if (wanted && (await isThere(wanted))) return;
  const [first] = examples.value;
  if (first) await takeExample(first);
  if (wanted)
    meshState.value = { refused: `${named(wanted.name)} is not on this server any more: this is an example.` };
}

/** Takes a mesh of before, if the server still has it. */
const isThere = ({ id, name }: { id: string; name: string }) =>
  takeStored(id, name).then(
    () => true,
    (error) => {
      if (error instanceof Away) throw error;
      return false;
    },
  );

/** Takes files that are dropped anywhere on the page. */
function takeDropped() {
  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dragged-over");
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) document.body.classList.remove("dragged-over");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dragged-over");
    for (const file of event.dataTransfer?.files ?? []) void take(file);
  });
}
