/** The match request that follows from what is chosen. */
import { computed } from "@preact/signals";
import type { MatchRequest } from "../api/types";
import { isYUp, turned } from "../drawing/drawing";
import type { Point } from "../geometry/flat";
import { components, landmarks, part, settings, up } from "./corrections";
import { drawing } from "./drawing";

/** A request without its shapes. */
export type Wishes = Omit<MatchRequest, "mesh" | "sketch">;

/** As text, which is the same as long as the same is asked for: half a landmark changes nothing. */
const text = computed(() => JSON.stringify(all()));

export const wishes = computed((): Wishes => JSON.parse(text.value));

function all(): Wishes {
  const yUp = isYUp(drawing.value);
  const pairs = landmarks.value.flatMap(({ at, vertex }) =>
    at && vertex !== null ? [{ sketch: [...turned(at, yUp)], mesh: vertex }] : [],
  );
  return {
    ...settings.value,
    ...(part.value && { part: part.value }),
    ...(components.value && { components: components.value }),
    ...(pairs.length > 0 && { landmarks: pairs }),
    ...upWish(yUp),
  };
}

function upWish(yUp: boolean): Pick<Wishes, "up"> {
  const { sketch, mesh } = up.value;
  if (sketch === undefined && mesh === undefined) return {};
  const direction = Array.isArray(sketch) ? [...turned(sketch as unknown as Point, yUp)] : sketch;
  return { up: { ...(direction !== undefined && { sketch: direction }), ...(mesh !== undefined && { mesh }) } };
}

/** The landmark that a fault of the request is about, by its number among those that were sent. */
export function faultyLandmarks(pointers: (string | null | undefined)[]): Set<number> {
  const sent = landmarks.value.filter(({ at, vertex }) => at && vertex !== null);
  const numbers = pointers.flatMap((pointer) => /^\/landmarks\/(\d+)/.exec(pointer ?? "")?.[1] ?? []);
  return new Set(numbers.flatMap((number) => sent[Number(number)]?.id ?? []));
}
