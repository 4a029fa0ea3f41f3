/** The mesh posed by the drawing: handles, the pose of a drawing, frames, and what is saved of them. */
import { useEffect } from "preact/hooks";
import { DRAWING_FILES } from "../drawing/files";
import { FileButton } from "../panels/Button";
import { handles, isPlacing, removeAll, setSome } from "../state/handles";
import { type Answer, chosen, finalAnswer } from "../state/live";
import { blend, held, unheld } from "./blend";
import { pause } from "./playing";
import { save, saving } from "./saving";
import { Timeline } from "./Timeline";
import { followAnswer, giveBack, taken, takeOther, takeOwn, taking } from "./taken";
import "./pose.css";

export default function Pose() {
  useEffect(() => {
    // What is posed is the answer itself.
    chosen.value = null;
    const ends = [followAnswer(), blend(), pause];
    return () => {
      for (const end of ends) end();
    };
  }, []);
  const answer = finalAnswer.value;
  return (
    <section class="panel pose" aria-labelledby="pose">
      <h2 id="pose">Pose the mesh</h2>
      {answer ? <Posing answer={answer} /> : <p class="hint">The drawing has to be matched first.</p>}
    </section>
  );
}

function Posing({ answer }: { answer: Answer }) {
  return (
    <>
      <div class="row">
        {taken.value ? (
          <button type="button" onClick={giveBack}>
            Back to the handles
          </button>
        ) : (
          <Modes answer={answer} />
        )}
        <span class="row taking">
          <button type="button" onClick={() => takeOwn(answer)}>
            Stand as drawn
          </button>
          <FileButton
            icon="file"
            label="Take the pose of another drawing"
            accept={DRAWING_FILES}
            onFile={(file) => takeOther(answer, file)}
          >
            As another drawing
          </FileButton>
        </span>
      </div>
      <State />
      {!taken.value && handles.value.length > 0 && <Timeline />}
      <Saving answer={answer} />
    </>
  );
}

function Modes({ answer }: { answer: Answer }) {
  const isEmpty = handles.value.length === 0;
  return (
    <>
      <div class="group" role="group" aria-label="What the pointer does to handles">
        <Mode of={true} name="Set handles" />
        <Mode of={false} name="Move them" disabled={isEmpty} />
      </div>
      {isEmpty ? (
        <button type="button" onClick={() => setSome(answer.reading.flat)}>
          Set some for me
        </button>
      ) : (
        <button type="button" onClick={removeAll}>
          Remove all
        </button>
      )}
    </>
  );
}

function Mode({ of, name, disabled }: { of: boolean; name: string; disabled?: boolean }) {
  return (
    <button
      type="button"
      aria-pressed={isPlacing.value === of}
      disabled={disabled}
      onClick={() => {
        pause();
        isPlacing.value = of;
      }}
    >
      {name}
    </button>
  );
}

/** What is to be done or waited for, in words. */
function State() {
  const trouble = [taking.value, saving.value].find((state) => state && "refused" in state);
  if (trouble && "refused" in trouble) return <Trouble words={trouble.refused} />;
  if (taking.value && "from" in taking.value) return <Progress words={`Taking the pose of ${taking.value.from}`} />;
  if (taken.value)
    return (
      <p class="hint" role="status">
        The mesh stands as {taken.value.name} shows it.
      </p>
    );
  if (unheld.value) return <Trouble words={unheld.value} />;
  if (handles.value.length > 0 && !held.value) return <Progress words="Finding out what the handles hold" />;
  return (
    <p class="hint" role="status">
      {isPlacing.value
        ? "Click a place of the drawing to hold it there, or drag a line for a bone. One handle moves all, two bend."
        : "Drag a handle and the mesh follows; its tip turns it."}
    </p>
  );
}

const Trouble = ({ words }: { words: string }) => (
  <p class="trouble" role="alert">
    {words}
  </p>
);

const Progress = ({ words }: { words: string }) => (
  <p class="progress" role="status">
    <span>{words}…</span>
    <progress aria-label={words} />
  </p>
);

const FORMATS = [
  { format: "glb", label: "GLB", title: "All frames as an animation" },
  { format: "obj", label: "OBJ", title: "This frame as your own file with its vertices moved" },
  { format: "png", label: "PNG", title: "A picture of this frame" },
] as const;

function Saving({ answer }: { answer: Answer }) {
  const isBusy = saving.value !== null && "format" in saving.value;
  const isThere = taken.value !== null || held.value !== null;
  return (
    <div class="row" role="group" aria-label="Save the pose">
      <span class="hint">Save as</span>
      {FORMATS.map(({ format, label, title }) => (
        <button
          key={format}
          type="button"
          title={title}
          disabled={isBusy || !isThere}
          onClick={() => save(answer, format)}
        >
          {label}
        </button>
      ))}
      {isBusy && <progress aria-label="Making the file" />}
    </div>
  );
}
