/** Which mesh is matched, and how it is looked at. */
import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import * as api from "../api/shapes";
import type { Example, MeshDocument } from "../api/types";
import { MESH_FILES } from "../drawing/files";
import { answer } from "../state/live";
import { examples, mesh, takeExample, takeFile, takeStored } from "../state/mesh";
import { lookAsDrawn } from "../view/camera";
import { FileButton, IconButton } from "./Button";
import { Icon } from "./icons";
import { Picture } from "./Picture";
import { named } from "./words";

export function MeshTools() {
  const dialog = useRef<HTMLDialogElement>(null);
  const stored = useSignal<MeshDocument[]>([]);
  const open = () => {
    dialog.current?.showModal();
    api.meshes(SHOWN).then(
      (meshes) => {
        stored.value = meshes;
      },
      () => {},
    );
  };
  return (
    <div class="tools" role="toolbar" aria-label="Mesh">
      <button type="button" class="icon-button chooser" onClick={open} aria-haspopup="dialog">
        <Icon name="mesh" />
        <span>{mesh.value ? named(mesh.value.document.name) : "Choose a mesh"}</span>
        <Icon name="down" />
      </button>
      <div class="group">
        <IconButton icon="view" label="See it as it is drawn" keys="V" disabled={!answer.value} onClick={lookAsDrawn} />
      </div>
      <FileButton
        icon="file"
        label="Open a mesh: OBJ, OFF, PLY, STL, GLB or glTF"
        accept={MESH_FILES}
        onFile={takeFile}
      >
        Open a mesh
      </FileButton>
      <dialog ref={dialog} class="meshes" aria-label="Choose a mesh">
        <Choice stored={stored.value} close={() => dialog.current?.close()} />
      </dialog>
    </div>
  );
}

/** Meshes of the server that are offered, the newest. */
const SHOWN = 12;
/** The width of their pictures, in pixels. */
const WIDTH = 240;

function Choice({ stored, close }: { stored: MeshDocument[]; close: () => void }) {
  const isExample = ({ name }: MeshDocument) => examples.value.some((example) => name === `${example.name}.obj`);
  const others = stored.filter((document) => !isExample(document));
  const takeAnd = (taking: Promise<void>) => {
    close();
    taking.catch(() => {});
  };
  return (
    <>
      <header>
        <h2>Choose a mesh</h2>
        <IconButton icon="close" label="Close" onClick={close} />
      </header>
      <ul class="gallery">
        {examples.value.map((example: Example) => (
          <li key={example.name}>
            <button type="button" onClick={() => takeAnd(takeExample(example))}>
              <Picture src={example.links.sketch} alt="" width={WIDTH / 2} height={WIDTH / 2} />
              <span>{named(example.name)}</span>
              <small>{example.description}</small>
            </button>
          </li>
        ))}
      </ul>
      {others.length > 0 && <h3>On this server</h3>}
      <ul class="gallery">
        {others.map(({ id, name, triangles }) => (
          <li key={id}>
            <button type="button" onClick={() => takeAnd(takeStored(id, name ?? id))}>
              <Picture src={api.meshPicture(id, WIDTH)} alt="" width={WIDTH / 2} height={WIDTH / 2} />
              <span>{name ?? "Mesh without a name"}</span>
              <small>{triangles.toLocaleString()} triangles</small>
            </button>
          </li>
        ))}
      </ul>
      <p class="hint">
        Your own: drop a file anywhere on the page, or press <em>Open a mesh</em>. OBJ, OFF, PLY, STL, GLB and glTF are
        read.
      </p>
    </>
  );
}
