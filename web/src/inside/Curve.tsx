/** A curve with what its ends are called. */

const [WIDTH, HEIGHT] = [640, 260];
const MARGIN = { left: 70, right: 12, top: 12, bottom: 34 };

interface Props {
  values: number[];
  /** The least and the most that the axis shows. */
  range: [low: number, high: number];
  /** What its first and its last value are. */
  ends: [string, string];
  /** What is read out instead of it. */
  label: string;
}

export function Curve({ values, range: [low, high], ends, label }: Props) {
  const across = WIDTH - MARGIN.left - MARGIN.right;
  const down = HEIGHT - MARGIN.top - MARGIN.bottom;
  const x = (i: number) => MARGIN.left + (across * i) / (values.length - 1);
  const y = (value: number) => MARGIN.top + (down * (high - value)) / (high - low || 1);
  const line = values.map((value, i) => `${x(i).toFixed(1)} ${y(value).toFixed(1)}`).join("L");
  return (
    <svg class="curve" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={label}>
      <path class="axes" d={`M${MARGIN.left} ${MARGIN.top}v${down}h${across}`} />
      <path class="line" d={`M${line}`} />
      {[high, low].map((value) => (
        <text key={value} x={MARGIN.left - 8} y={y(value) + 5} text-anchor="end">
          {value.toPrecision(5)}
        </text>
      ))}
      {ends.map((end, i) => (
        <text key={end} x={x(i * (values.length - 1))} y={HEIGHT - 12} text-anchor={i === 0 ? "start" : "end"}>
          {end}
        </text>
      ))}
    </svg>
  );
}
