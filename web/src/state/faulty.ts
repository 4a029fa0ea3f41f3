/** The landmarks that the last request was refused for. */
import { computed } from "@preact/signals";
import { stage } from "./live";
import { faultyLandmarks } from "./request";

export const faulty = computed(() =>
  stage.value.kind === "refused"
    ? faultyLandmarks(stage.value.faults.map(({ pointer }) => pointer))
    : new Set<number>(),
);
