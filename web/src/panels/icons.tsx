/** The pictures on buttons, drawn on a square of 24. */
const PATHS = {
  pen: "M4 20l1-4L16 5l3 3L8 19z M14 7l3 3",
  eraser: "M9 20h11 M4 15l9-9 6 6-8 8H9z M8.500 10.500l6 6",
  landmark: "M12 21s6-6.500 6-11a6 6 0 1 0-12 0c0 4.500 6 11 6 11z M12 8v4 M10 10h4",
  undo: "M8 5L4 9l4 4 M4 9h10a5 5 0 0 1 0 10h-3",
  redo: "M16 5l4 4-4 4 M20 9H10a5 5 0 0 0 0 10h3",
  symmetric: "M12 3v18 M9 7l-5 5 5 5z M15 7l5 5-5 5z",
  clear: "M5 7h14 M10 7V4h4v3 M7 7l1 13h8l1-13",
  file: "M12 15V4 M8 8l4-4 4 4 M4 15v5h16v-5",
  view: "M3 12s3.500-6 9-6 9 6 9 6-3.500 6-9 6-9-6-9-6z M12 9.500a2.500 2.500 0 1 0 0 5 2.500 2.500 0 1 0 0-5",
  mesh: "M12 3l8 5v8l-8 5-8-5V8z M4 8l8 5 8-5 M12 13v8",
  link: "M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1 M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1",
  pose: "M12 6.500a2 2 0 1 0 0-4 2 2 0 1 0 0 4 M12 6.500v8 M5 7l7 3 7-3 M8 21l4-6.500 4 6.500",
  plus: "M12 5v14 M5 12h14",
  play: "M8 5l11 7-11 7z",
  pause: "M9 5v14 M15 5v14",
  camera: "M4 8h3l2-3h6l2 3h3v11H4z M12 10a3.500 3.500 0 1 0 0 7 3.500 3.500 0 1 0 0-7",
  close: "M6 6l12 12 M18 6L6 18",
  down: "M6 9l6 6 6-6",
} as const;

export type IconName = keyof typeof PATHS;

export const Icon = ({ name }: { name: IconName }) => (
  <svg class="icon" viewBox="0 0 24 24" aria-hidden="true">
    <path d={PATHS[name]} />
  </svg>
);
