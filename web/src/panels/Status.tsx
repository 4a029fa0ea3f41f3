/** How far the match is, how far it is to be trusted, and what is missing. */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { sentence, told } from "../api/trouble";
import { unit, withStrokes } from "../drawing/drawing";
import { bridges } from "../drawing/stroke";
import { drawing, edit, nothingDrawn } from "../state/drawing";
import { again, answer, reading, type Stage, stage, takeLines } from "../state/live";
import { mesh } from "../state/mesh";
import { RATINGS, readingWarnings, reasons, STAGES } from "./words";

export function Status() {
  return (
    <section class="status" aria-label="State of the match">
      <div role="status">{!nothingDrawn.value && <Now now={stage.value} />}</div>
      {answer.value && <Rated />}
      <Notes />
    </section>
  );
}

function Now({ now }: { now: Stage }) {
  switch (now.kind) {
    case "idle":
      return mesh.value ? null : <p>Choose a mesh to match the drawing to.</p>;
    case "reading":
      return <Progress words="Reading the drawing" fraction={null} />;
    case "waiting":
      return <Progress words={`Waiting: number ${now.place} in the queue`} fraction={null} />;
    case "matching":
      return <Progress words={STAGES[now.stage] ?? now.stage} fraction={now.fraction} />;
    case "open":
      return (
        <p class={`trouble ${drawing.value.ground ? "" : "open"}`}>
          {now.words}
          <Close />
          {now.isTaken && (
            <button type="button" onClick={takeLines}>
              Match the lines as they are
            </button>
          )}
        </p>
      );
    case "refused":
      return (
        <div class="trouble" role="alert">
          <p>{now.words}</p>
          {now.faults.length > 1 && (
            <ul>
              {now.faults.map((fault) => (
                <li key={`${fault.pointer ?? fault.place}${fault.detail}`}>{told(fault)}</li>
              ))}
            </ul>
          )}
        </div>
      );
    case "away":
      return <Away words={now.words} until={now.until} />;
    case "done":
      return null;
  }
}

/** Closes an outline by straight lines between its loose ends. */
function Close() {
  const { strokes, frame } = drawing.value;
  const lines = bridges(strokes, unit(frame));
  if (lines.length === 0) return null;
  return (
    <button type="button" onClick={() => edit(withStrokes(drawing.value, [...strokes, ...lines]))}>
      Close it for me
    </button>
  );
}

function Progress({ words, fraction }: { words: string; fraction: number | null }) {
  return (
    <p class="progress">
      <span>{words}…</span>
      {fraction === null ? <progress aria-label={words} /> : <progress aria-label={words} value={fraction} max={1} />}
    </p>
  );
}

/** Counts the seconds to the next try. */
function Away({ words, until }: { words: string; until: number }) {
  const now = useSignal(Date.now());
  useEffect(() => {
    const timer = setInterval(() => {
      now.value = Date.now();
    }, 500);
    return () => clearInterval(timer);
  }, []);
  const seconds = Math.max(0, Math.ceil((until - now.value) / 1000));
  return (
    <p class="trouble">
      {words} {seconds > 0 ? `Trying again in ${seconds} s.` : "Trying again."}
      <button type="button" onClick={again}>
        Try now
      </button>
    </p>
  );
}

function Rated() {
  const result = answer.value?.result;
  if (!result) return null;
  const { preview, rating, confidence } = result;
  const isPast = answer.value?.reading.of !== drawing.value;
  if (preview)
    return (
      <div class={`rated ${isPast ? "past" : ""}`}>
        <strong class="rating">First sight</strong>
        <span>The best view of the mesh as it stands. Other poses of it are tried now.</span>
      </div>
    );
  return (
    <div class={`rated ${isPast ? "past" : ""}`}>
      {rating ? (
        <>
          <strong class={`rating ${rating}`}>{RATINGS[rating].title}</strong>
          <span>
            {reasons(result).join(" ")} {RATINGS[rating].meaning}
          </span>
        </>
      ) : (
        <>
          <strong class="rating">Confidence {confidence.toFixed(2)}</strong>
          <span>{reasons(result).join(" ")}</span>
        </>
      )}
    </div>
  );
}

/** What was mended and is to be known, of drawing, mesh and match. */
function Notes() {
  const isBegun = stage.value.kind === "open" && stage.value.isTaken;
  const read = reading.value?.of === drawing.value && !isBegun ? readingWarnings(reading.value) : [];
  const said = answer.value?.result.warnings.map(sentence) ?? [];
  const mended = mesh.value?.document.warnings.map(({ detail }) => sentence(detail)) ?? [];
  const groups = [
    { of: "Drawing", notes: read },
    { of: "Mesh", notes: mended },
    { of: "Match", notes: said },
  ].filter(({ notes }) => notes.length > 0);
  const count = groups.reduce((sum, { notes }) => sum + notes.length, 0);
  if (count === 0) return null;
  return (
    <details class="notes">
      <summary>{count === 1 ? "1 remark" : `${count} remarks`}</summary>
      <dl>
        {groups.map(({ of, notes }) => (
          <div key={of}>
            <dt>{of}</dt>
            {notes.map((note) => (
              <dd key={note}>{note}</dd>
            ))}
          </div>
        ))}
      </dl>
    </details>
  );
}
