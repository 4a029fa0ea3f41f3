/** The tools of the sheet. */
import { EMPTY } from "../drawing/drawing";
import { DRAWING_FILES } from "../drawing/files";
import { landmarks } from "../state/corrections";
import { canRedo, canUndo, edit, nothingDrawn, redo, undo } from "../state/drawing";
import { take } from "../state/taking";
import { symmetric, type Tool, tool } from "../state/tools";
import { FileButton, IconButton } from "./Button";

const TOOLS = [
  { name: "pen", label: "Pen", keys: "P" },
  { name: "eraser", label: "Eraser", keys: "E" },
  { name: "landmark", label: "Landmarks: places that correspond", keys: "L" },
  { name: "pose", label: "Pose the mesh by handles", keys: "H" },
] as const;

export function SheetTools() {
  return (
    <div class="tools" role="toolbar" aria-label="Drawing">
      <div class="group">
        {TOOLS.map(({ name, label, keys }) => (
          <IconButton
            key={name}
            icon={name}
            label={label}
            keys={keys}
            pressed={tool.value === name}
            onClick={() => {
              tool.value = name as Tool;
            }}
          />
        ))}
        <IconButton
          icon="symmetric"
          label="Draw both sides alike"
          keys="S"
          pressed={symmetric.value}
          onClick={() => {
            symmetric.value = !symmetric.value;
          }}
        />
      </div>
      <div class="group">
        <IconButton icon="undo" label="Undo" keys="Control+Z" disabled={!canUndo.value} onClick={undo} />
        <IconButton icon="redo" label="Redo" keys="Control+Shift+Z" disabled={!canRedo.value} onClick={redo} />
        <IconButton icon="clear" label="Empty the sheet" disabled={nothingDrawn.value} onClick={clear} />
      </div>
      <FileButton icon="camera" label="Photograph a drawing" accept="image/*" isCamera onFile={take} />
      <FileButton
        icon="file"
        label="Open a drawing: SVG, picture, photograph or JSON"
        accept={DRAWING_FILES}
        onFile={take}
      >
        Open a drawing
      </FileButton>
    </div>
  );
}

function clear() {
  landmarks.value = [];
  edit(EMPTY);
}
